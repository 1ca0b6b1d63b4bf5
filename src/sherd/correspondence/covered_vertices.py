"""What a laid part covers of the full shape."""

from __future__ import annotations

from sherd.arrays import Bools, Floats, Ints
from sherd.mesh.surface_finder import SurfaceFinder

__all__ = ["covered_vertices"]


def covered_vertices(finder: SurfaceFinder, positions: Floats, faces: Ints) -> Bools:
    """The vertices (n,) of the finder's mesh that a laid part covers at least half of.

    The part, vertices `positions` (n', 3) and `faces`, is sampled densely, so the region has no
    holes between its vertices, however coarse the part is.
    """
    whole = finder.mesh.vertex_areas
    covered: Bools = finder.covered_areas(positions, faces) >= 0.5 * whole
    covered &= whole > 0
    return covered
