"""Compiled: the vertex whose distances to given labels fit best.

Kernels on plain arrays; :mod:`sherd.correspondence.trilateration` states the cost.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sherd.arrays import Ints
from sherd.compiled import compiled

__all__ = ["Members", "trilaterate"]

# A vertex lies within a few node spacings of its nearest anchor.
REACH = 0.18
# An anchor is a label, which is off by half the label spacing.
SPACING = 0.02
# A misfit of 0.05 is an error and not noise.
MISFIT = 0.05
# A cell is surrounded by six.
CELLS = 7


class Members(NamedTuple):
    """The vertices of cell i are `vertices[pointers[i]:pointers[i + 1]]`."""

    pointers: Ints
    vertices: Ints


# First the best cells by the costs of their labels, then the best vertex in them: a twelfth of the
# work of comparing all vertices. The cost changes little within a cell, so the best vertex is
# in one of the best cells.
@compiled()
def trilaterate(rows, near, length, labels, between, to_vertices, members, result):
    """Write the vertex (n',) of least cost for the lengths (n', a) to the nodes `near`."""
    pointers = members.pointers
    for point in range(rows[0], rows[1]):
        at = labels[near[point]]
        costs = np.full(CELLS, np.inf)
        best = np.full(CELLS, -1)
        for label in range(len(between)):
            if between[at[0], label] > REACH:
                continue
            cost = _misfit(at, length[point], between, label, costs[CELLS - 1])
            rank = CELLS - 1
            if cost >= costs[rank]:
                continue
            while rank > 0 and costs[rank - 1] > cost:
                costs[rank], best[rank] = costs[rank - 1], best[rank - 1]
                rank -= 1
            costs[rank], best[rank] = cost, label
        lowest = np.inf
        for label in best:
            if label < 0:
                break
            for entry in range(pointers[label], pointers[label + 1]):
                vertex = members.vertices[entry]
                cost = _misfit(at, length[point], to_vertices, vertex, lowest)
                if cost < lowest:
                    lowest, result[point] = cost, vertex


@compiled(inline="always")
def _misfit(at, length, distances, vertex, limit):
    """Cost of one vertex, or any number above `limit` if it is above."""
    cost = 0.0
    for k in range(len(at)):
        if length[k] == np.inf or cost > limit:
            break
        off = (distances[at[k], vertex] - length[k]) ** 2
        cost += off / (1.0 + off / MISFIT**2) / (SPACING + length[k]) ** 2
    return cost
