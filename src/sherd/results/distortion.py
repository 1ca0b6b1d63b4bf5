"""How a map bends the part: stretch of edges and orientation of faces, for proof and picture."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sherd.arrays import Bools, Floats
from sherd.mesh.geometry import face_cross, lengths
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["Distortion", "distortion", "mean_at_vertices"]

# Edges that the map makes a point, or that were one, have no logarithm; lengths count from here up,
# in units of the full shape's.
TINY = 1e-9


class Distortion(NamedTuple):
    """What a map does to the part.

    Attributes
    ----------
    stretch
        (e,) `log(mapped length / length)` of the part's edges, at the scale that was found.
    preserved
        (m,) whether each face keeps its orientation: one is turned over if its image runs the
        other way around than the full shape there.
    """

    stretch: Floats
    preserved: Bools


def distortion(
    part: TriangleMesh,
    full: TriangleMesh,
    points: SurfacePoints,
    *,
    outward: Floats,
    scale: float,
) -> Distortion:
    """How the edges and faces of the part fare under a map.

    Parameters
    ----------
    part, full
        The two shapes.
    points
        (n_part,) where the part's vertices lie on `full`.
    outward
        (n_full, 3) outward normals at the full shape's vertices.
    scale
        Factor that the part was enlarged by.
    """
    tiny = TINY * full.length
    image = points.positions(full)
    first, second = part.edges.T
    before = lengths(part.vertices[second] - part.vertices[first]) * scale
    after = lengths(image[second] - image[first])
    stretch: Floats = np.log(np.maximum(after, tiny) / np.maximum(before, tiny))
    up = points.interpolate(full, outward)[part.faces].sum(axis=1)
    preserved: Bools = (face_cross(image, part.faces) * up).sum(axis=1) > 0
    return Distortion(stretch, preserved)


def mean_at_vertices(values: Floats, elements: np.ndarray, vertex_count: int) -> Floats:
    """Mean over the edges or faces (e, k) at each vertex (n,); NaN at vertices without any."""
    total = np.bincount(elements.ravel(), np.repeat(values, elements.shape[1]), vertex_count)
    degree = np.bincount(elements.ravel(), minlength=vertex_count)
    mean: Floats = np.divide(total, degree, out=np.full(vertex_count, np.nan), where=degree > 0)
    return mean
