"""Further trials: pieces that lose their places or are in doubt, placed again by what is known."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from sherd.arrays import Bools, Floats, Ints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import Stages
from sherd.place import labeled_again, laid_part
from sherd.puzzle.border import REACH
from sherd.puzzle.joint_choice import LEAST_CHANCE
from sherd.puzzle.partition import Partition
from sherd.puzzle.trials import (
    CLASH,
    MARGIN,
    SCORE_SCALE,
    Trial,
    chosen_together,
    clashes,
    trials_of,
)
from sherd.results.advice import SURE
from sherd.surface.template import Template

__all__ = ["torn_apart", "trials_again"]

# A connected piece lies in one place. Of a region in several, those count that have so much of its
# area; smaller ones are noise of its border.
TORN = 0.1
# Poses change the area of a piece by up to a third; where less than half of it is left, cracks
# between the others not counted, it can only lie somewhere else.
ROOM = 0.5
# What pieces that are right together cover in all: the whole, and a tenth that they may overlap.
ALL = 1.1
# What is taken differs by less than a tenth of the piece: the strip along its border by which
# placements are off. The same labels are left for its nodes then.
SAME = 0.1


def trials_again(
    template: Template,
    trials: Sequence[Trial],
    count: int,
    stages: Stages,
    *,
    may_overlap: bool = False,
) -> list[Trial]:
    """Further trials of the pieces that lose their places or are in doubt.

    Large ones come first; what is chosen jointly of all trials so far is taken for the next piece.
    Each is tried where no other piece lies, if one lies where it would; also what is sure but lies
    on others by more than right neighbors do. A piece that is torn between two places is tried
    without either. Then the pieces that keep one from its place which found none, or a worse one,
    are tried without that place, as both may be right only together: those that have all of it, and
    those in doubt that reach into it. At last what is in doubt or has no place is tried where
    nothing lies by then, what has one that leaves another a chance to be taken is tried in the
    gaps: a left leg on the right one's place, which is missing; and two in doubt that could change
    places, as front legs on hind legs, are tried so. What has no place even then is tried in each
    gap of about its size, and nowhere else: what looks like other places, or like cracks between
    others, tears it no more. Nothing is asked twice, nor where there is no room for it.

    Parameters
    ----------
    template, stages
        As in :func:`sherd.puzzle.trials.trials_alone`.
    trials
        What that found.
    count
        Number of pieces.
    may_overlap
        As in :func:`sherd.puzzle.joint_choice.joint_choice`.
    """
    areas = template.placed.vertex_areas
    alone: dict[int, Trial] = {}
    for trial in trials:
        alone.setdefault(trial.piece, trial)
    by_size = sorted(alone.values(), key=lambda each: -float(areas @ each.candidate.region))
    so_far = _SoFar(template, trials, count, stages, may_overlap=may_overlap)
    for first in by_size:
        _where_nothing_lies(so_far, first, template.placed)
    for loser in by_size:
        chosen = so_far.chosen()
        if _room_for_all({**chosen, loser.piece: loser}.values()):
            for winner in sorted(_winners(loser, chosen, areas)):
                # as if the loser lay there: where it went meanwhile may be the winner's place
                others = [each for each in so_far.without(winner)[1] if each.piece != loser.piece]
                so_far.ask(alone[winner], [*others, loser])
    for first in by_size:
        _in_gaps(so_far, first)
    for one, other in _exchangeable(so_far.chosen(), areas):
        _in_its_place(so_far, alone[one], other)
        _in_its_place(so_far, alone[other], one)
    for first in by_size:
        so_far.ask_in_gaps(first)
    return so_far.known[len(trials) :]


class _SoFar:
    """The trials so far, and what was asked of each piece."""

    def __init__(
        self,
        template: Template,
        trials: Sequence[Trial],
        count: int,
        stages: Stages,
        *,
        may_overlap: bool,
    ) -> None:
        self.known = list(trials)
        self._template, self._count, self._stages = template, count, stages
        self._may_overlap = may_overlap
        self._areas = template.placed.vertex_areas
        self._asked: dict[int, list[Bools]] = {}
        self._chosen: dict[int, Trial] | None = None

    def chosen(self) -> dict[int, Trial]:
        """By piece what is chosen jointly of all trials."""
        if self._chosen is None:
            self._chosen = chosen_together(
                self.known, self._count, self._areas, may_overlap=self._may_overlap
            ).trials
        return dict(self._chosen)

    def without(self, piece: int) -> tuple[Trial | None, list[Trial]]:
        """The chosen trial of a piece, None if it has no place, and those of the others."""
        chosen = self.chosen()
        own = chosen.pop(piece, None)
        return own, list(chosen.values())

    def ask(self, first: Trial, others: Sequence[Trial], place: Bools | None = None) -> None:
        """Place a piece once more, where no other lies, and not at a place (n,) either.

        Unless nothing is in its way, it has no room, or much the same was asked.
        """
        size = first.placed.question.part.mesh.area
        taken = _taken(others, len(self._areas))
        full = np.logical_or.reduce([taken, *(each.candidate.region for each in others)])
        if place is not None:
            taken, full = taken | place, full | place
        room = float(self._areas @ first.partition.core(~full, MARGIN))
        if (taken & first.candidate.core).any() and room >= ROOM * size:
            self._ask(first, taken)

    def ask_in_gaps(self, first: Trial) -> None:
        """Place a piece that has no place in each of the gaps that are as large as it is."""
        own, others = self.without(first.piece)
        if own is not None or not others:
            return
        size = first.placed.question.part.mesh.area
        for gap in _gaps(others, first.partition):
            if ROOM * size <= float(self._areas[gap].sum()) <= size / ROOM:
                free = np.zeros(len(self._areas), dtype=bool)
                free[gap] = True
                self._ask(first, ~first.partition.grown(free, MARGIN))

    def _ask(self, first: Trial, taken: Bools) -> None:
        """Place a piece once more where nothing is taken (n,), unless much the same was asked."""
        size = first.placed.question.part.mesh.area
        asked = self._asked.setdefault(first.piece, [])
        if all(float(self._areas @ (taken ^ each)) >= SAME * size for each in asked):
            asked.append(taken)
            self.known += _elsewhere(self._template, first, taken, self._stages)
            self._chosen = None


def _where_nothing_lies(so_far: _SoFar, first: Trial, full: TriangleMesh) -> None:
    """Try a piece that is in doubt, or lies on others, where none of the others lies."""
    own, others = so_far.without(first.piece)
    if own is not None and own.chance >= SURE and not _lies_on(own, others, full.vertex_areas):
        return
    so_far.ask(first, others)
    for place in _torn_places(full, first):
        so_far.ask(first, others, place)


def _in_gaps(so_far: _SoFar, first: Trial) -> None:
    """Try a piece in doubt where nothing lies, and one whose place may be another's elsewhere."""
    own, others = so_far.without(first.piece)
    if own is None or own.chance < SURE:
        so_far.ask(first, others)
    if own is not None and own.chance < 1 - LEAST_CHANCE:
        so_far.ask(first, others, own.candidate.core)


