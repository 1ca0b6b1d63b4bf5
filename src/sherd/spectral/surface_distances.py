"""Geodesic distances between pairs of points of a surface, finer than its vertices."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Floats, Singles
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.geodesics import Geodesics

__all__ = ["SurfaceDistances"]


# Below this many edge lengths between two points the straight chord is the distance.
CHORD_REACH = 4.0


class SurfaceDistances:
    """Geodesic distances between pairs of points of a surface, in units of sqrt(area).

    Two points closer than four mean edges (along the surface) are measured by the chord between
    them, which differs from the geodesic by the curvature over four edges only; all others by
    heat-method distances between the corners of their faces, weighted with both barycentric
    weights (0.6 % error). The distance is thus sub-vertex, and zero for equal points.

    Parameters
    ----------
    mesh
        The surface.

    Notes
    -----
    A row of distances is computed for the corners of the first points' faces and kept: n^2 * 4
    bytes when all vertices were asked. Of two sets, give the one that is asked again first.
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        self._mesh = mesh
        self._geodesics = Geodesics(mesh)
        self._rows: dict[int, Singles] = {}

    def between(self, first: SurfacePoints, second: SurfacePoints) -> Floats:
        """Distance (p,) between corresponding points."""
        mesh = self._mesh
        anchor = first.nearest_vertices(mesh)
        corners = mesh.faces[second.faces]
        rough = np.empty((len(anchor), 3))
        for vertex in np.unique(anchor):
            rows = np.flatnonzero(anchor == vertex)
            rough[rows] = self._row(int(vertex))[corners[rows]]
        chord = np.linalg.norm(first.positions(mesh) - second.positions(mesh), axis=1)
        near = rough.min(axis=1) <= CHORD_REACH * mesh.mean_edge_length
        distance = np.where(near, chord, 0.0)
        for corner in range(3):
            far = np.flatnonzero(~near & (first.barycentric[:, corner] > 0))
            sources = mesh.faces[first.faces[far], corner]
            for vertex in np.unique(sources):
                rows = far[sources == vertex]
                length = self._row(int(vertex))[corners[rows]]
                weight = first.barycentric[rows, corner]
                distance[rows] += weight * (length * second.barycentric[rows]).sum(axis=1)
        return distance / mesh.length

    def _row(self, vertex: int) -> Singles:
        if vertex not in self._rows:
            row = self._geodesics.distances_from([vertex])[0]
            reached = row[np.isfinite(row)].max(initial=0.0)
            # a point on another component is as wrong as the farthest point of this one
            self._rows[vertex] = np.where(np.isfinite(row), row, reached).astype(np.float32)
        return self._rows[vertex]
