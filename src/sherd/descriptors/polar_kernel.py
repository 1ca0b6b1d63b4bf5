"""Compiled: polar coordinates of the vertices around a point, and means of pictures in their cells.

A kernel on plain arrays; :mod:`sherd.descriptors.relief_patches` says what pictures are.
"""

from __future__ import annotations

import math

import numpy as np

from sherd.compiled import compiled
from sherd.spectral.heap_kernel import lower, pop

__all__ = ["polar_means"]


@compiled()
def polar_means(  # noqa: PLR0913
    rows, starts, neighbors, vertices, normals, sources, x_axes, z_axes, width, pictures, weights,
    means, seen,
):  # fmt: skip
    """Write the means (q, c, r, t) of pictures (c, n) and the areas (q, r, t) they are from.

    Of rings `width` wide around each source and `t` sectors, counted from its `x_axes`. A vertex
    weighs `weights` (n,) and is shared by the four cells nearest to it.
    """
    size = len(vertices)
    away, place = np.full(size, np.inf), np.full(size, -1, np.int64)
    heap, reached = np.empty(size, np.int64), np.empty(size, np.int64)
    flat, axes = np.empty((size, 2)), np.empty((size, 3))
    done = np.zeros(size, np.uint8)
    reach = (seen.shape[1] + 0.5) * width
    for row in range(rows[0], rows[1]):
        source = sources[row]
        away[source], flat[source, 0], flat[source, 1] = 0.0, 0.0, 0.0
        axes[source] = x_axes[row]
        heap[0], place[source], reached[0] = source, 0, source
        filled, count = 1, 1
        while filled > 0:
            vertex = pop(heap, place, away, filled)
            filled -= 1
            done[vertex] = 1
            if away[vertex] > reach:
                continue
            _vote(row, vertex, flat, width, pictures, weights, means, seen)
            normal = z_axes[row] if vertex == source else normals[vertex]
            for entry in range(starts[vertex], starts[vertex + 1]):
                other = neighbors[entry]
                if done[other] == 1:
                    continue
                x, y = _beyond(vertices, vertex, other, normal, axes, flat)
                # where paths turn back the order in which vertices are reached is kept
                distance = max(math.sqrt(x * x + y * y), away[vertex])
                if distance < away[other]:
                    if away[other] == np.inf:
                        reached[count] = other
                        count += 1
                    away[other], flat[other, 0], flat[other, 1] = distance, x, y
                    _carry(normal, normals[other], axes, vertex, other)
                    filled = lower(heap, place, away, other, filled)
        for entry in range(count):
            away[reached[entry]], done[reached[entry]] = np.inf, 0
    _divide(rows, means, seen)


@compiled()
def _beyond(vertices, vertex, other, normal, axes, flat):
    """Plane coordinates of a neighbor: those of the vertex and the edge, laid flat."""
    a = vertices[other, 0] - vertices[vertex, 0]
    b = vertices[other, 1] - vertices[vertex, 1]
    c = vertices[other, 2] - vertices[vertex, 2]
    u, v, w = axes[vertex, 0], axes[vertex, 1], axes[vertex, 2]
    along = a * u + b * v + c * w
    across = (
        a * (normal[1] * w - normal[2] * v)
        + b * (normal[2] * u - normal[0] * w)
        + c * (normal[0] * v - normal[1] * u)
    )
    flattened = math.sqrt(along * along + across * across)
    scale = math.sqrt(a * a + b * b + c * c) / flattened if flattened > 0.0 else 0.0
    return flat[vertex, 0] + scale * along, flat[vertex, 1] + scale * across


@compiled()
def _carry(normal, normal_there, axes, vertex, other):
    """The axis of a vertex carried to its neighbor by the least rotation between the normals."""
    turn = np.cross(normal, normal_there)
    cosine = (normal * normal_there).sum()
    axis = axes[vertex]
    # opposite normals have no least rotation; their axis is left where it is, nearly
    share = (turn * axis).sum() / max(1.0 + cosine, 0.1)
    carried = axis * cosine + np.cross(turn, axis) + turn * share
    length = math.sqrt((carried * carried).sum())
    axes[other] = carried / length if length > 0.0 else axis


@compiled()
def _vote(row, vertex, flat, width, pictures, weights, means, seen):
    rings, sectors = seen.shape[1], seen.shape[2]
    x, y = flat[vertex, 0], flat[vertex, 1]
    ring = math.sqrt(x * x + y * y) / width - 0.5
    sector = (math.atan2(y, x) / (2.0 * math.pi) % 1.0) * sectors
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
