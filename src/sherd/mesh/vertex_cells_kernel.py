"""Vertices sorted into cubes, for kernels that ask who is near.

A tree from scipy answers with lists, which cost kernels more than their own work.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.compiled import compiled

__all__ = ["Cells", "sorted_into_cells", "vertices_in_ball"]


class Cells(NamedTuple):
    """Vertices sorted into cubes; a named tuple, which compiled kernels take as it is.

    Cube (i, j, k) begins at `origin + size (i, j, k)` and has the index
    `c = (i shape[1] + j) shape[2] + k`; its vertices are `order[starts[c]:starts[c + 1]]`.
    """

    order: Ints
    starts: Ints
    origin: Floats
    size: float
    shape: Ints


def sorted_into_cells(vertices: Floats, reach: float) -> Cells:
    """Vertices (n, 3) in cubes at least `reach` wide, at most 64 along each axis."""
    origin = vertices.min(axis=0)
    extent = float((vertices.max(axis=0) - origin).max())
    size = max(reach, extent / 64.0)
    place = np.floor((vertices - origin) / size).astype(np.int64)
    shape = place.max(axis=0) + 1
    flat = (place[:, 0] * shape[1] + place[:, 1]) * shape[2] + place[:, 2]
    order = np.argsort(flat, kind="stable")
    starts = np.searchsorted(flat[order], np.arange(int(shape.prod()) + 1))
    return Cells(order, starts, origin, float(size), shape)


@compiled()
def vertices_in_ball(place, radius, vertices, cells):
    """Indices of the vertices nearer than `radius` to `place` (3,), for kernels.

    `cells` come from :func:`sorted_into_cells`, with a reach not below the radius.
    """
    order, starts, origin, size, shape = cells
    low, high = np.empty(3, np.int64), np.empty(3, np.int64)
    for axis in range(3):
        cell = math.floor((place[axis] - origin[axis]) / size)
        low[axis], high[axis] = max(cell - 1, 0), min(cell + 2, shape[axis])
    found = np.empty(16, np.int64)
    count = 0
    for i in range(low[0], high[0]):
        for j in range(low[1], high[1]):
            first = (i * shape[1] + j) * shape[2]
            if high[2] <= low[2]:
                continue
            for entry in range(starts[first + low[2]], starts[first + high[2]]):
                vertex = order[entry]
                distance = 0.0
                for axis in range(3):
                    distance += (vertices[vertex, axis] - place[axis]) ** 2
                if distance < radius * radius:
                    if count == len(found):
                        found = np.concatenate((found, np.empty(count, np.int64)))
                    found[count] = vertex
                    count += 1
    return found[:count]
