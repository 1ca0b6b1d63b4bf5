"""Compiled loops of farthest-point sampling, in space and along a surface."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.compiled import compiled
from sherd.spectral.heap_kernel import lower, pop

__all__ = ["farthest_along_paths", "farthest_in_space"]


@compiled()
def farthest_in_space(points: Floats, count: int, start: int) -> Ints:
    """Indices (count,) of a greedy farthest-point sample of points (n, 3); first index on ties."""
    size = len(points)
    nearest = np.full(size, np.inf)
    chosen = np.empty(count, np.int64)
    current = start
    for step in range(count):
        chosen[step] = current
        x, y, z = points[current, 0], points[current, 1], points[current, 2]
        farthest, largest = 0, -1.0
        for row in range(size):
            a, b, c = points[row, 0] - x, points[row, 1] - y, points[row, 2] - z
            squared = a * a + b * b + c * c
            nearest[row] = min(nearest[row], squared)
            if nearest[row] > largest:
                farthest, largest = row, nearest[row]
        current = farthest
    return chosen


@compiled()
def farthest_along_paths(starts, neighbors, lengths, ranks, count, start):
    """Indices (count,) of vertices, each the farthest along paths from those before it.

    Of vertices that no path reaches the one of lowest rank (n,) comes first; those of negative
    rank are never taken. Neighbors of vertex i are `neighbors[starts[i]:starts[i + 1]]`. Each
    sample corrects the distances around it only, as far as it is the nearest one (Dijkstra 1959).
    """
    size = len(ranks)
    nearest, taken = np.full(size, np.inf), np.zeros(size, np.uint8)
    heap, place = np.empty(size, np.int64), np.full(size, -1, np.int64)
    chosen = np.empty(count, np.int64)
    current = start
    for step in range(count):
        chosen[step] = current
        taken[current] = 1
        nearest[current] = 0.0
        heap[0], place[current] = current, 0
        filled = 1
        while filled > 0:
            vertex = pop(heap, place, nearest, filled)
            filled -= 1
            for entry in range(starts[vertex], starts[vertex + 1]):
                other = neighbors[entry]
                distance = nearest[vertex] + lengths[entry]
                if distance < nearest[other]:
                    nearest[other] = distance
                    filled = lower(heap, place, nearest, other, filled)
        current = _farthest(nearest, taken, ranks)
    return chosen


@compiled()
def _farthest(nearest, taken, ranks):
    best, largest, rank = 0, -1.0, 0
    for vertex in range(len(ranks)):
        if taken[vertex] == 1 or ranks[vertex] < 0:
            continue
        value = nearest[vertex]
        if value > largest or (value == np.inf and ranks[vertex] < rank):
            best, largest, rank = vertex, value, ranks[vertex]
    return best
