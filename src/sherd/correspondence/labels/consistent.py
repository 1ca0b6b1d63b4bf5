"""Which of the nodes that both directions agree on can be true together.

A group of nodes on the wrong limb agrees with itself, in both directions. But it is not as far
from the right ones on one shape as on the other, and its neighborhoods are less alike. So each
pair of correspondences is asked whether its lengths on both shapes agree, and those in conflict
with most of the evidence are dropped, the worst first.
"""

from __future__ import annotations

import numpy as np

from sherd.arrays import Bools, Floats
from sherd.correspondence.labels.labeling import (
    LENGTH_SIGMA,
    STRETCH_SIGMA,
    Labeling,
    Problem,
    pair_costs,
    unary_cost,
)
from sherd.correspondence.labels.labeling import SIMILARITY_STEP

__all__ = ["consistent_nodes", "node_costs"]

# Lengths in conflict differ by more than two sigma, where a limit says "wrong" and not more.
SIGMAS = 2.0
# Cuts lengthen some paths, so a right correspondence may be in conflict with some: on generated
# and animated cuts with one pair in a hundred, a wrong limb with a quarter to nine tenths.
MOST_CONFLICT = 0.12
# A node that is worth less than its price still says something where none is worth more.
LEAST_WORTH = 0.02


def node_costs(problem: Problem, labeling: Labeling) -> Floats:
    """What each node (k,) costs at its label: lack of similarity and half of its edges' costs."""
    labels, rotations = labeling.labels[:, None], labeling.rotations[:, None]
    paid = pair_costs(problem, labels, rotations)[:, 0, 0]
    paid = np.where(labeling.placed[problem.edges].all(axis=1), paid, 0.0)
    count = len(problem.nodes)
    half = sum(np.bincount(end, 0.5 * paid, minlength=count) for end in problem.edges.T)
    cost: Floats = unary_cost(problem, labels, rotations, SIMILARITY_STEP)[:, 0] + half
    return cost


def consistent_nodes(
    problems: tuple[Problem, Problem],
    labelings: tuple[Labeling, Labeling],
    agrees: tuple[Bools, Bools],
    prices: tuple[float, float],
) -> tuple[Bools, Bools]:
    """The nodes (k,) of both directions that agree and can be true together.

    Parameters
    ----------
    problems, labelings
        Nodes of the second shape on the first, and of the first on the second.
    agrees
        (k,) bool each, what there is to choose from.
    prices
        Cost from which on a node has no worth.
    """
    worth = np.concatenate(
        [
            _areas(problem) * (np.maximum(1.0 - node_costs(problem, labeling) / price, 0) + LEAST_WORTH)
            for problem, labeling, price in zip(problems, labelings, prices, strict=True)
        ]
    )
    on_first, on_second = _lengths(problems, labelings)
    shorter = np.minimum(on_first, on_second)
    known = np.isfinite(on_first) & np.isfinite(on_second)
    sigma = LENGTH_SIGMA + STRETCH_SIGMA * np.where(known, shorter, 0.0)
    off = np.abs(np.where(known, on_first, 0.0) - np.where(known, on_second, 0.0))
    conflict = off > SIGMAS * sigma
    kept = np.concatenate(agrees)
    against = conflict @ (worth * kept)
    total = float(worth[kept].sum())
    while kept.any():
        share = np.where(kept, against, 0.0) / max(total, 1e-300)
        # of two that are equally in conflict the one that is worth less
        worst = int(np.lexsort((worth, -share))[0])
        if share[worst] <= MOST_CONFLICT:
            break
        kept[worst] = False
        total -= worth[worst]
        against -= conflict[worst] * worth[worst]
    count = len(problems[0].nodes)
    return kept[:count], kept[count:]


def _areas(problem: Problem) -> Floats:
    part = problem.question.part
    areas: Floats = np.bincount(
        part.sparse.cells, part.mesh.vertex_areas, minlength=len(part.sparse)
    )
    return areas


def _lengths(
    problems: tuple[Problem, Problem], labelings: tuple[Labeling, Labeling]
) -> tuple[Floats, Floats]:
    """Distances (k, k) between all correspondences of both directions, on either shape."""
    forward, backward = problems
    first, second = forward.question.full, forward.question.part
    one, other = labelings
    across_first = first.dense.distances[one.labels][:, backward.nodes.vertices]
    on_first = np.block(
        [
            [first.dense.between[np.ix_(one.labels, one.labels)], across_first],
            [across_first.T, backward.nodes.between],
        ]
    )
    across_second = second.dense.distances[other.labels][:, forward.nodes.vertices]
    on_second = np.block(
        [
            [forward.nodes.between, across_second.T],
            [across_second, second.dense.between[np.ix_(other.labels, other.labels)]],
        ]
    )
    return on_first.astype(np.float64), on_second.astype(np.float64)
