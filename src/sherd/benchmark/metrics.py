"""How good a map and a region are: geodesic error, flips, coverage, region overlap."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Bools, Floats, Singles
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.geodesics import Geodesics

__all__ = [
    "GroundTruthDistances",
    "cumulative_curve",
    "region_overlap",
    "vertex_mask",
]


# Below this many edge lengths between true and given point the straight chord is the distance.
CHORD_REACH = 4.0


class GroundTruthDistances:
    """Distances on the full shape between pairs of surface points, in units of sqrt(area).

    Two points closer than four mean edges (along the surface) are measured by the chord between
    them, which differs from the geodesic by the curvature over four edges only; all others by
    heat-method distances between the corners of their faces, weighted with both barycentric
    weights (0.6 % error). The distance is thus sub-vertex, and zero for equal points. Rows are
    computed on demand and kept: n^2 * 4 bytes when all vertices were asked.
    """

    def __init__(self, full: TriangleMesh) -> None:
        self._full = full
        self._geodesics = Geodesics(full)
        self._rows: dict[int, Singles] = {}

    def between(self, truth: SurfacePoints, answer: SurfacePoints) -> Floats:
        """Distance (p,) between corresponding points."""
        full = self._full
        anchor = truth.nearest_vertices(full)
        corners = full.faces[answer.faces]
        rough = np.empty((len(anchor), 3))
        for vertex in np.unique(anchor):
            rows = np.flatnonzero(anchor == vertex)
            rough[rows] = self._row(int(vertex))[corners[rows]]
        chord = np.linalg.norm(truth.positions(full) - answer.positions(full), axis=1)
        near = rough.min(axis=1) <= CHORD_REACH * full.mean_edge_length
        distance = np.where(near, chord, 0.0)
        for corner in range(3):
            far = np.flatnonzero(~near & (truth.barycentric[:, corner] > 0))
            sources = full.faces[truth.faces[far], corner]
            for vertex in np.unique(sources):
                rows = far[sources == vertex]
                length = self._row(int(vertex))[corners[rows]]
                weight = truth.barycentric[rows, corner]
                distance[rows] += weight * (length * answer.barycentric[rows]).sum(axis=1)
        return distance / full.length

    def _row(self, vertex: int) -> Singles:
        if vertex not in self._rows:
            row = self._geodesics.distances_from([vertex])[0]
            reached = row[np.isfinite(row)].max(initial=0.0)
            # a point on another component is as wrong as the farthest point of this one
            self._rows[vertex] = np.where(np.isfinite(row), row, reached).astype(np.float32)
        return self._rows[vertex]


def vertex_mask(full: TriangleMesh, points: SurfacePoints) -> Bools:
    """Vertices (n,) of `full` that are the nearest corner of some answer."""
    mask = np.zeros(full.vertex_count, dtype=bool)
    mask[points.nearest_vertices(full)] = True
    return mask


def region_overlap(full: TriangleMesh, first: Bools, second: Bools) -> float:
    """Area-weighted intersection over union of two vertex masks; NaN if both are empty."""
    areas = full.vertex_areas
    union = float(areas[first | second].sum())
    return float(areas[first & second].sum()) / union if union > 0 else float("nan")


def cumulative_curve(errors: Floats, thresholds: Floats) -> Floats:
    """Share of the errors at most each threshold."""
    ordered = np.sort(errors)
    return np.searchsorted(ordered, thresholds, side="right") / max(len(ordered), 1)
