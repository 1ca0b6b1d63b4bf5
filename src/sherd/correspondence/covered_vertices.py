"""What a laid part covers of the full shape."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sherd.mesh.surface_finder import SurfaceFinder
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["covered_vertices"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Samples per vertex area: the covered share of a vertex is known to a tenth.
SAMPLES = 12
MOST_DIVISIONS = 16


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
