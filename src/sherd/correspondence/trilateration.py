"""From anchors to a first answer for every vertex of the part, by trilateration."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Ints
from sherd.correspondence.labels.labeling import Labeling
from sherd.correspondence.question import Question
from sherd.correspondence.trilateration_kernel import Members, trilaterate
from sherd.threads import over_rows

__all__ = ["trilaterated_vertices"]


# Ten anchors overdetermine a place on a surface four times.
ANCHORS = 10
# An anchor with a local cost above this disagrees with its own neighbors.
COST_LIMIT = 2.5


def trilaterated_vertices(question: Question, labeling: Labeling) -> Ints:
    """Vertex of the full shape (n',) whose distances to the near anchors fit best.

    `argmin over v of sum over anchors of w rho(d_full(label, v) - d_part(node, i))` with weights
    falling with the square of the distance, and rho Geman-McClure.
    """
    labels, nodes = question.full.dense, question.part.sparse
    reliable = labeling.local_cost <= COST_LIMIT
    if reliable.sum() < 2 * ANCHORS:
        reliable = labeling.placed.copy()
    distances = np.where(reliable[:, None], nodes.distances, np.inf)
    alone = ~np.isfinite(distances).any(axis=0)  # on a component without any reliable node
    distances[:, alone] = nodes.distances[:, alone]
    count = min(ANCHORS, len(distances))
    by_vertex = np.ascontiguousarray(distances.T)
    near = np.argpartition(by_vertex, count - 1, axis=1)[:, :count]
    length = np.take_along_axis(by_vertex, near, axis=1)
    # the nearest first, those that are not reached last, which partitions need not give
    order = np.argsort(length, axis=1, kind="stable")
    near, length = (np.take_along_axis(each, order, axis=1) for each in (near, length))
    members = _members(labels.cells, len(labels))
    result = np.zeros(len(near), dtype=np.int64)
    over_rows(
        trilaterate, len(near), near, length.astype(np.float64), labeling.labels,
        labels.between, labels.distances, members, result,
    )  # fmt: skip
    return result


def _members(cells: Ints, count: int) -> Members:
    vertices = np.argsort(cells, kind="stable")
    return Members(np.searchsorted(cells[vertices], np.arange(count + 1)), vertices)
