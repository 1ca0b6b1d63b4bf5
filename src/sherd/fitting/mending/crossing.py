"""A fit whose limbs went through each other, pushed apart as far as elasticity allows."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from copy import copy
from dataclasses import replace

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.correspondence.elastic_kernel import closest_rotations
from sherd.fitting.as_rigid_as_possible import Elasticity
from sherd.fitting.deformation import Deformation, corners_of, with_rings, without_data
from sherd.fitting.mending.patch import Patch
from sherd.fitting.mending.rest_crossing import rest_crossings, with_rest_crossings
from sherd.fitting.mending.self_intersection import (
    intersecting_faces,
    intersecting_pairs,
    marked_faces,
)
from sherd.mesh.geometry import closest_rotation, face_areas, face_normals
from sherd.mesh.topology import component_labels

__all__ = ["MOST_CROSSINGS", "new_crossings", "without_new_crossings"]

# Share of the faces: where pushing leaves so few crossings, nothing is let go.
MOST_CROSSINGS = 0.001
# Shares of their own turning that crossing regions are turned back by, the least first.
SHARES = (0.25, 0.5, 0.75, 1.0)
# What crossed before moves as one piece with so many rings of edges around it, a twentieth of
# sqrt(area) at most: wider ones bend, and as rigid bodies would move what was seen.
RIGID_RINGS = (1, 2, 4)
# Around crossings of what was seen so many rings of edges are let go.
RINGS = (1, 2, 4, 8)
# Each round pushes by what is crossed, and a limb is thicker than what crosses first.
ROUNDS = 6
# So much more than what is crossed, in mean edges.
MARGIN = 0.5
# How firmly what was seen stays, and how firmly the rest is pushed, in sqrt(area) as data terms.
SEEN_LENGTH, PUSH_LENGTH = 0.002, 0.01
# Area may differ by so much from what it should be: pushing shall bend limbs, not flatten them.
AREA_CHANGE = 0.02


def without_new_crossings(elasticity: Elasticity, found: Deformation, seen: Bools) -> Deformation:
    """The same, or with fewer faces that pierce others and did not in the full shape.

    First what crosses where the full shape does is moved as one piece, see
    :mod:`sherd.fitting.mending.rest_crossing`. Then what crosses is pushed apart, and so little
    around it follows that all else stays. Where that leaves too many, patches of the map lie on
    another limb, and would not be home if they were pushed out of it: see :func:`_let_go`. Such a
    step is kept only if it leaves fewer crossings and the area.
    """
    pierced = intersecting_pairs(elasticity.rest, elasticity.mesh.faces)
    before = marked_faces(pierced, elasticity.mesh.face_count)
    crossed = _Fewest(elasticity, _moved_as_before(elasticity, found, pierced, before), before)
    pushed = copy(crossed)
    _push_around(elasticity, pushed)
    if pushed.count <= MOST_CROSSINGS * elasticity.mesh.face_count:
        return pushed.best
    _let_go(elasticity, crossed, seen)
    return crossed.best


def _moved_as_before(
    elasticity: Elasticity, found: Deformation, pierced: Ints, before: Bools
) -> Deformation:
    """What crosses where the full shape does, moved as it lies there, with more and more around.

    `pierced` (k, 2) are the pairs that cross there, `before` (m,) their faces.
    Bodies have the area that they should have, so nothing is asked about area.
    """
    faces = elasticity.mesh.faces
    crossing = np.unique(_new_pairs(found.positions, faces, before))
    places = rest_crossings(elasticity, pierced) if len(crossing) else []
    for rings in RIGID_RINGS:
        if not (places and len(crossing)):
            break
        step = with_rest_crossings(elasticity, found, places, crossing, rings)
        left = np.unique(_new_pairs(step.positions, faces, before))
        if len(left) < len(crossing):
            found, crossing = step, left
    return found


def _let_go(elasticity: Elasticity, fewest: _Fewest, seen: Bools) -> None:
    """Let data go and turn hidden regions back, then push what still crosses.

    First, where what was seen crosses something, as fingers do that the map mixes up, the data let
    go in wider and wider surroundings, and rotations and places continue from around. Then, hidden
    regions that cross something turn back toward where they are beside the whole in the full shape,
    where they crossed nothing. Last, where two surfaces still go through each other, the hidden
    vertices of each that lie behind the other are pushed before it, and what is around follows;
    what was seen stays.
    """
    for rings in RINGS:
        if not seen[elasticity.mesh.faces[np.unique(fewest.pairs)]].any():
            break
        fewest.show(_released(elasticity, fewest.best, fewest.pairs, seen, rings))
        if not fewest.count:
            return
    if not seen.all():
        turning = _turning_back(elasticity, fewest.best, fewest.pairs, seen)
        for share in SHARES:
            fewest.show(turning(share))
            if not fewest.count:
                return
        for step in _pushes(elasticity, fewest.best, fewest.pairs, fewest.before, seen):
            fewest.show(*step)
    _push_around(elasticity, fewest)


class _Fewest:
    """Of deformations that are shown, the one with the fewest crossings that keeps the area."""

    def __init__(self, elasticity: Elasticity, found: Deformation, before: Bools) -> None:
        self.mesh, self.before = elasticity.mesh, before
        sizes = found.sizes[self.mesh.faces]
        self.area = float(self.mesh.face_areas @ (sizes**2).mean(axis=1))
        self.most_off = max(self._off(found), AREA_CHANGE)
        self.best = found
        self.pairs = _new_pairs(found.positions, self.mesh.faces, self.before)

    @property
    def count(self) -> int:
        """How many faces cross."""
        return len(np.unique(self.pairs))

    def show(self, step: Deformation, pairs: Ints | None = None) -> None:
        """Keep `step`, of which `pairs` cross, if it is better."""
        if pairs is None:
            pairs = _new_pairs(step.positions, self.mesh.faces, self.before)
        if len(np.unique(pairs)) < self.count and self._off(step) <= self.most_off:
            self.best, self.pairs = step, pairs

    def _off(self, step: Deformation) -> float:
        return abs(float(face_areas(step.positions, self.mesh.faces).sum() / self.area) - 1)


def _push_around(elasticity: Elasticity, fewest: _Fewest) -> None:
    """Push what crosses apart, seen or not, while more and more around it may follow."""
    for rings in RINGS:
        if not fewest.count:
            break
        fewest.show(_pushed_around(elasticity, fewest.best, fewest.pairs, fewest.before, rings))


def _released(
    elasticity: Elasticity, found: Deformation, pairs: Ints, seen: Bools, rings: int
) -> Deformation:
    """What was seen around crossings is no longer held; the rest stays where it is."""
    crossing = corners_of(elasticity, np.unique(pairs)) & seen
    released = with_rings(elasticity, crossing, rings)
    return without_data(elasticity, found, released)


def _turning_back(
    elasticity: Elasticity, found: Deformation, pairs: Ints, seen: Bools
) -> Callable[[float], Deformation]:
    """The deformation, its crossing hidden regions turned back by a share of what they turned."""
    faces, rest, hidden = elasticity.mesh.faces, elasticity.rest, ~seen
    inside = faces[hidden[faces].all(axis=1)]
    labels = component_labels(inside, len(rest)) if len(inside) else np.arange(len(rest))
    corners = faces[np.unique(pairs)].ravel()
    crossing = hidden & np.isin(labels, labels[corners[hidden[corners]]])
    weights = elasticity.areas * seen
    whole = closest_rotation(rest, found.positions, weights)
    pulls = np.where(seen, elasticity.areas / SEEN_LENGTH**2, 0.0)
    relaxed = elasticity.relaxation(pulls)

    def turned(share: float) -> Deformation:
        mixed = (1 - share) * found.rotations + share * whole
        rotations = np.where(crossing[:, None, None], closest_rotations(mixed), found.rotations)
        step = replace(found, rotations=rotations)
        return replace(step, positions=relaxed(step.turns, found.positions, found.positions))

    return turned


def new_crossings(elasticity: Elasticity, found: Deformation) -> int:
    """How many faces pierce others that do not in the full shape."""
    faces = elasticity.mesh.faces
    fresh = intersecting_faces(found.positions, faces) & ~intersecting_faces(elasticity.rest, faces)
    return int(fresh.sum())


def _new_pairs(positions: Floats, faces: Ints, before: Bools) -> Ints:
    """Pairs (k, 2) of faces that pierce each other, one of which at least did not `before`."""
    pairs = intersecting_pairs(positions, faces)
    fresh: Ints = pairs[~before[pairs].all(axis=1)]
    return fresh


def _pushed_around(
    elasticity: Elasticity, found: Deformation, pairs: Ints, before: Bools, rings: int
) -> Deformation:
    """Crossing surfaces pushed apart, seen or not; so many rings around them follow, no more."""
    free = with_rings(elasticity, corners_of(elasticity, np.unique(pairs)), rings)
    patch = Patch(elasticity, found, free)
    local, start, before = patch.elasticity, patch.start, before[patch.faces]

    crossed = _new_pairs(start.positions, local.mesh.faces, before)
    pushes = _pushes(local, start, crossed, before, ~patch.free)
    best, _ = min(((start, crossed), *pushes), key=lambda each: len(np.unique(each[1])))
    return patch.put_back(found, best)


def _pushes(
    elasticity: Elasticity, found: Deformation, pairs: Ints, before: Bools, held: Bools
) -> Iterator[tuple[Deformation, Ints]]:
    """Rounds in which `pairs`, what crosses, are pushed apart, and what still crosses then.

    What is `held` (n,) stays.
    """
    now = found
    for _ in range(ROUNDS):
        if not len(pairs):
            return
        now = _pushed(elasticity, now, pairs, held)
        pairs = _new_pairs(now.positions, elasticity.mesh.faces, before)
        yield now, pairs


def _pushed(elasticity: Elasticity, now: Deformation, pairs: Ints, seen: Bools) -> Deformation:
    faces = elasticity.mesh.faces
    normals = face_normals(now.positions, faces)
    margin = MARGIN * elasticity.mesh.mean_edge_length
    push = np.zeros_like(now.positions)
    largest = np.zeros(len(push))
    for one, other in (pairs.T, pairs[:, ::-1].T):
        for corner in range(3):
            vertex = faces[one, corner]
            center = now.positions[faces[other]].mean(axis=1)
            behind = ((center - now.positions[vertex]) * normals[other]).sum(axis=1)
            for k in np.flatnonzero((behind > 0) & ~seen[vertex]):
                if behind[k] > largest[vertex[k]]:
                    largest[vertex[k]] = behind[k]
                    push[vertex[k]] = (behind[k] + margin) * normals[other[k]]
    pushed = largest > 0
    pulls = elasticity.areas * np.where(seen, 1.0 / SEEN_LENGTH**2, 0.0)
    pulls = np.where(pushed, elasticity.areas / PUSH_LENGTH**2, pulls)
    positions = elasticity.relaxation(pulls)(now.turns, now.positions + push, now.positions)
    # what was pushed turns with its surroundings, what was seen does not
    turned = elasticity.fitted_rotations(positions)
    rotations = np.where(seen[:, None, None], now.rotations, turned)
    return replace(now, positions=positions, rotations=rotations)
