"""What a laid part covers of the full shape."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sherd.mesh.surface_finder import SurfaceFinder

__all__ = ["covered_vertices"]


def covered_vertices(
    finder: SurfaceFinder, positions: NDArray[np.float64], faces: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """The vertices (n,) of the finder's mesh that a laid part covers at least half of.

    The part, vertices `positions` (n', 3) and `faces`, is sampled densely, so the region has no
    holes between its vertices, however coarse the part is.
    """
    whole = finder.mesh.vertex_areas
    covered: NDArray[np.bool_] = finder.covered_areas(positions, faces) >= 0.5 * whole
    covered &= whole > 0
    return covered
