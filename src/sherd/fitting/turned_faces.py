"""Faces that a deformation turned over, and how they are turned back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.fitting.as_rigid_as_possible import Elasticity
from sherd.fitting.deformation import (
    HOLD_LENGTH,
    Deformation,
    corners_of,
    with_rings,
    without_data,
)
from sherd.mesh.geometry import face_cross

__all__ = ["still_turned", "turned_faces", "without_turned_faces"]

# Rings of edges that are released around turned faces, wider where faces stay turned.
RINGS = (1, 3, 6, 10, 15, 21)


def turned_faces(rest: Floats, positions: Floats, rotations: Floats, faces: Ints) -> Bools:
    """Whether each face (m,) looks away from where the rotations of its corners turn its normal.

    Faces without an area in either place count as not turned.
    """
    before = face_cross(rest, faces)
    after = face_cross(positions, faces)
    turned = np.einsum("mkij,mj->mi", rotations[faces], before)
    against: Bools = (turned * after).sum(axis=1) < 0
    return against


def still_turned(elasticity: Elasticity, found: Deformation) -> int:
    """How many faces are turned over beside the rotations that fit the edges best."""
    return int(_turned(elasticity, found).sum())


def without_turned_faces(elasticity: Elasticity, found: Deformation) -> Deformation:
    """The same, but around turned faces the data no longer draw, and elasticity decides.

    What is farther away stays. Whether a face is turned is asked beside the rotations that fit the
    edges of each vertex, so this is a question to the positions alone. Rotations stay at first, and
    continue from around where that is not enough. If some faces cannot be turned back, the
    deformation with the fewest is returned.
    """
    best, fewest = _with_fewest(elasticity, found, _with_same_rotations)
    return best if fewest == 0 else _with_fewest(elasticity, best, without_data)[0]


def _with_fewest(
    elasticity: Elasticity,
    found: Deformation,
    without: Callable[[Elasticity, Deformation, Bools], Deformation],
) -> tuple[Deformation, int]:
    """The one with the fewest turned faces when more and more is let go, and how many there are."""
    turned = _turned(elasticity, found)
    best, fewest = found, int(turned.sum())
    released = np.zeros(len(found.positions), dtype=bool)
    for rings in RINGS:
        if not turned.any():
            break
        released |= with_rings(elasticity, corners_of(elasticity, turned), rings)
        now = without(elasticity, found, released)
        turned = _turned(elasticity, now)
        if turned.sum() < fewest:
            best, fewest = now, int(turned.sum())
    return best, fewest


def _turned(elasticity: Elasticity, now: Deformation) -> Bools:
    """The faces (m,) that are turned over, beside the rotations that fit the edges best."""
    rotations = elasticity.fitted_rotations(now.positions)
    return turned_faces(elasticity.rest, now.positions, rotations, elasticity.mesh.faces)


def _with_same_rotations(
    elasticity: Elasticity, found: Deformation, released: Bools
) -> Deformation:
    pulls = elasticity.areas * np.where(released, 0.0, 1.0 / HOLD_LENGTH**2)
    relaxed = elasticity.relaxation(pulls)(found.turns, found.positions, found.positions)
    return replace(found, positions=relaxed)
