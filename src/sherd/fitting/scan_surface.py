"""ScanSurface: the pieces as a surface that the full shape is laid onto."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.mesh.geometry import vertex_normals
from sherd.mesh.surface_finder import SurfaceFinder
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["REACH", "ScanSurface"]

# In sqrt(area of the full shape): farther off is another place, not this one.
REACH = 0.03
# Cosine: surfaces that differ by more than 60 degrees are not the same.
AGREEMENT = 0.5


class ScanSurface:
    """Closest points of the pieces, where they are no guess.

    Parameters
    ----------
    mesh
        The matched faces of all pieces, in units of sqrt(area of the full shape).
    inward
        Whether the normals of the full shape point the other way.
    """

    def __init__(self, mesh: TriangleMesh, *, inward: bool = False) -> None:
        self.mesh = mesh
        self._finder = SurfaceFinder(mesh)
        self._sign = -1.0 if inward else 1.0
        self._border = np.zeros(mesh.vertex_count, dtype=bool)
        self._border[mesh.boundary_vertices] = True

    def closest(self, positions: Floats, normals: Floats) -> tuple[SurfacePoints, Bools]:
        """The closest point to each position (p, 3), and whether it is its place.

        It is not where the surface ends, looks another way than the normals (p, 3) of the full
        shape, or is too far.
        """
        up = self._sign * normals
        points = self._finder.closest(positions, up)
        corners = self.mesh.faces[points.faces]
        ends = (self._border[corners] | (points.barycentric < 1e-6)).all(axis=1)
        agree = (up * self.mesh.face_normals[points.faces]).sum(axis=1) > AGREEMENT
        off = np.linalg.norm(points.positions(self.mesh) - positions, axis=1)
        near: Bools = ~ends & agree & (off < REACH)
        return points, near

    def feet(self, positions: Floats, faces: Ints) -> tuple[Floats, Bools]:
        """The closest points (n, 3) to the vertices of a mesh, and which are their places."""
        points, found = self.closest(positions, vertex_normals(positions, faces))
        return points.positions(self.mesh), found
