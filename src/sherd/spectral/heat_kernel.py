"""Compiled: the heat method for many sources at once.

Kernels on plain arrays; :mod:`sherd.spectral.geodesics` says what is solved. Each number of the
method is a row of `LANES` numbers, one for each source, so that every entry of a factor and every
triangle is read once for all of them, and the processor's vector unit works on the rows.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.compiled import compiled

__all__ = ["LANES", "Factor", "Slopes", "heat_distances"]

# Two cache lines; the rows of 10,000 vertices then fill a core's cache of 1 or 2 MB.
LANES = 16


class Factor(NamedTuple):
    """A symmetric matrix as L D L' after renumbering.

    Attributes
    ----------
    place
        (n,) the row of the factor that stands for each vertex.
    starts, rows, values
        Columns of L below the diagonal, compressed.
    inverse
        (n,) 1 / D.
    """

    place: Ints
    starts: Ints
    rows: Ints
    values: Floats
    inverse: Floats


class Slopes(NamedTuple):
    """Triangles in their planes: `faces` (m, 3) and `parts` (m, 4).

    With values a, b, c at the corners the gradient has the components `(b - a) p_0` and
    `(c - a) p_2 - (b - a) p_1`; `p_3` is the area.
    """

    faces: Ints
    parts: Floats


@compiled()
def heat_distances(rows, sources, starts, slopes, heat, poisson, result):
    """Write the distances (q, n) from sets of sources; `rows` count blocks of `LANES` sets.

    Set i is `sources[starts[i]:starts[i + 1]]`.
    """
    count = len(heat.inverse)
    warm, flow = np.empty((count, LANES)), np.empty((count, LANES))
    for block in range(rows[0], rows[1]):
        first = block * LANES
        last = min(first + LANES, len(starts) - 1)
        warm[:] = 0.0
        for row in range(first, last):
            for entry in range(starts[row], starts[row + 1]):
                warm[heat.place[sources[entry]], row - first] = 1.0
        _solve(heat, warm)
        flow[:] = 0.0
        _add_flow(slopes, heat.place, poisson.place, warm, flow)
        _solve(poisson, flow)
        for row in range(first, last):
            zero = 0.0
            for entry in range(starts[row], starts[row + 1]):
                zero += flow[poisson.place[sources[entry]], row - first]
            zero /= max(starts[row + 1] - starts[row], 1)
            for vertex in range(count):
                result[row, vertex] = flow[poisson.place[vertex], row - first] - zero


@compiled()
def _solve(factor, values):
    """Replace each column of `values` (n, LANES) by the solution for it."""
    _, starts, below, entries, inverse = factor
    count = len(inverse)
    own = np.empty(LANES)
    for column in range(count):
        for lane in range(LANES):
            own[lane] = values[column, lane]
        for entry in range(starts[column], starts[column + 1]):
            row, weight = below[entry], entries[entry]
            for lane in range(LANES):
                values[row, lane] -= weight * own[lane]
    for column in range(count - 1, -1, -1):
        for lane in range(LANES):
            own[lane] = values[column, lane] * inverse[column]
        for entry in range(starts[column], starts[column + 1]):
            row, weight = below[entry], entries[entry]
            for lane in range(LANES):
                own[lane] -= weight * values[row, lane]
        for lane in range(LANES):
            values[column, lane] = own[lane]


@compiled()
def _add_flow(slopes, place, target, warm, flow):
    """Add the integrated divergence of the unit vectors that point away from the warmth."""
    faces, parts = slopes
    to_b, to_c = np.empty(LANES), np.empty(LANES)
    for face in range(len(faces)):
        a, b, c = place[faces[face, 0]], place[faces[face, 1]], place[faces[face, 2]]
        p, q, r, area = parts[face, 0], parts[face, 1], parts[face, 2], parts[face, 3]
        for lane in range(LANES):
            along_b, along_c = warm[b, lane] - warm[a, lane], warm[c, lane] - warm[a, lane]
            x, y = along_b * p, along_c * r - along_b * q
            # far from the source warmth is so little that its square would be zero
            scale = max(abs(x), abs(y), 1e-300)
            x, y = x / scale, y / scale
            length = max(math.sqrt(x * x + y * y), 1e-12)
            x, y = -area * x / length, -area * y / length
            to_b[lane], to_c[lane] = p * x - q * y, r * y
        a, b, c = target[faces[face, 0]], target[faces[face, 1]], target[faces[face, 2]]
        for lane in range(LANES):
            flow[a, lane] -= to_b[lane] + to_c[lane]
            flow[b, lane] += to_b[lane]
            flow[c, lane] += to_c[lane]
