"""Lift: a region found on a working mesh, seen on the vertices of the mesh it was made from."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Bools, Floats
from sherd.energy.cleanup import raised_to_area, threshold_to_area
from sherd.mesh.surface_points import closest_points
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["Lift"]


class Lift:
    """Carries values from a working mesh to the mesh it was made from.

    Parameters
    ----------
    work
        The working mesh; the same object as `placed` if none was needed.
    placed
        The mesh whose vertices the user counts, in the same position.
    area
        Area that a region must have, in the unit of `placed`.
    """

    def __init__(self, work: TriangleMesh, placed: TriangleMesh, area: float) -> None:
        self._placed = placed
        self._area = area
        self._work = work
        same = work is placed
        self._points = None if same else closest_points(work, placed.vertices)

    def values(self, values: Floats) -> Floats:
        """Vertex values in [0, 1] of the working mesh at the vertices of the other, (n,)."""
        if self._points is None:
            return values
        return np.clip(self._points.interpolate(self._work, values), 0.0, 1.0)

    def region(self, membership: Floats, mask: Bools) -> tuple[Floats, Bools]:
        """Membership and mask of the area of the part."""
        if self._points is None:
            return membership, mask
        inside = self._points.interpolate(self._work, mask.astype(np.float64))
        areas = self._placed.vertex_areas
        # interpolation changes the integral by the curvature of the mesh; a power puts it right
        lifted = raised_to_area(self.values(membership), areas, self._area)
        return lifted, threshold_to_area(inside + 1e-3 * lifted, areas, self._area)
