"""Compiled loop of the Euclidean farthest-point sampling; imported only when it is used."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.compiled import compiled

__all__ = ["farthest_points"]


@compiled()
def farthest_points(points: Floats, count: int, start: int) -> Ints:
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
