"""From anchors to a first answer for every vertex of the part, by trilateration."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from sherd.correspondence.labeling import Labeling
from sherd.correspondence.part_data import PartData
from sherd.template import Template
from sherd.threads import over_rows

__all__ = ["trilaterated"]

Ints = NDArray[np.int64]

# Ten anchors overdetermine a place on a surface four times.
ANCHORS = 10
# An anchor with a local cost above this disagrees with its own neighbors.
COST_LIMIT = 2.5
# A vertex lies within a few node spacings of its nearest anchor.
REACH = 0.18
# An anchor is a label, which is off by half the label spacing.
SPACING = 0.02
# A misfit of 0.05 is an error and not noise.
MISFIT = 0.05
# A cell is surrounded by six.
CELLS = 7


def trilaterated(template: Template, part: PartData, labeling: Labeling) -> Ints:
    """Vertex of the full shape (n',) whose distances to the near anchors fit best.

    `argmin over v of sum over anchors of w rho(d_full(label, v) - d_part(node, i))` with weights
    falling with the square of the distance, and rho Geman-McClure.
    """
    reliable = labeling.local_cost <= COST_LIMIT
    if reliable.sum() < 2 * ANCHORS:
        reliable[:] = True
    distances = np.where(reliable[:, None], part.node_distances, np.inf)
    alone = ~np.isfinite(distances).any(axis=0)  # on a component without any reliable node
    distances[:, alone] = part.node_distances[:, alone]
    count = min(ANCHORS, len(distances))
    near = np.argsort(distances, axis=0, kind="stable")[:count].T
    length = np.take_along_axis(distances, near.T, axis=0).T
    pointers, members = _members(template.cells, len(template.label_vertices))
    result = np.zeros(len(near), dtype=np.int64)
    over_rows(
        _trilaterate, len(near), near, length.astype(np.float64), labeling.labels,
        (template.label_to_label, template.label_distances), (pointers, members), result,
    )  # fmt: skip
    return result


def _members(cells: Ints, count: int) -> tuple[Ints, Ints]:
    """The vertices of cell i are `members[pointers[i]:pointers[i + 1]]`."""
    members = np.argsort(cells, kind="stable")
    pointers = np.searchsorted(cells[members], np.arange(count + 1))
    return pointers, members


# First the best cells by the costs of their labels, then the best vertex in them: a twelfth of the
# work of comparing all vertices. The cost changes little within a cell, so the best vertex is
# in one of the best cells.
@numba.njit(cache=True, nogil=True)
def _trilaterate(rows, near, length, labels, distances, cells, result):  # type: ignore[no-untyped-def]
    between, to_vertices = distances
    pointers, members = cells
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
                vertex = members[entry]
                cost = _misfit(at, length[point], to_vertices, vertex, lowest)
                if cost < lowest:
                    lowest, result[point] = cost, vertex


@numba.njit(cache=True, inline="always")
def _misfit(at, length, distances, vertex, limit):  # type: ignore[no-untyped-def]
    """Cost of one vertex, or any number above `limit` if it is above."""
    cost = 0.0
    for k in range(len(at)):
        if length[k] == np.inf or cost > limit:
            break
        off = (distances[at[k], vertex] - length[k]) ** 2
        cost += off / (1.0 + off / MISFIT**2) / (SPACING + length[k]) ** 2
    return cost
