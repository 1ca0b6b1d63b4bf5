"""join(pieces): which pieces belong together, and where each lies on the others; no whole."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, fields, replace
from functools import lru_cache, partial
from itertools import combinations, product
from types import MappingProxyType
from typing import Unpack

import numpy as np

from sherd.arrays import Bools, Ints
from sherd.correspondence.shared.hints import kept_shape
from sherd.errors import InfeasibleError, InputError, OptionError
from sherd.mesh.sizes import check_areas, most_of_one_scale
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.mesh.units import units_of_two
from sherd.output import Stages
from sherd.puzzle.growing.across import laid_across
from sherd.puzzle.growing.asking import Asking, remembering
from sherd.puzzle.growing.belonging import chance_as_a_part
from sherd.puzzle.growing.growth import grow
from sherd.puzzle.growing.joined_maps import direct_maps
from sherd.puzzle.growing.kinship import Kinship
from sherd.puzzle.growing.record import Growth
from sherd.puzzle.growing.two_units import QuestionInTwoUnits
from sherd.puzzle.growing.union import Join, Union
from sherd.puzzle.pairs import pair_evidence
from sherd.puzzle.pairwise.answer import Meeting
from sherd.puzzle.pairwise.body import Body, Told
from sherd.puzzle.pairwise.meeting import NOTHING_KNOWN, Describe, PairQuestion, pair_question
from sherd.puzzle.synchronization import PieceMap, cycle_error, synchronized
from sherd.results.keywords import options_of
from sherd.results.overlap_result import SharedMap
from sherd.results.puzzle.assemble_options import AssembleKeywords, AssembleOptions
from sherd.results.puzzle.joined import Joined, PairAnswer
from sherd.scan.either_side import looking_outward
from sherd.scan.intake import ScanSource, piece_intakes
from sherd.spectral.denoising import smoothed_alike
from sherd.surface.prepared import described_part
from sherd.surface.transformed import mirrored_mesh
from sherd.threads import one_blas_thread

__all__ = ["STAGES", "join"]

STAGES = ("evidence", "growth", "synchronization")

# What is asked of two unions, as in `Meet`, before it is answered at a glance or in full.
Ask = Callable[[Union, Union, Ints, Bools | None], QuestionInTwoUnits]


@one_blas_thread()  # or sums over 10,000 vertices would depend on how many there are
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
        See :class:`AssembleOptions`, of which only the seed counts without a whole; the defaults if
        None.
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
        If a keyword is unknown or needs a whole, or both `options` and keywords are given.
    InputError
        If there are fewer than two pieces.
    InfeasibleError
        If pieces are dots beside others, and half of them or more, so that they have no one unit;
        of fewer it is said in :attr:`Joined.notices`, and they are alone.
    MeshFileError, InvalidMeshError
        If a piece cannot be read or is no mesh.

    Notes
    -----
    A group grows from its largest piece: all others are asked, the surest is joined, and the union
    of both, in the pose of the larger, is asked again. The others are those that a few nodes of
    each pair rank first, at a tenth of the cost of a question. Seven pieces take about twenty
    questions. Where a union finds nothing its members are asked at a glance, each in its own pose.
    Pieces that share a tenth or less are mostly not found to belong together. At last
    what is more likely right than not is joined, too, if nothing contradicts it, and what lies
    across from its twin; see :attr:`Joined.likely` and :attr:`Joined.by_twin`. Who is left then is
    asked with the largest group bent as each of its members is. And what fills a gap of it
    somewhere, has its skin wherever that is, looks like a part of it or of its twin, is half likely
    to lie on it, or has skin that is recognized there, as it is or mirrored, belongs to it, though
    no map has it; see :attr:`Joined.unplaced`.

    Examples
    --------
    >>> from sherd.shapes import creature, puzzle_pieces
    >>> full, walking = creature(5000), creature(5000, pose="walk")
    >>> pieces = puzzle_pieces(full, [walking, full], overlap=0.5)
    >>> join([piece.mesh for piece in pieces]).groups
    ((0, 1),)
    """
    options = options_of(AssembleOptions, options, keywords)
    stages = stages or Stages(visible=False)
    intakes = [looking_outward(intake) for intake in piece_intakes(pieces)]
    if len(intakes) < 2:
        raise InputError(
            f"{len(intakes)} piece{'' if len(intakes) == 1 else 's'} given, but without a whole "
            "two pieces are needed"
        )
    _refuse_needless(options)
    kept = [
        kept_shape(intake, (), name=f"piece {number}").mesh for number, intake in enumerate(intakes)
    ]
    check_areas(*kept)
    numbers = _of_one_scale(kept)
    # each may be asked in two units, and a union that asks all others is one more
    describe = lru_cache(maxsize=2 * len(numbers) + 1)(described_part)
    with stages("evidence"):
        smooth = smoothed_alike([kept[k] for k in numbers], max(kept[k].length for k in numbers))
        unit = max(mesh.length for mesh in smooth.meshes)
        evidence = np.zeros((len(kept), len(kept)))
        evidence[np.ix_(numbers, numbers)] = pair_evidence(
            [describe(mesh, unit) for mesh in smooth.meshes], options.seed
        )
    with stages("growth"):
        growth = Growth.begun(
            [
                Union.of_piece(mesh, number)
                for number, mesh in zip(numbers, smooth.meshes, strict=True)
            ]
        )
        # one body asks all that are left at last
        body = lru_cache(maxsize=1)(partial(Body, seed=options.seed))
        kin = Kinship(lambda k: describe(growth.pieces[k].mesh, growth.length_of_whole))
        asking = _Asking(partial(_question, options.seed, growth, describe), body, kin, stages)
        grow(growth, evidence, asking.ways)
    originals = [intake.original for intake in intakes]
    with stages("synchronization"):
        # of members that told their unions the own answer says more than that of the unions
        direct = direct_maps(originals, [*growth.joins, *_told(growth)])
        maps = synchronized(originals, direct, unit)
        errors = (
            cycle_error(originals, direct, unit),
            cycle_error(originals, maps, unit),
        )
    chances = _chances(growth)
    said = {**_of_another_scale(kept, numbers), **dict(zip(numbers, smooth.notices, strict=True))}
    return Joined(
        pieces=tuple(originals),
        groups=_groups(growth, len(kept)),
        pairs=tuple(
            sorted(
                (
                    PairAnswer(
                        first=i,
                        second=j,
                        evidence=float(evidence[i, j]),
                        asked=(i, j) in chances,
                        chance=chances.get((i, j), 0.0),
                        joined=(i, j) in direct or (j, i) in direct,
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
        notices=tuple(
            (*intake.notices, *said.get(number, ())) for number, intake in enumerate(intakes)
        ),
        likely=MappingProxyType(growth.last_chances()),
        sure=len(growth.joins) > len(growth.last),
        by_twin=tuple(sorted(member for join in growth.across for member in join.second.members)),
        unplaced=tuple(sorted(growth.unplaced)),
    )


def _refuse_needless(options: AssembleOptions) -> None:
    """Only the seed counts without a whole; nothing else is to seem to."""
    for each in fields(options):
        value = getattr(options, each.name)
        if each.name != "seed" and value != each.default:
            raise OptionError(
                f"{each.name} is {value!r}, but that needs a whole: give one, or leave it out"
            )


def _of_one_scale(pieces: Sequence[TriangleMesh]) -> tuple[int, ...]:
    """The numbers of most pieces, none of which is a dot beside another one of them.

    Raises
    ------
    InfeasibleError
        If these are no more than half of all, so nobody knows who has another unit.
    """
    numbers = most_of_one_scale([mesh.area for mesh in pieces])
    if 2 * len(numbers) <= len(pieces):
        smallest, *_, largest = sorted(pieces, key=lambda mesh: mesh.area)
        raise InfeasibleError(f"{_beside(smallest, largest)}, so nothing can be found")
    return numbers


def _of_another_scale(
    pieces: Sequence[TriangleMesh], numbers: Sequence[int]
) -> dict[int, tuple[str]]:
    """What is said of those that were not asked, by number."""
    largest = max((pieces[k] for k in numbers), key=lambda mesh: mesh.area)
    return {
        number: (f"{_beside(mesh, largest)}, so it was not compared with the others",)
        for number, mesh in enumerate(pieces)
        if number not in numbers
    }


def _beside(piece: TriangleMesh, other: TriangleMesh) -> str:
    """How much larger or smaller one is, and which units would explain that."""
    ratio = piece.area / other.area
    proposal = units_of_two(piece.name, other.name, math.sqrt(ratio))
    said = f"{piece.name} has {ratio:.4g} times the area of {other.name}"
    return f"{said} ({proposal or 'are the two in different units?'})"


def _question(
    seed: int,
    growth: Growth,
    describe: Describe,
    first: Union,
    second: Union,
    known: Ints,
    taken: Bools | None,
) -> QuestionInTwoUnits:
    """See :data:`sherd.puzzle.growing.asking.Meet`; what grew says how large the whole is."""

    def asked_in(unit: float) -> PairQuestion:
        return pair_question(first.mesh, second.mesh, seed, known, taken, describe, unit)

    return QuestionInTwoUnits(first, second, growth.length_of_whole, asked_in)


@dataclass(frozen=True)
class _Asking:
    """What unions share, asked while the terminal says of which; see :func:`pair_question`."""

    question: Ask
    body: Callable[[TriangleMesh], Body]
    kin: Kinship
    stages: Stages

    @property
    def ways(self) -> Asking:
        """All of them."""
        meet = remembering(self.met)
        return Asking(
            meet,
            self.glance,
            self.laid,
            self.across,
            self.as_a_part,
            self.mirrored,
            self.kinship,
        )

    def met(self, first: Union, second: Union, known: Ints, taken: Bools | None) -> Meeting:
        """All that is known."""
        self.stages.show(f"growth: {_named(first)} and {_named(second)}")
        return self.question(first, second, known, taken).in_full()

    def glance(self, first: Union, second: Union) -> Meeting:
        """Of two pieces, what is plain to see."""
        self.stages.show(f"growth: {_named(first)} and {_named(second)}")
        return self.question(first, second, NOTHING_KNOWN, None).at_a_glance()

    def laid(self, first: Union, second: Union, told: Told) -> Meeting:
        """Both where that is told."""
        return self.body(first.mesh).met(second.mesh, told)

    def across(self, first: Union, second: Union) -> Meeting | None:
        """Where the second lies across from its twin; see :func:`laid_across`."""
        self.stages.show(f"growth: {_named(first)} and the mirror image of {_named(second)}")
        return laid_across(self.body(first.mesh), second.mesh)

    def as_a_part(self, first: Union, second: Union) -> float:
        """Whether the second belongs, wherever it lies; see :func:`chance_as_a_part`."""
        self.stages.show(f"growth: {_named(second)} as a part of {_named(first)}")
        return chance_as_a_part(self.body(first.mesh), second.mesh)

    def mirrored(self, first: Union, second: Union) -> Meeting:
        """Of two pieces, the second mirrored, what is plain to see."""
        self.stages.show(f"growth: {_named(first)} and the mirror image of {_named(second)}")
        image = replace(second, mesh=mirrored_mesh(second.mesh))
        return self.question(first, image, NOTHING_KNOWN, None).at_a_glance()

    def kinship(self, numbers: Collection[int], others: Collection[int]) -> float:
        """Whether some have the skin of others; see :class:`Kinship`."""
        self.stages.show(f"growth: the skin of {_listed(numbers)}")
        return self.kin.of(numbers, others)


def _named(union: Union) -> str:
    """Its members as the files are numbered: `2`, or `0+2+5`."""
    return _listed(union.members)


def _listed(numbers: Collection[int]) -> str:
    return "+".join(str(number) for number in sorted(numbers))


def _chances(growth: Growth) -> dict[tuple[int, int], float]:
    """Of each two pieces that were on different sides of a question the highest chance."""
    found: dict[tuple[int, int], float] = {}
    for (first, second), chance in [*growth.chances.items(), *growth.of_members.items()]:
        for one, other in product(first, second):
            pair = (min(one, other), max(one, other))
            found[pair] = max(chance, found.get(pair, 0.0))
    return found


def _told(growth: Growth) -> list[Join]:
    """What members said that were asked in their own poses, and that was joined."""
    made = {(join.first.members, join.second.members) for join in growth.joins}
    return [before for key, before in growth.told.items() if key in made]


def _shared(found: PieceMap) -> SharedMap:
    return SharedMap(
        found.points,
        found.known,
        found.known.astype(np.float64),
        np.where(found.known, found.trust, 0.0),
    )


def _groups(growth: Growth, count: int) -> tuple[tuple[int, ...], ...]:
    """Those that grew, and each of so many pieces that was not asked alone."""
    groups = [tuple(sorted(group)) for group in growth.groups]
    groups += [(number,) for number in range(count) if number not in growth.pieces]
    return tuple(sorted(groups, key=lambda group: (-len(group), group)))
