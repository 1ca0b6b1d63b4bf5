"""A unit sphere of triangles."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.spectral.subdivision import split_edges

__all__ = ["unit_ball"]


def unit_ball(least: int) -> tuple[Floats, Ints]:
    """Vertices (n, 3), at least so many, and faces (m, 3) of an octahedron, split and made round.

    Closed and outward oriented.
    """
    vertices = np.concatenate([np.eye(3), -np.eye(3)])
    faces = np.array(
        [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]],
        dtype=np.int64,
    )
    while len(vertices) < least:
        faces, parents = split_edges(faces, len(vertices))
        middle = vertices[parents].sum(axis=1)
        vertices = np.concatenate(
            [vertices, middle / np.linalg.norm(middle, axis=1, keepdims=True)]
        )
    return vertices, faces
