"""From anchors to a first answer for every vertex of the part, by trilateration."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from sherd.correspondence.labeling import Labeling
from sherd.correspondence.part_data import PartData
from sherd.template import Template

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


def trilaterated(template: Template, part: PartData, labeling: Labeling) -> Ints:
    """Vertex of the full shape (n',) whose distances to the near anchors fit best.

    `argmin over v of sum over anchors of w rho(d_full(label, v) - d_part(node, i))` with weights
    falling with the square of the distance, and rho Geman-McClure.
    """
    reliable = labeling.local_cost <= COST_LIMIT
    if reliable.sum() < 2 * ANCHORS:
        reliable[:] = True
    distances = np.where(reliable[:, None], part.node_distances, np.inf)
    count = min(ANCHORS, len(distances))
    near = np.argsort(distances, axis=0, kind="stable")[:count].T
    length = np.take_along_axis(distances, near.T, axis=0).T
    result: Ints = _trilaterate(
        near, length.astype(np.float64), labeling.labels, template.label_distances
    )
    return result


@numba.njit(cache=True, parallel=True)
def _trilaterate(near, length, labels, distances):  # type: ignore[no-untyped-def]
    points, count = near.shape
    result = np.zeros(points, np.int64)
    for point in numba.prange(points):
        best = np.inf
        closest = labels[near[point, 0]]
        for vertex in range(distances.shape[1]):
            if distances[closest, vertex] > REACH:
                continue
            cost = 0.0
            for k in range(count):
                if length[point, k] == np.inf:
                    break
                off = (distances[labels[near[point, k]], vertex] - length[point, k]) ** 2
                weight = 1.0 / (SPACING + length[point, k]) ** 2
                cost += weight * off / (1.0 + off / MISFIT**2)
            if cost < best:
                best = cost
                result[point] = vertex
    return result
