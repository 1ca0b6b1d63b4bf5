"""Compiled: polar coordinates of the vertices around a point, and means of pictures in their cells.

A kernel on plain arrays; :mod:`sherd.descriptors.relief_patches` says what pictures are.
"""

from __future__ import annotations

import math

import numpy as np

from sherd.compiled import compiled
from sherd.spectral.heap_kernel import lower, pop

__all__ = ["polar_means"]

# Along the edges of even triangles a way is up to so many times as long as across them.
STRAY = 2.0 / math.sqrt(3.0)


@compiled()
def polar_means(  # noqa: PLR0913
    rows, starts, neighbors, vertices, normals, sources, x_axes, z_axes, width, pictures, weights,
    means, seen,
):  # fmt: skip
    """Write the means (q, c, r, t) of pictures (c, n) and the areas (q, r, t) they are from.

    Of rings `width` wide around each source and `t` sectors, counted from its `x_axes`. A vertex
    weighs `weights` (n,) and is shared by the four cells nearest to it. What is laid flat there but
    farther away along the edges is no part of the neighborhood.
    """
    size = len(vertices)
    away, place = np.full(size, np.inf), np.full(size, -1, np.int64)
    heap, reached = np.empty(size, np.int64), np.empty(size, np.int64)
    flat, axes = np.empty((size, 2)), np.empty((size, 3))
    done, before = np.zeros(size, np.uint8), np.empty(size, np.int64)
    reach = STRAY * (seen.shape[1] + 0.5) * width
    for row in range(rows[0], rows[1]):
        source = sources[row]
        away[source], flat[source, 0], flat[source, 1] = 0.0, 0.0, 0.0
        heap[0], place[source], reached[0] = source, 0, source
        filled, count = 1, 1
        while filled > 0:
            vertex = pop(heap, place, away, filled)
            filled -= 1
            done[vertex] = 1
            near = away[vertex]
            if near > reach:
                break  # and so is all that is left
            _vote(row, vertex, flat, width, pictures, weights, means, seen)
            if vertex == source:
                normal = _row(z_axes, row)
                axis = _row(x_axes, row)
            else:
                # its axis is that of the vertex it was reached from at last
                last = before[vertex]
                above = _row(z_axes, row) if last == source else _row(normals, last)
                normal = _row(normals, vertex)
                axis = _carried(above, normal, _row(axes, last))
            axes[vertex, 0], axes[vertex, 1], axes[vertex, 2] = axis
            beside = _cross(normal, axis)
            for entry in range(starts[vertex], starts[vertex + 1]):
                other = neighbors[entry]
                if done[other] == 1:
                    continue
                x, y = _laid_flat(vertices, vertex, other, axis, beside)
                distance = near + math.sqrt(x * x + y * y)
                if distance < away[other]:
                    if away[other] == np.inf:
                        reached[count] = other
                        count += 1
                    away[other], before[other] = distance, vertex
                    flat[other, 0], flat[other, 1] = flat[vertex, 0] + x, flat[vertex, 1] + y
                    filled = lower(heap, place, away, other, filled)
        for entry in range(count):
            vertex = reached[entry]
            away[vertex], done[vertex], place[vertex] = np.inf, 0, -1
    _divide(rows, means, seen)


@compiled(inline="always")
def _laid_flat(vertices, vertex, other, axis, beside):
    """The edge to a neighbor in the plane of two axes, as long as it is."""
    a = vertices[other, 0] - vertices[vertex, 0]
    b = vertices[other, 1] - vertices[vertex, 1]
    c = vertices[other, 2] - vertices[vertex, 2]
    along = a * axis[0] + b * axis[1] + c * axis[2]
    across = a * beside[0] + b * beside[1] + c * beside[2]
    flattened = math.sqrt(along * along + across * across)
    scale = math.sqrt(a * a + b * b + c * c) / flattened if flattened > 0.0 else 0.0
    return scale * along, scale * across


@compiled(inline="always")
def _row(array, row):
    return array[row, 0], array[row, 1], array[row, 2]


# of numbers: numpy's own products make an array each time, which takes longer than they do
@compiled(inline="always")
def _cross(first, second):
    return (
        first[1] * second[2] - first[2] * second[1],
        first[2] * second[0] - first[0] * second[2],
        first[0] * second[1] - first[1] * second[0],
    )


@compiled(inline="always")
def _dot(first, second):
    return first[0] * second[0] + first[1] * second[1] + first[2] * second[2]


@compiled(inline="always")
def _carried(normal, normal_there, axis):
    """An axis carried to a neighbor by the least rotation between the normals."""
    turn = _cross(normal, normal_there)
    cosine = _dot(normal, normal_there)
    # opposite normals have no least rotation; their axis is left where it is, nearly
    share = _dot(turn, axis) / max(1.0 + cosine, 0.1)
    beside = _cross(turn, axis)
    x = axis[0] * cosine + beside[0] + turn[0] * share
    y = axis[1] * cosine + beside[1] + turn[1] * share
    z = axis[2] * cosine + beside[2] + turn[2] * share
    length = math.sqrt(x * x + y * y + z * z)
    return (x / length, y / length, z / length) if length > 0.0 else axis


@compiled(inline="always")
def _vote(row, vertex, flat, width, pictures, weights, means, seen):
    rings, sectors = seen.shape[1], seen.shape[2]
    x, y = flat[vertex, 0], flat[vertex, 1]
    ring = math.sqrt(x * x + y * y) / width - 0.5
    turn = math.atan2(y, x) / (2.0 * math.pi)
    sector = (turn + 1.0 if turn < 0.0 else turn) * sectors
    first_ring, first_sector = math.floor(ring), math.floor(sector)
    for next_ring in range(2):
        at = first_ring + next_ring
        if at < 0 or at >= rings:
            continue
        share = 1.0 - abs(ring - at)
        for next_sector in range(2):
            part = share * (1.0 - abs(sector - first_sector - next_sector)) * weights[vertex]
            side = (first_sector + next_sector) % sectors
            seen[row, at, side] += part
            for picture in range(len(pictures)):
                means[row, picture, at, side] += part * pictures[picture, vertex]


@compiled()
def _divide(rows, means, seen):
    for row in range(rows[0], rows[1]):
        for ring in range(seen.shape[1]):
            for sector in range(seen.shape[2]):
                total = seen[row, ring, sector]
                for picture in range(means.shape[1]):
                    if total > 0.0:
                        means[row, picture, ring, sector] /= total
