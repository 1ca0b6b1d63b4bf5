"""Further trials: pieces that lose their places or are in doubt, placed again by what is known."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from sherd.arrays import Bools, Floats
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import Stages
from sherd.place import placed_part
from sherd.puzzle.joint_choice import LEAST_CHANCE, joint_choice
from sherd.puzzle.trials import (
    SCORE_SCALE,
    Trial,
    candidates_of,
    chosen_trials,
    clashes,
    trials_of,
)
from sherd.results.advice import SURE
from sherd.surface.template import Template

__all__ = ["torn_apart", "trials_again"]

# A connected piece lies in one place. Of a region in several, those count that have so much of its
# area; smaller ones are noise of its border.
TORN = 0.1


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
    Each is tried where no other piece lies, if one lies where it would. A piece that is torn
    between two places is tried without either. Then the pieces that have the place of one that
    found none are tried elsewhere themselves, as both may be right only together. At last what has
    no place is tried in the gap that is left, if that is not the one it was tried in before.

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
    known = list(trials)

    def choose() -> dict[int, Trial]:
        choice = joint_choice(candidates_of(known, count), areas, may_overlap=may_overlap)
        return chosen_trials(known, choice)

    alone: dict[int, Trial] = {}
    for trial in trials:
        alone.setdefault(trial.piece, trial)
    by_size = sorted(alone.values(), key=lambda each: -float(areas @ each.candidate.region))
    tried: dict[int, Bools] = {}
    for first in by_size:
        chosen = choose()
        own = chosen.pop(first.piece, None)
        if own is not None and own.chance >= SURE:
            continue
        taken = _taken(chosen.values(), len(areas))
        tried[first.piece] = taken
        if _in_the_way(taken, first):
            known += _elsewhere(template, first, taken, stages)
        for place in _torn_places(template.placed, first):
            known += _elsewhere(template, first, taken | place, stages)
    for loser in by_size:
        for winner in _winners(loser, choose(), areas):
            chosen = choose()
            chosen.pop(winner, None)
            taken = _taken(chosen.values(), len(areas)) | loser.candidate.core
            known += _elsewhere(template, alone[winner], taken, stages)
    for first in by_size:
        chosen = choose()
        taken = _taken(chosen.values(), len(areas))
        same = np.array_equal(taken, tried.get(first.piece, ~taken))
        if first.piece not in chosen and not same and _in_the_way(taken, first):
            known += _elsewhere(template, first, taken, stages)
    return known[len(trials) :]


def _taken(chosen: Iterable[Trial], count: int) -> Bools:
    """(n,) what these surely claim."""
    taken: Bools = np.zeros(count, dtype=bool)
    for trial in chosen:
        taken |= trial.candidate.core
    return taken


def _in_the_way(taken: Bools, first: Trial) -> bool:
    """Whether something taken (n,) lies where the piece would."""
    return bool((taken & first.candidate.core).any())


def _elsewhere(template: Template, first: Trial, taken: Bools, stages: Stages) -> list[Trial]:
    """The piece of a trial placed once more, where nothing is taken (n,) yet."""
    if not taken.any() or taken.all():
        return []
    old = first.placed
    free = _on_mesh(template, ~taken)
    placed = placed_part(template, old.part, old.options, stages, free=free, twin=False)
    # what fits much worse than where the piece lies alone is no place for it
    loss = min(placed.best.score - old.best.score, 0.0)
    less = float(np.exp(loss / SCORE_SCALE))
    return [
        replace(trial, chance=less * trial.chance)
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


def _winners(loser: Trial, chosen: Mapping[int, Trial], areas: Floats) -> set[int]:
    """The pieces that have the place of a piece which would be placed there, and is nowhere."""
    if loser.piece in chosen or loser.chance < LEAST_CHANCE:
        return set()
    return clashes([loser, *chosen.values()], areas).get(loser.piece, set())


def _on_mesh(template: Template, free: Bools) -> Bools:
    """A mask of the full shape itself (n,) at the vertices of its working mesh."""
    if template.own_vertices is None and template.mesh.vertex_count == len(free):
        return free
    nearest = template.own_finder.closest(template.mesh.vertices, template.mesh.vertex_normals)
    return free[nearest.nearest_vertices(template.placed)]