def _in_its_place(so_far: _SoFar, first: Trial, second: int) -> None:
    """Try a piece that has a place elsewhere, as if the second piece had none."""
    own, others = so_far.without(first.piece)
    if own is not None:
        others = [each for each in others if each.piece != second]
        so_far.ask(first, others, own.candidate.core)


def _taken(chosen: Iterable[Trial], count: int) -> Bools:
    """(n,) what these surely claim."""
    taken: Bools = np.zeros(count, dtype=bool)
    for trial in chosen:
        taken |= trial.candidate.core
    return taken


def _gaps(chosen: Sequence[Trial], partition: Partition) -> list[Ints]:
    """The vertices of each gap that these leave, without cracks between them."""
    labels = partition.labels([trial.candidate.region for trial in chosen])
    ends = np.concatenate([trial.candidate.border.positions for trial in chosen])
    return partition.gaps(partition.without_lapses(partition.without_cracks(labels, REACH), ends))


def _elsewhere(template: Template, first: Trial, taken: Bools, stages: Stages) -> list[Trial]:
    """The piece of a trial placed once more, where nothing is taken (n,) yet."""
    if not taken.any() or taken.all():
        return []
    old = first.placed
    free = _on_mesh(template, ~taken)
    placed = laid_part(labeled_again(old, free, stages), stages)
    # what fits much worse than where the piece lies alone is no place for it
    loss = min(placed.best.score - old.best.score, 0.0)
    less = float(np.exp(loss / SCORE_SCALE))
    return [
        trial.with_chance(less * trial.chance)
        for trial in trials_of(first.piece, placed, first.partition)
    ]


