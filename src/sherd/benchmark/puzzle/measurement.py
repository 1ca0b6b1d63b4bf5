"""One puzzle put together, and beside it each piece matched alone: the baseline."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.assemble import assemble
from sherd.benchmark.metrics import evenly_spread
from sherd.benchmark.puzzle.sources import Puzzle, PuzzleSource
from sherd.errors import InfeasibleError
from sherd.match import match
from sherd.mesh.surface_points import SurfacePoints
from sherd.results.match_result import MatchResult
from sherd.results.status import Status
from sherd.spectral.surface_distances import SurfaceDistances
from sherd.surface.template import Template

__all__ = ["BAD", "Measured", "PuzzleRow", "measured_puzzle"]

# The mean error above which a placed piece is bad.
BAD = 0.10


@dataclass(frozen=True)
class Measured:
    """What was measured of one way to put a puzzle together.

    Attributes
    ----------
    labels
        Share of the whole's area that is given to its piece, or to the gap where that is right.
    errors
        Mean error of each own piece, in sqrt(area); NaN where it is refused.
    own_refused, foreign_refused
        Numbers of refused pieces.
    gap_iou
        Overlap of the found with the true gap, by area; NaN if nothing is missing.
    seconds
        Wall time, the whole being prepared.
    """

    labels: float
    errors: tuple[float, ...]
    own_refused: int
    foreign_refused: int
    gap_iou: float
    seconds: float

    @property
    def bad(self) -> int:
        """Number of bad pieces."""
        return sum(error > BAD for error in self.errors)


@dataclass(frozen=True)
class PuzzleRow:
    """One puzzle.

    Attributes
    ----------
    puzzle, group, count
        Its name, what it is averaged with, and into how many pieces the whole was cut.
    own, foreign
        Numbers of pieces of the whole and of other things.
    together, single
        Of :func:`sherd.assemble`, and of :func:`sherd.match` for each piece.
    """

    puzzle: str
    group: str
    count: int
    own: int
    foreign: int
    together: Measured
    single: Measured


def measured_puzzle(source: PuzzleSource) -> PuzzleRow:
    """Put one puzzle together and measure it.

    Raises
    ------
    MeshFileError
        If a file is missing or damaged.
    """
    puzzle = source.load()
    template = Template(puzzle.full)
    template.prepare()
    distances = SurfaceDistances(puzzle.full)
    meshes = [*(piece.mesh for piece in puzzle.own), *puzzle.foreign]
    start = time.perf_counter()
    answer = assemble(template, meshes, may_overlap=False)
    seconds = time.perf_counter() - start
    found = [piece.match if piece.placed else None for piece in answer.pieces]
    together = _measured(puzzle, found, answer.labels, seconds, distances)
    start = time.perf_counter()
    alone = [_single(template, mesh) for mesh in meshes]
    seconds = time.perf_counter() - start
    single = _measured(puzzle, alone, _single_labels(alone, len(answer.labels)), seconds, distances)
    return PuzzleRow(
        puzzle=source.name,
        group=source.group,
        count=source.count,
        own=len(puzzle.own),
        foreign=len(puzzle.foreign),
        together=together,
        single=single,
    )


def _single(template: Template, mesh: object) -> MatchResult | None:
    """The match of one piece; None if it is said not to belong."""
    try:
        result = match(template, mesh)
    except InfeasibleError:
        return None
    return None if result.status is Status.FOREIGN else result


def _single_labels(found: Sequence[MatchResult | None], count: int) -> Ints:
    """Each vertex to the piece whose region it is in, to the one of most membership if several."""
    membership = np.zeros((len(found) + 1, count))
    for number, result in enumerate(found):
        if result is not None:
            membership[number] = result.best.membership * result.best.mask
    labels: Ints = np.where(membership.max(axis=0) > 0, membership.argmax(axis=0), -1)
    return labels


def _measured(
    puzzle: Puzzle,
    found: Sequence[MatchResult | None],
    labels: Ints,
    seconds: float,
    distances: SurfaceDistances,
) -> Measured:
    own = len(puzzle.own)
    areas, allowed = puzzle.full.vertex_areas, puzzle.allowed
    row = np.where(labels < 0, own, np.minimum(labels, own))
    right = allowed[row, np.arange(len(labels))] & (labels < own)
    errors = tuple(
        math.nan if result is None else _error(piece.truth, piece.present, result.points, distances)
        for piece, result in zip(puzzle.own, found[:own], strict=True)
    )
    return Measured(
        labels=float(areas @ right / areas.sum()),
        errors=errors,
        own_refused=sum(result is None for result in found[:own]),
        foreign_refused=sum(result is None for result in found[own:]),
        gap_iou=_overlap(areas, labels < 0, puzzle.labels < 0),
        seconds=seconds,
    )


def _error(
    truth: SurfacePoints, present: Bools, points: SurfacePoints, distances: SurfaceDistances
) -> float:
    there = np.flatnonzero(present)
    some = there[evenly_spread(len(there))]
    return float(distances.between(truth[some], points[some]).mean())


def _overlap(areas: Floats, found: Bools, true: Bools) -> float:
    if not true.any():
        return math.nan
    return float(areas @ (found & true) / (areas @ (found | true)))
