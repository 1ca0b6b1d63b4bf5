"""Faces that a deformation turned over, and how they are turned back.

References
----------
Mueller, Heidelberger, Hennix, Ratcliff, *Position based dynamics*, 2007, equations 8 and 9: how
corners move to what is asked of a face. Here each sweep moves them all at once, by the mean.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.fitting.as_rigid_as_possible import Elasticity
from sherd.fitting.deformation import Deformation, corners_of, with_rings, without_data
from sherd.mesh.geometry import face_cross

__all__ = ["still_turned", "turned_faces", "without_turned_faces"]

# A face that was turned over is opened to so much of its area: enough that what is done next to
# its surroundings does not turn it again, and little beside an edge.
OPEN = 0.1
# Sweeps over the turned faces. Most are open after three to five; who is not has no room, and more
# sweeps would only move what is around it.
SWEEPS = 40
# Rings of edges that are released around faces that have no room, wider where faces stay turned.
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
    """The same, but the corners of turned faces move until none is turned.

    They move by a fraction of an edge, so all else stays where the data have it. Where there is no
    room, the data let go in wider and wider surroundings, which continue from around. Whether a
    face is turned is asked beside the rotations that fit the edges of each vertex, so this is a
    question to the positions alone. If some faces cannot be turned back, the deformation with the
    fewest is returned.
    """
    best = _opened(elasticity, found)
    turned = _turned(elasticity, best)
    fewest = int(turned.sum())
    released = np.zeros(len(found.positions), dtype=bool)
    for rings in RINGS:
        if not turned.any():
            break
        released |= with_rings(elasticity, corners_of(elasticity, turned), rings)
        now = _opened(elasticity, without_data(elasticity, found, released))
        turned = _turned(elasticity, now)
        if turned.sum() < fewest:
            best, fewest = now, int(turned.sum())
    return best


def _opened(elasticity: Elasticity, found: Deformation) -> Deformation:
    """The corners of turned faces moved, the least that opens them, sweep by sweep.

    Of a face with corners p, q, r, whose normal in the full shape is turned to the unit vector n,
    the area `n . (q - p) x (r - p) / 2` is made `OPEN` of its own: along the gradient, so nothing
    turns or shifts as a whole.
    """
    faces, positions = elasticity.mesh.faces, found.positions.copy()
    before = face_cross(elasticity.rest, faces)
    wanted = OPEN * np.linalg.norm(before, axis=1) * (found.sizes[faces] ** 2).mean(axis=1)
    for _ in range(SWEEPS):
        rotations = elasticity.fitted_rotations(positions)
        turned = turned_faces(elasticity.rest, positions, rotations, faces)
        if not turned.any():
            break
        corners = faces[turned]
        normals = np.einsum("mkij,mj->mi", rotations[corners], before[turned])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
        p, q, r = positions[corners].transpose(1, 0, 2)
        second, third = np.cross(r - p, normals), np.cross(normals, q - p)
        gradients = np.stack([-second - third, second, third], axis=1)
        area = (np.cross(q - p, r - p) * normals).sum(axis=1)
        steps = (wanted[turned] - area) / np.maximum((gradients**2).sum(axis=(1, 2)), 1e-300)
        moves, asked = np.zeros_like(positions), np.zeros(len(positions))
        np.add.at(moves, corners, steps[:, None, None] * gradients)
        np.add.at(asked, corners, 1.0)
        positions += moves / np.maximum(asked, 1.0)[:, None]
    return replace(found, positions=positions)


def _turned(elasticity: Elasticity, now: Deformation) -> Bools:
    """The faces (m,) that are turned over, beside the rotations that fit the edges best."""
    rotations = elasticity.fitted_rotations(now.positions)
    return turned_faces(elasticity.rest, now.positions, rotations, elasticity.mesh.faces)
