"""A fit whose limbs went through each other, pushed apart as far as elasticity allows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.fitting.as_rigid_as_possible import Elasticity
from sherd.fitting.deformation import Deformation
from sherd.fitting.self_intersection import intersecting_faces, intersecting_pairs
from sherd.mesh.geometry import face_areas, face_normals

__all__ = ["without_new_crossings"]

# Each round pushes by what is crossed, and a limb is thicker than what crosses first.
ROUNDS = 6
# So much more than what is crossed, in mean edges.
MARGIN = 0.5
# How firmly what was seen stays, and how firmly the rest is pushed, in sqrt(area) as data terms.
SEEN_LENGTH, PUSH_LENGTH = 0.002, 0.01
# Area of all faces may change by so much: pushing shall bend limbs, not flatten them.
AREA_CHANGE = 0.02


def without_new_crossings(elasticity: Elasticity, found: Deformation, seen: Bools) -> Deformation:
    """The same, or with fewer faces that pierce others and did not in the full shape.

    Where two surfaces went through each other, the vertices of each that lie behind the other are
    pushed before it, if they were not seen; what is around follows. What was seen stays. A round
    is kept only if it leaves fewer crossings.
    """
    faces = elasticity.mesh.faces
    before = intersecting_faces(elasticity.rest, faces)
    pairs = _new_pairs(found.positions, faces, before)
    area = face_areas(found.positions, faces).sum()
    best, now, fewest = found, found, len(np.unique(pairs))
    for _ in range(ROUNDS):
        if not len(pairs):
            break
        now = _pushed(elasticity, now, pairs, seen)
        pairs = _new_pairs(now.positions, faces, before)
        change = abs(face_areas(now.positions, faces).sum() / area - 1)
        if change > AREA_CHANGE:
            break
        if len(np.unique(pairs)) < fewest:
            best, fewest = now, len(np.unique(pairs))
    return best


def _new_pairs(positions: Floats, faces: Ints, before: Bools) -> Ints:
    pairs = intersecting_pairs(positions, faces)
    fresh: Ints = pairs[~before[pairs].any(axis=1)]
    return fresh


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
