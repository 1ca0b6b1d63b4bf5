"""join(pieces): which pieces belong together, and where each lies on the others; no whole."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from types import MappingProxyType
from typing import Unpack

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from sherd.correspondence.shared.hints import KeptShape, kept_shape
from sherd.errors import InputError
from sherd.output import Stages
from sherd.overlap import (
    check_overlap_sizes,
    described_pair,
    prepare_both_ways,
    questions_of,
    shared_by,
)
from sherd.puzzle.pairs import pair_evidence, pairs_to_ask
from sherd.puzzle.synchronization import PieceMap, consistent_pairs, cycle_error, synchronized
from sherd.results.advice import SURE
from sherd.results.keywords import options_of
from sherd.results.overlap_options import OverlapOptions
from sherd.results.overlap_result import Overlap, SharedMap
from sherd.results.puzzle.assemble_options import AssembleKeywords, AssembleOptions
from sherd.results.puzzle.joined import Joined, PairAnswer
from sherd.results.status import Status
from sherd.scan.intake import ScanSource, scan_intake
from sherd.surface.described import DescribedSurface
from sherd.surface.prepared import described_part

__all__ = ["STAGES", "join"]

# Then the stages of each pair that is asked.
STAGES = ("pieces", "evidence", "synchronization")
# Neighborhoods are as wide as the largest piece of all asks for, and an arm and a leg look alike in
# them. Two pieces that are both smaller than this many times that are described again as a pair
# alone would be: chances were fitted to such descriptions.
SMALL = 0.8
NO_LANDMARKS = np.empty((0, 4), dtype=np.int64)


def join(
    pieces: Sequence[ScanSource],
    options: AssembleOptions | None = None,
    *,
    stages: Stages | None = None,
    **keywords: Unpack[AssembleKeywords],
) -> Joined:
    """Find which pieces belong together, and where each lies on the others it overlaps.

    Parameters
    ----------
    pieces
        The pieces: deformed, in any pose; whatever :func:`sherd.match` takes for a part, all in one
        unit. Those that belong together must overlap.
    options
        See :class:`AssembleOptions`, of which only the seed counts here; the defaults if None.
    stages
        Collects timings and shows progress; a silent one if None.
    keywords
        The fields of :class:`AssembleOptions`, instead of `options`.

    Returns
    -------
    Joined
        Groups, and consistent maps within each; foreign pieces are alone.

    Raises
    ------
    OptionError
        If a keyword is unknown, or both `options` and keywords are given.
    InputError
        If there are fewer than two pieces, or pieces shall be rigid, which needs a whole.
    InfeasibleError
        If a piece is a dot beside the largest.
    MeshFileError, InvalidMeshError
        If a piece cannot be read or is no mesh.

    Notes
    -----
    Every piece is described once, and again with another one where both are small. All pairs are
    compared by a few nodes, at a tenth of the cost of a full question; only the best few of each
    piece, and a tree over all, are asked in full, and none that has no more evidence than unrelated
    pieces have. Pieces that share a tenth or less are mostly not found to belong together.

    Examples
    --------
    >>> from sherd.shapes import creature, puzzle_pieces
    >>> full, walking = creature(5000), creature(5000, pose="walk")
    >>> pieces = puzzle_pieces(full, [walking, full], overlap=0.3)
    >>> join([piece.mesh for piece in pieces]).groups
    ((0, 1),)
    """
    options = options_of(AssembleOptions, options, keywords)
    stages = stages or Stages(visible=False)
    intakes = [scan_intake(piece) for piece in pieces]
    if len(intakes) < 2:
        raise InputError(f"{len(intakes)} pieces were given, but without a whole two are needed")
    if options.rigid:
        raise InputError("rigid pieces are placed on a whole; give one, or leave rigid out")
    shapes = [
        kept_shape(intake, (), name=f"piece {number}") for number, intake in enumerate(intakes)
    ]
    largest = max(shapes, key=lambda shape: shape.mesh.area)
    for shape in shapes:
        check_overlap_sizes((largest, shape), 1.0)
    unit = largest.mesh.length
    with stages("pieces"):
        surfaces = [described_part(shape.mesh, unit) for shape in shapes]
        for surface in surfaces:
            prepare_both_ways(surface)
    with stages("evidence"):
        evidence = pair_evidence(surfaces, options.seed)
        asked = pairs_to_ask(evidence)
    answers = {pair: _answer(shapes, surfaces, pair, unit, options.seed, stages) for pair in asked}
    joined = [pair for pair, answer in answers.items() if _belongs(answer)]
    originals = [intake.original for intake in intakes]
    with stages("synchronization"):
        chances = {pair: answers[pair].chance for pair in joined}
        all_maps = _direct_maps(answers, joined)
        trusted = consistent_pairs(originals, all_maps, chances, unit)
        direct = _direct_maps(answers, trusted)
        maps = synchronized(originals, direct, unit)
        errors = (
            cycle_error(originals, all_maps, unit),
            cycle_error(originals, {pair: maps[pair] for pair in direct if pair in maps}, unit),
        )
    return Joined(
        pieces=tuple(originals),
        groups=_groups(len(intakes), trusted),
        pairs=tuple(
            sorted(
                (
                    PairAnswer(
                        first=i,
                        second=j,
                        evidence=float(evidence[i, j]),
                        asked=(i, j) in answers,
                        chance=answers[i, j].chance if (i, j) in answers else 0.0,
                        joined=(i, j) in trusted,
                    )
                    for i, j in combinations(range(len(intakes)), 2)
                ),
                key=lambda pair: -pair.evidence,
            )
        ),
        maps=MappingProxyType({pair: _shared(found) for pair, found in maps.items()}),
        cycle_before=errors[0],
        cycle_after=errors[1],
        timings=MappingProxyType(dict(stages.seconds)),
        options=options,
        notices=tuple(intake.notices for intake in intakes),
    )


def _answer(
    shapes: Sequence[KeptShape],
    surfaces: Sequence[DescribedSurface],
    pair: tuple[int, int],
    unit: float,
    seed: int,
    stages: Stages,
) -> Overlap:
    """What two pieces share; as :func:`sherd.overlap` would say it where both are small."""
    first, second = pair
    own, both = (shapes[first], shapes[second]), (surfaces[first], surfaces[second])
    if max(shape.mesh.length for shape in own) < SMALL * unit:
        both = described_pair(own, 1.0, NO_LANDMARKS)
    return shared_by(
        own,
        both,
        questions_of(both, NO_LANDMARKS, unknown=False),
        OverlapOptions(seed=seed),
        stages,
    )


def _belongs(answer: Overlap) -> bool:
    return answer.status is not Status.FOREIGN and answer.chance >= SURE


def _direct_maps(
    answers: Mapping[tuple[int, int], Overlap], joined: Sequence[tuple[int, int]]
) -> dict[tuple[int, int], PieceMap]:
    found = {}
    for first, second in joined:
        answer = answers[first, second]
        found[first, second] = _piece_map(answer.first_to_second)
        found[second, first] = _piece_map(answer.second_to_first)
    return found


def _piece_map(found: SharedMap) -> PieceMap:
    return PieceMap(found.points, found.matched, found.confidence)


def _shared(found: PieceMap) -> SharedMap:
    return SharedMap(found.points, found.known, found.known.astype(np.float64), found.trust)


def _groups(count: int, joined: Sequence[tuple[int, int]]) -> tuple[tuple[int, ...], ...]:
    pairs = np.array(joined, dtype=np.int64).reshape(-1, 2)
    links = sparse.coo_array(
        (np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count)
    )
    number, labels = csgraph.connected_components(links.tocsr(), directed=False)
    groups = [tuple(np.flatnonzero(labels == group).tolist()) for group in range(number)]
    return tuple(sorted(groups, key=lambda group: (-len(group), group)))
