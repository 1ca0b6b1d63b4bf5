"""Closest points of a surface on faces that look the same way; what a laid part covers."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["SurfaceFinder", "covered_vertices"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# A normal that differs by a right angle counts like 0.04 of distance: other sheets stay away.
NORMAL_SCALE = 0.03
# Faces searched around each position; exact where triangles are not much longer than wide.
NEAR_FACES = 12
# Samples per vertex area: the covered share of a vertex is known to a tenth.
SAMPLES = 12
MOST_DIVISIONS = 16


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
        self._tree = cKDTree(
            np.concatenate([self._corners.mean(axis=1), NORMAL_SCALE * mesh.face_normals], axis=1)
        )
        self._count = min(NEAR_FACES, mesh.face_count)

    def closest(self, positions: Floats, normals: Floats) -> SurfacePoints:
        """The closest point to each position (p, 3) whose surface has normal (p, 3)."""
        query = np.concatenate([positions, NORMAL_SCALE * normals], axis=1)
        near = self._tree.query(query, k=self._count)[1].reshape(len(positions), self._count)
        faces = np.empty(len(positions), dtype=np.int64)
        weights = np.empty((len(positions), 3))
        away = self._normals[near] - normals[:, None]
        penalty = NORMAL_SCALE**2 * np.einsum("pkc,pkc->pk", away, away)
        _closest(np.ascontiguousarray(positions), near, self._corners, penalty, faces, weights)
        return SurfacePoints(faces, weights)


def covered_vertices(
    finder: SurfaceFinder, full: TriangleMesh, positions: Floats, faces: Ints
) -> NDArray[np.bool_]:
    """The vertices (n,) of `full` of whose area a laid part covers at least half.

    The part, vertices `positions` (n', 3) and `faces`, is sampled densely, so the region has no
    holes between its vertices, however coarse the part is.
    """
    corners = positions[faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = 0.5 * np.linalg.norm(cross, axis=1)
    normals = cross / np.maximum(2 * areas, 1e-300)[:, None]
    spacing = full.area / full.vertex_count
    divisions = np.clip(np.ceil(np.sqrt(SAMPLES * areas / spacing)), 1, MOST_DIVISIONS)
    covered = np.zeros(full.vertex_count)
    for division in np.unique(divisions):
        rows = np.flatnonzero(divisions == division)
        grid = _subtriangle_centers(int(division))
        samples = np.einsum("gk,fkc->fgc", grid, corners[rows]).reshape(-1, 3)
        up = np.repeat(normals[rows], len(grid), axis=0)
        nearest = finder.closest(samples, up).nearest_vertices(full)
        share = np.repeat(areas[rows] / len(grid), len(grid))
        covered += np.bincount(nearest, share, minlength=len(covered))
    return (covered >= 0.5 * full.vertex_areas) & (full.vertex_areas > 0)


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


@numba.njit(cache=True, parallel=True)
def _closest(positions, near, corners, penalty, faces, weights):  # type: ignore[no-untyped-def]
    """Ericson, *Real-Time Collision Detection*, 2005, section 5.1.5, over the near faces."""
    for row in numba.prange(len(positions)):
        best = np.inf
        for k in range(near.shape[1]):
            a, b, c = corners[near[row, k]]
            v, w = _closest_weights(positions[row], a, b, c)
            distance = penalty[row, k]
            for x in range(3):
                foot = a[x] + v * (b[x] - a[x]) + w * (c[x] - a[x])
                distance += (foot - positions[row, x]) ** 2
            if distance < best:
                best = distance
                faces[row] = near[row, k]
                weights[row, 0], weights[row, 1], weights[row, 2] = 1.0 - v - w, v, w


@numba.njit(cache=True)
def _closest_weights(p, a, b, c):  # type: ignore[no-untyped-def]  # noqa: PLR0911
    """Weights of b and c at the point of the triangle closest to p."""
    d1 = d2 = d3 = d4 = d5 = d6 = 0.0
    for x in range(3):
        ab, ac = b[x] - a[x], c[x] - a[x]
        d1 += ab * (p[x] - a[x])
        d2 += ac * (p[x] - a[x])
        d3 += ab * (p[x] - b[x])
        d4 += ac * (p[x] - b[x])
        d5 += ab * (p[x] - c[x])
        d6 += ac * (p[x] - c[x])
    if d1 <= 0.0 and d2 <= 0.0:
        return 0.0, 0.0
    if d3 >= 0.0 and d4 <= d3:
        return 1.0, 0.0
    if d6 >= 0.0 and d5 <= d6:
        return 0.0, 1.0
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        return d1 / max(d1 - d3, 1e-300), 0.0
    vb = d5 * d2 - d1 * d6
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        return 0.0, d2 / max(d2 - d6, 1e-300)
    va = d3 * d6 - d5 * d4
    if va <= 0.0 and d4 >= d3 and d5 >= d6:
        w = (d4 - d3) / max((d4 - d3) + (d5 - d6), 1e-300)
        return 1.0 - w, w
    total = max(va + vb + vc, 1e-300)
    return vb / total, vc / total
