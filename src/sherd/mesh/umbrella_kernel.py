"""Compiled: the Delaunay triangles at one point of a planar set, for many sets at once.

Kernels on plain arrays; :mod:`sherd.mesh.point_cloud` says what they are for. A library would
triangulate each whole neighborhood, to keep six of its thirty triangles.
"""

from __future__ import annotations

import numba
import numpy as np

__all__ = ["umbrellas"]


@numba.njit(cache=True, parallel=True)
def umbrellas(offsets, weights, reach):  # type: ignore[no-untyped-def]
    """Neighbors (n, k, 2) that make a triangle with their point; -1 where there are no more.

    Parameters
    ----------
    offsets
        (n, k, 2) places of the neighbors of each point in its tangent plane, the point at 0.
    weights
        (n, k) squared lengths, far below those of the offsets: which diagonal of a square is taken,
        so that all its corners take the same. The weight of the point itself is subtracted.
    reach
        (n,) longest side of a triangle.

    Notes
    -----
    The Voronoi cell of 0 is the set of x with `2 x . p <= |p|^2 - w` for all neighbors p. It is the
    polar of the convex hull of 0 and the points `p / (|p|^2 - w)`, so neighbors whose cells meet
    at a corner of the cell of 0 are neighbors on that hull.
    """
    count, width = offsets.shape[0], offsets.shape[1]
    pairs = np.full((count, width, 2), -1, np.int64)
    for point in numba.prange(count):
        polar = np.zeros((width + 1, 2))  # the last one is 0 itself
        number = np.full(width + 1, -1)
        used = 0
        for k in range(width):
            x, y = offsets[point, k]
            square = x * x + y * y - weights[point, k]
            if square > 1e-12 * reach[point] ** 2:  # the same point twice has no direction
                polar[used, 0], polar[used, 1], number[used] = x / square, y / square, k
                used += 1
        ring = _hull(polar[: used + 1])
        found = 0
        limit = reach[point] ** 2
        for step in range(len(ring)):
            a, b = number[ring[step]], number[ring[(step + 1) % len(ring)]]
            if a < 0 or b < 0 or len(ring) < 3:
                continue
            p, q = offsets[point, a], offsets[point, b]
            sides = max(p @ p, q @ q, (p - q) @ (p - q))
            if sides <= limit:
                pairs[point, found, 0], pairs[point, found, 1] = a, b
                found += 1
    return pairs


@numba.njit(cache=True)
def _hull(points):  # type: ignore[no-untyped-def]
    """Corners of the convex hull of (m, 2), counterclockwise: Andrew's monotone chain, 1979."""
    count = len(points)
    order = np.argsort(points[:, 0])
    for i in range(1, count):  # by y where x is equal
        j = i
        while (
            j > 0
            and points[order[j - 1], 0] == points[order[j], 0]
            and points[order[j - 1], 1] > points[order[j], 1]
        ):
            order[j - 1], order[j] = order[j], order[j - 1]
            j -= 1
    ring = np.empty(2 * count + 1, np.int64)
    size = 0
    for way in range(2):
        least = size + 1 if way == 1 else 2
        for i in range(count):
            here = order[i] if way == 0 else order[count - 1 - i]
            if way == 1 and i == 0:
                continue
            while size >= least:
                a, b, c = points[ring[size - 2]], points[ring[size - 1]], points[here]
                if (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0:
                    break
                size -= 1
            ring[size] = here
            size += 1
    return ring[: max(size - 1, 0)]
