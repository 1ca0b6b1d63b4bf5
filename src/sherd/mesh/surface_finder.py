"""Closest points and vertices of a surface where it looks the same way."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from sherd.arrays import Bools, Floats, Ints
from sherd.mesh.geometry import face_cross, lengths
from sherd.mesh.sizes import LARGEST_PART
from sherd.mesh.surface_points import BLOCK, SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["SurfaceFinder"]


# A normal that differs by a right angle counts like 0.04 of distance: other sheets stay away.
NORMAL_SCALE = 0.03
# Faces searched around each position; exact where triangles are not much longer than wide.
NEAR_FACES = 12
# Samples per vertex area, each shared by three vertices: a vertex sees a dozen.
SAMPLES = 4
MOST_DIVISIONS = 16
# Of a vertex's area, from which on it is covered.
HALF = 0.5


class SurfaceFinder:
    """Closest points of a mesh of area near 1, on faces that look the same way.

    Parameters
    ----------
    mesh
        The surface, in the template's unit.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        self.mesh = mesh
        self._corners = np.ascontiguousarray(mesh.vertices[mesh.faces])
        self._normals = mesh.face_normals
        self._faces = _tree(self._corners.mean(axis=1), self._normals)

    def closest(self, positions: Floats, normals: Floats) -> SurfacePoints:
        """The closest point to each position (p, 3) whose surface has normal (p, 3)."""
        from sherd.mesh.closest_kernel import closest_on_faces  # loads slowly  # noqa: PLC0415

        count = min(NEAR_FACES, self.mesh.face_count)
        query = _with_normals(positions, normals)
        faces = np.empty(len(positions), dtype=np.int64)
        weights = np.empty((len(positions), 3))
        for start in range(0, len(positions), BLOCK):
            block = slice(start, start + BLOCK)
            near = self._faces.query(query[block], k=count, workers=-1)[1]
            near = near.reshape(-1, count)
            # among the near faces only those that look the other way are put back
            agreement = np.einsum("pkc,pc->pk", self._normals[near], normals[block])
            penalty = 4.0 * NORMAL_SCALE**2 * (agreement < 0)
            closest_on_faces(
                np.ascontiguousarray(positions[block]), near, self._corners, penalty,
                faces[block], weights[block],
            )  # fmt: skip
        return SurfacePoints(faces, weights)

    def covered_areas(self, positions: Floats, faces: Ints) -> Floats:
        """How much of a surface (p, 3), (f, 3) lies at each vertex, (n,) area.

        Samples of the surface are shared by the corners of the faces that they lie on, so the mesh
        itself covers each of its vertices by its vertex area.
        """
        corners = positions[faces]
        spanned = face_cross(positions, faces)
        areas = 0.5 * lengths(spanned)
        normals = spanned / np.maximum(2 * areas, 1e-300)[:, None]
        # a part that was torn over the whole space is sampled no more than one of this mesh's size
        spacing = max(self.mesh.area, areas.sum() / LARGEST_PART) / self.mesh.vertex_count
        divisions = np.clip(np.ceil(np.sqrt(SAMPLES * areas / spacing)), 1, MOST_DIVISIONS)
        covered = np.zeros(self.mesh.vertex_count)
        for division in np.unique(divisions):
            rows = np.flatnonzero(divisions == division)
            grid = _subtriangle_centers(int(division))
            samples = np.einsum("gk,fkc->fgc", grid, corners[rows]).reshape(-1, 3)
            up = np.repeat(normals[rows], len(grid), axis=0)
            points = self.closest(samples, up)
            share = np.repeat(areas[rows] / len(grid), len(grid))
            corners_hit = self.mesh.faces[points.faces]
            parts = points.barycentric * share[:, None]
            covered += np.bincount(corners_hit.ravel(), parts.ravel(), minlength=len(covered))
        return covered

    def covered_vertices(self, positions: Floats, faces: Ints) -> Bools:
        """The vertices (n,) of this mesh that a surface (p, 3), (f, 3) covers at least half of.

        The surface is sampled densely, so the region has no holes between its vertices, however
        coarse it is.
        """
        whole = self.mesh.vertex_areas
        covered: Bools = self.covered_areas(positions, faces) >= HALF * whole
        covered &= whole > 0
        return covered


def _tree(places: Floats, normals: Floats) -> cKDTree:
    return cKDTree(_with_normals(places, normals), balanced_tree=False)


def _with_normals(places: Floats, normals: Floats) -> Floats:
    return np.concatenate([places, NORMAL_SCALE * normals], axis=1)


def _subtriangle_centers(division: int) -> Floats:
    """Barycentric centers (division^2, 3) of the small triangles of a divided triangle."""
    rows = []
    for i in range(division):
        for j in range(division - i):
            rows.append((i + 1 / 3, j + 1 / 3))
            if i + j < division - 1:
                rows.append((i + 2 / 3, j + 2 / 3))
    first = np.array(rows) / division
    return np.concatenate([first, 1 - first.sum(axis=1, keepdims=True)], axis=1)