def _torn_places(full: TriangleMesh, first: Trial) -> list[Bools]:
    """The places (n,) between which a trial in doubt is torn, the largest first; none if it is not.

    A labeling is a compromise where parts of a piece look more like another place than like their
    own: the tip of a tail like a toe. Without the other place it would not have been made.
    """
    if first.chance >= SURE:
        return []
    placed = first.placed
    pieces = torn_apart(
        placed.question.part.mesh, np.ones(placed.question.part.mesh.vertex_count, dtype=bool)
    )
    places = torn_apart(full, placed.best.mask)
    return places if len(places) > len(pieces) else []


def torn_apart(mesh: TriangleMesh, mask: Bools) -> list[Bools]:
    """The connected parts (n,) of a mask (n,) that are more than noise, the largest first."""
    edges = mesh.edges[mask[mesh.edges].all(axis=1)]
    count = mesh.vertex_count
    links = sparse.coo_array(
        (np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(count, count)
    )
    number, labels = csgraph.connected_components(links.tocsr(), directed=False)
    areas = np.bincount(labels, mesh.vertex_areas * mask, minlength=number)
    large = np.flatnonzero(areas > TORN * areas.sum())
    return [mask & (labels == k) for k in large[np.argsort(-areas[large], kind="stable")]]


def _exchangeable(chosen: Mapping[int, Trial], areas: Floats) -> list[tuple[int, int]]:
    """Pairs of pieces in doubt, each of which has room where the other lies."""
    doubtful = {k: each for k, each in chosen.items() if each.chance < 1 - LEAST_CHANCE}
    sizes = {k: float(areas @ each.candidate.region) for k, each in doubtful.items()}
    return [
        (one, other)
        for one, other in combinations(sorted(doubtful), 2)
        if min(sizes[one], sizes[other]) >= ROOM * max(sizes[one], sizes[other])
    ]


def _lies_on(trial: Trial, others: Iterable[Trial], areas: Floats) -> bool:
    """Whether so much of what a trial surely claims lies on others that its place is in doubt."""
    core = trial.candidate.core
    shared = float(areas @ (core & _taken(others, len(areas))))
    return shared > CLASH * float(areas @ core)


def _winners(loser: Trial, chosen: Mapping[int, Trial], areas: Floats) -> set[int]:
    """The pieces that have the place of one which lies nowhere, or fits worse where it lies now.

    Or reach into it and are in doubt: what slid along a limb has the end of its neighbor's place.
    """
    own = chosen.get(loser.piece)
    lost = own is None or own.placed.best.score < loser.placed.best.score
    if not lost or loser.chance < LEAST_CHANCE:
        return set()
    others = {piece: trial for piece, trial in chosen.items() if piece != loser.piece}
    winners = clashes([loser, *others.values()], areas).get(loser.piece, set())
    return winners | {
        piece
        for piece, trial in others.items()
        if trial.chance < SURE and (trial.candidate.core & loser.candidate.core).any()
    }


def _room_for_all(trials: Iterable[Trial]) -> bool:
    """Whether these pieces can all lie on the full shape, which has area 1, beside each other."""
    return sum(trial.placed.question.part.mesh.area for trial in trials) <= ALL


def _on_mesh(template: Template, free: Bools) -> Bools:
    """A mask of the full shape itself (n,) at the vertices of its working mesh."""
    if template.own_vertices is None and template.mesh.vertex_count == len(free):
        return free
    nearest = template.own_finder.closest(template.mesh.vertices, template.mesh.vertex_normals)
    return free[nearest.nearest_vertices(template.placed)]
