"""How good a map and a region are: which errors are measured, their curve, region overlap."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = [
    "cumulative_curve",
    "evenly_spread",
    "region_overlap",
    "vertex_mask",
]

# Errors of so many vertices, spread evenly over their numbers, tell the mean within 5 %.
MEASURED = 600


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


def evenly_spread(count: int) -> Ints:
    """At most 600 of the numbers 0 to `count` - 1, evenly spread: enough for a mean error."""
    return np.linspace(0, count - 1, min(MEASURED, count)).astype(np.int64)
