"""Closest points of a surface on faces that look the same way."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from sherd.mesh.surface_points import BLOCK, SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["SurfaceFinder"]

Floats = NDArray[np.float64]

# A normal that differs by a right angle counts like 0.04 of distance: other sheets stay away.
NORMAL_SCALE = 0.03
# Faces searched around each position; exact where triangles are not much longer than wide.
NEAR_FACES = 12


class SurfaceFinder:
    """Closest points of a mesh of area near 1, on faces that look the same way.

    Parameters
    ----------
    mesh
        The surface, in the template's unit.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        self._mesh = mesh
        self._corners = np.ascontiguousarray(mesh.vertices[mesh.faces])
        self._normals = mesh.face_normals
        places = np.concatenate([self._corners.mean(axis=1), NORMAL_SCALE * self._normals], axis=1)
        self._tree = cKDTree(places, balanced_tree=False)
        self._count = min(NEAR_FACES, mesh.face_count)

    def closest(self, positions: Floats, normals: Floats) -> SurfacePoints:
        """The closest point to each position (p, 3) whose surface has normal (p, 3)."""
        from sherd.mesh.closest_kernel import closest_on_faces  # loads slowly  # noqa: PLC0415

        query = np.concatenate([positions, NORMAL_SCALE * normals], axis=1)
        faces = np.empty(len(positions), dtype=np.int64)
        weights = np.empty((len(positions), 3))
        for start in range(0, len(positions), BLOCK):
            block = slice(start, start + BLOCK)
            near = self._tree.query(query[block], k=self._count)[1].reshape(-1, self._count)
            # among the near faces only those that look the other way are put back
            agreement = np.einsum("pkc,pc->pk", self._normals[near], normals[block])
            penalty = 4.0 * NORMAL_SCALE**2 * (agreement < 0)
            closest_on_faces(
                np.ascontiguousarray(positions[block]), near, self._corners, penalty,
                faces[block], weights[block],
            )  # fmt: skip
        return SurfacePoints(faces, weights)
