"""Faces that a deformation turned over, and how they are turned back."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.fitting.as_rigid_as_possible import Elasticity
from sherd.fitting.deformation import Deformation
from sherd.mesh.geometry import face_cross

__all__ = ["turned_faces", "without_turned_faces"]

# Rounds of releasing what is around turned faces; each doubles how far around.
ROUNDS = 6
# So firmly are vertices held that are not released, in units as data terms.
HOLD_LENGTH = 0.002


def turned_faces(rest: Floats, positions: Floats, rotations: Floats, faces: Ints) -> Bools:
    """Whether each face (m,) looks away from where the rotations of its corners turn its normal.

    Faces without an area in either place count as not turned.
    """
    before = face_cross(rest, faces)
    after = face_cross(positions, faces)
    turned = np.einsum("mkij,mj->mi", rotations[faces], before)
    against: Bools = (turned * after).sum(axis=1) < 0
    return against


def without_turned_faces(elasticity: Elasticity, found: Deformation) -> Deformation:
    """The same, but around turned faces the data no longer draw, and elasticity decides.

    What is farther away stays. The rotations are those that fit the edges of each vertex, so this
    is a question to the positions alone. If some faces cannot be turned back, the deformation with
    the fewest is returned.
    """
    best, fewest = found, np.inf
    now, faces = found, elasticity.mesh.faces
    around = elasticity.springs.astype(bool).astype(np.float64)
    released = np.zeros(len(found.positions), dtype=bool)
    for step in range(ROUNDS):
        rotations = elasticity.fitted_rotations(now.positions)
        turned = turned_faces(elasticity.rest, now.positions, rotations, faces)
        if turned.sum() < fewest:
            best, fewest = Deformation(now.positions, now.rotations, now.sizes), turned.sum()
        if not turned.any():
            break
        released[faces[turned].ravel()] = True
        for _ in range(step + 1):
            released |= around @ released.astype(np.float64) > 0
        pulls = elasticity.areas * np.where(released, 0.0, 1.0 / HOLD_LENGTH**2)
        relaxed = elasticity.relaxation(pulls)(found.turns, found.positions, found.positions)
        now = Deformation(relaxed, found.rotations, found.sizes)
    return best
