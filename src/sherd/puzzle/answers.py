"""The answer of a puzzle: points, labels, memberships, gaps and contacts as the user counts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.match import judged_result
from sherd.output import Stages
from sherd.place import PlacedPart
from sherd.puzzle.border import REACH, border_of
from sherd.puzzle.borders import fits_of
from sherd.puzzle.joint_choice import shared_areas
from sherd.puzzle.partition import GAP, Partition
from sherd.puzzle.rigid.rigid_answer import rigid_answer
from sherd.puzzle.rigid.rigid_trials import RigidPart
from sherd.puzzle.siblings import beside_siblings, is_less_alike
from sherd.puzzle.trials import CLASH, Together, Trial, clashes
from sherd.region.coverage import smoothed
from sherd.results.advice import SURE
from sherd.results.match_result import MatchResult
from sherd.results.puzzle.assemble_options import AssembleOptions
from sherd.results.puzzle.assembly import Assembly, Contact, Gap, PieceAnswer, SharedPlace
from sherd.results.status import Status
from sherd.scan.intake import Intake
from sherd.surface.template import Template

__all__ = ["AssemblyQuestion", "Decision", "assembly_of"]

# Two pieces share a place if that is more than a strip two vertex spacings wide along a border as
# long as the smaller one is wide; below it borders are merely inexact. As a share of the smaller.
SHARED = 0.05
# A piece of which so much lies on another one lies there wholly, but for where borders are inexact.
WHOLLY = 0.9


@dataclass(frozen=True, eq=False)
class AssemblyQuestion:
    """What was asked.

    Attributes
    ----------
    template, pieces
        The full shape and the pieces as they came in.
    partition
        Of the full shape.
    options
        As given.
    """

    template: Template
    pieces: Sequence[Intake]
    partition: Partition
    options: AssembleOptions


@dataclass(frozen=True, eq=False)
class Decision:
    """What was decided.

    Attributes
    ----------
    trials
        All that were made, the first of each piece being the one of it alone.
    together
        Which of them were chosen.
    placed
        By piece the placement that was chosen, with borders drawn together.
    impossible
        By piece why it cannot lie on the full shape at all.
    cut_apart
        Whether the pieces meet where they were cut, so that a crack between two is none.
    """

    trials: Sequence[Trial]
    together: Together
    placed: Mapping[int, PlacedPart]
    impossible: Mapping[int, str]
    cut_apart: bool


def assembly_of(question: AssemblyQuestion, decision: Decision, stages: Stages) -> Assembly:
    """The answer, once it is known which pieces are placed, and where."""
    template, placed = question.template, decision.placed
    answers = [
        _answer(piece, intake, decision, question.options, stages)
        for piece, intake in enumerate(question.pieces)
    ]
    with stages("partition"):
        numbers = np.array([*placed, GAP], dtype=np.int64)
        rows = question.partition.labels([part.best.mask for part in placed.values()])
        if decision.cut_apart:
            rows = question.partition.without_cracks(rows, REACH)
        if not question.options.rigid:  # what does not stretch reaches all that belongs to it
            rows = question.partition.without_lapses(rows, _ends(placed.values()))
        labels = numbers[rows]
        shared = _shared(template, placed)
        lift = template.intake.report.to_original
        return Assembly(
            full=template.full,
            pieces=tuple(answers),
            labels=np.asarray(lift(labels, fill=GAP), dtype=np.int64),
            memberships=np.array(
                [lift(row, fill=0.0) for row in _memberships(template, labels, len(answers))]
            ),
            gaps=_gaps(question, labels),
            contacts=_contacts(question, labels, placed, shared),
            shared=shared,
            energy=decision.together.energy,
            timings=MappingProxyType(dict(stages.seconds)),
            options=question.options,
            notices=template.intake.notices,
            proven=decision.together.proven,
        )


def _answer(
    piece: int, intake: Intake, decision: Decision, options: AssembleOptions, stages: Stages
) -> PieceAnswer:
    if piece in decision.impossible:
        reason = decision.impossible[piece]
        return PieceAnswer(intake.original, placed=False, reason=reason, chance=0.0)
    if piece in decision.placed:
        trial = replace(
            decision.together.trials[piece], placed=_beside_others(piece, decision.placed)
        )
        result = _result(trial, trial.chance, options, stages)
        return PieceAnswer(
            result.part,
            placed=True,
            reason=_place_words(trial, result, decision),
            chance=trial.chance if result.chance is None else result.chance,
            match=result,
            transform=None if trial.motion is None else trial.motion.matrix,
        )
    alone = next(trial for trial in decision.trials if trial.piece == piece)
    result = _result(alone, alone.placed.chance, options, stages)
    instead = None if result.status is Status.FOREIGN else _rival(alone, decision.together.trials)
    seen = alone.with_chance(alone.lowered(alone.chance))
    areas = alone.placed.template.placed.vertex_areas
    chance = beside_siblings(seen, decision.together.trials.values(), areas).chance
    return PieceAnswer(
        result.part,
        placed=False,
        reason=_refusal(alone, instead, chance, _share_on(alone, instead, decision)),
        chance=chance,
        match=result,
        instead=instead,
    )


def _result(trial: Trial, chance: float, options: AssembleOptions, stages: Stages) -> MatchResult:
    """What to think of a piece where it lies with this chance, rigid or not."""
    result = judged_result(trial.placed, chance, stages)
    if trial.motion is None:
        return result
    return rigid_answer(result, trial.motion, chance, options.closeness)


def _place_words(trial: Trial, result: MatchResult, decision: Decision) -> str:
    """What to think of the place of a piece, and who takes what a match advises to give."""
    if result.status is Status.GOOD or trial.motion is not None:
        return result.advice
    said = result.advice
    areas = trial.placed.template.placed.vertex_areas
    if is_less_alike(trial, decision.together.trials.values(), areas):
        said += (
            "; its skin is far less alike there than that of the other pieces, so it may be of "
            "something else, or lie beside its place"
        )
    return f"{said}; landmarks and units can be given to sherd match, of this piece alone"


def _beside_others(piece: int, placed: Mapping[int, PlacedPart]) -> PlacedPart:
    """A placed piece; where it lies as well is no doubt of its place if others have that."""
    own = placed[piece]
    if own.rival is None:
        return own
    areas = own.template.placed.vertex_areas
    taken = np.logical_or.reduce(
        [np.zeros(len(areas), dtype=bool), *(placed[k].best.mask for k in placed if k != piece)]
    )
    there = own.rival.mask
    free = float(areas @ (there & ~taken)) >= (1.0 - CLASH) * float(areas @ there)
    return own if free else replace(own, rival=None)


def _rival(alone: Trial, chosen: Mapping[int, Trial]) -> int | None:
    """The placed piece that has most of the place where a piece would lie alone."""
    others = list(chosen.values())
    areas = alone.placed.template.placed.vertex_areas
    rivals = clashes([alone, *others], areas).get(alone.piece, set())
    core = alone.candidate.core
    return max(rivals, key=lambda k: float(areas @ (core & chosen[k].candidate.core)), default=None)


def _share_on(alone: Trial, instead: int | None, decision: Decision) -> float:
    """Share of the place of a piece alone that another one has."""
    if instead is None:
        return 0.0
    areas = alone.placed.template.placed.vertex_areas
    own, other = alone.candidate.region, decision.together.trials[instead].candidate.region
    return float(areas @ (own & other)) / float(areas @ own)


def _refusal(alone: Trial, instead: int | None, chance: float, share: float) -> str:
    if instead is not None and share < WHOLLY:
        return (
            f"has {share:.0%} of its place where piece {instead} lies, which fits better; "
            "elsewhere nothing is alike enough; if these are scans that overlap let them "
            "(--may-overlap)"
        )
    if instead is not None:
        return (
            f"fits only where piece {instead} lies, which fits better; elsewhere nothing is alike "
            "enough"
        )
    if isinstance(alone.placed, RigidPart) and alone.placed.anywhere:
        return (
            "fits about as closely in several places, so none is told: what is round fits all "
            "around, what is alike on several sides on each, and so does a piece of another such "
            "thing, or one that is bent; larger pieces may tell; if it is bent leave rigid out"
        )
    if chance >= SURE:
        return (
            f"fits with a chance of {chance:.2f}, but has too little area for its border to "
            "be told from one that fits by accident; give a larger piece"
        )
    said = f"does not belong: the chance that its best place is right is {chance:.2f}; "
    if isinstance(alone.placed, RigidPart):
        return (
            f"{said}if it is worn or coarse give a larger tolerance, if it is bent leave rigid "
            "out, or ask with another full shape"
        )
    return f"{said}ask with another full shape, or look at it alone with sherd match"


def _memberships(template: Template, labels: Ints, count: int) -> Floats:
    """(k, n) soft memberships; with that of the gap they are at least 0 and sum to 1."""
    soft = np.array([smoothed(template.placed, labels == k) for k in (*range(count), GAP)])
    # each is smoothed by the same operator, so the sum is 1 but for the tolerance of the solver
    result: Floats = (soft / soft.sum(axis=0))[:count]
    return result


def _gaps(question: AssemblyQuestion, labels: Ints) -> tuple[Gap, ...]:
    template, partition = question.template, question.partition
    area, owner = template.placed.vertex_areas, template.intake.report.original_vertices
    unit = template.length**2
    return tuple(
        Gap(
            area=float(area[some].sum()) * unit,
            vertex=int(owner[partition.deepest(some)]),
            vertex_count=len(some),
        )
        for some in partition.gaps(labels)
    )


def _ends(placed: Iterable[PlacedPart]) -> Floats:
    """(p, 3) points on the borders of all placed pieces."""
    borders = [
        border_of(part.question.part.mesh, part.best.deformation.positions).positions
        for part in placed
    ]
    return np.concatenate(borders) if borders else np.empty((0, 3))


def _contacts(
    question: AssemblyQuestion,
    labels: Ints,
    placed: Mapping[int, PlacedPart],
    shared: Sequence[SharedPlace],
) -> tuple[Contact, ...]:
    numbers, unit = list(placed), question.template.length
    overlapping = [{place.first, place.second} for place in shared]
    fits = fits_of(
        [part.question for part in placed.values()], [part.best for part in placed.values()]
    )
    found = []
    for (one, other), length in question.partition.touching(labels).items():
        ends = (
            (numbers.index(one), numbers.index(other)),
            (numbers.index(other), numbers.index(one)),
        )
        gap = np.concatenate([fits[here].gap[fits[here].piece == there] for here, there in ends])
        apart = float(np.abs(gap).mean()) * unit if len(gap) else float("nan")
        open_by = float(gap.mean()) * unit if len(gap) else float("nan")
        if open_by > 0 and {one, other} in overlapping:
            # each has its border inside the other; what is near are borders of something else
            apart = open_by = float("nan")
        found.append(Contact(one, other, length * unit, apart, open_by))
    return tuple(sorted(found, key=lambda contact: -contact.length))


def _shared(template: Template, placed: Mapping[int, PlacedPart]) -> tuple[SharedPlace, ...]:
    if not placed:
        return ()
    numbers, unit = list(placed), template.length**2
    areas = template.placed.vertex_areas
    table = shared_areas([part.best.mask for part in placed.values()], areas)
    found = [
        SharedPlace(numbers[here], numbers[there], float(table[here, there]) * unit)
        for here in range(len(numbers))
        for there in range(here + 1, len(numbers))
        if table[here, there] > SHARED * min(table[here, here], table[there, there])
    ]
    return tuple(sorted(found, key=lambda place: -place.area))
