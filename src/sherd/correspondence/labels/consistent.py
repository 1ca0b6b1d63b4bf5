"""Which of the nodes that both directions agree on can be true together.

A group of nodes on the wrong limb agrees with itself, in both directions. But it is not as far
from the right ones on one shape as on the other, and its neighborhoods are less alike. So each
pair of correspondences is asked whether its lengths on both shapes agree, and those in conflict
with most of the evidence are dropped, the worst first. What is left falls into groups of neighbors
that agree with each other; a group that costs clearly more than the best is dropped as well.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from sherd.arrays import Bools, Floats, Ints
from sherd.correspondence.labels.labeling import (
    LENGTH_SIGMA,
    SIMILARITY_STEP,
    STRETCH_SIGMA,
    Labeling,
    Problem,
    pair_costs,
    unary_cost,
)

__all__ = [
    "PLACE_WIDTH",
    "SAME_PLACE",
    "consistent_groups",
    "consistent_nodes",
    "missing_area",
    "node_areas",
    "node_costs",
    "node_lacks",
    "same_place",
]

# Lengths in conflict differ by more than two sigma, where a limit says "wrong" and not more.
SIGMAS = 2.0
# Cuts lengthen some paths, so a right correspondence may be in conflict with some: on ten pairs of
# cuts of SHREC'16 with one pair of nodes in a hundred, a wrong limb with a quarter to nine tenths.
MOST_CONFLICT = 0.12
# A node that is worth less than its price still says something where none is worth more.
LEAST_WORTH = 0.02
# Neighbors within two spacings of nodes, whose edge costs no more than one sigma in length and
# direction, belong to one group.
GROUP_REACH, GROUP_COST = 0.12, 1.0
# A limb laid on its mirrored twin costs 1.7 times what the right ones cost; right groups of one
# pair differ by less than a third.
MOST_COST = 1.4
# Labels closer than the radius of the largest neighborhood are not told apart.
PLACE_WIDTH = 0.1
# Two answers are one where they lay half of the smaller at the same places.
SAME_PLACE = 0.5


def node_costs(problem: Problem, labeling: Labeling) -> Floats:
    """What each node (k,) costs at its label: lack of similarity and half of its edges' costs."""
    labels, rotations = labeling.labels[:, None], labeling.rotations[:, None]
    paid = pair_costs(problem, labels, rotations)[:, 0, 0]
    paid = np.where(labeling.placed[problem.edges].all(axis=1), paid, 0.0)
    count = len(problem.nodes)
    half = sum(np.bincount(end, 0.5 * paid, minlength=count) for end in problem.edges.T)
    cost: Floats = node_lacks(problem, labeling) + half
    return cost


def node_lacks(problem: Problem, labeling: Labeling) -> Floats:
    """What each node (k,) pays for how much less alike its label is than the best one."""
    labels, rotations = labeling.labels[:, None], labeling.rotations[:, None]
    lack: Floats = unary_cost(problem, labels, rotations, SIMILARITY_STEP)[:, 0]
    return lack


def consistent_groups(problem: Problem, labeling: Labeling, chance: float) -> list[Bools]:
    """Groups (k,) of neighbors that agree with each other; what saves most against chance first."""
    groups = _groups(problem, labeling, labeling.placed)
    found = []
    for group in range(int(groups.max()) + 1):
        inside = groups == group
        alone = replace(labeling, placed=inside)
        less = 1.0 - node_costs(problem, alone) / max(chance, 1e-12)
        found.append((float((node_areas(problem) * less)[inside].sum()), inside))
    return [inside for _, inside in sorted(found, key=lambda each: -each[0])]


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
    both = tuple(zip(problems, labelings, strict=True))
    costs = np.concatenate([node_costs(*each) for each in both])
    price = np.repeat(prices, [len(problem.nodes) for problem in problems])
    areas = np.concatenate([node_areas(problem) for problem in problems])
    worth = areas * (np.maximum(1.0 - costs / price, 0) + LEAST_WORTH)
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
    for rows, each in ((slice(0, count), both[0]), (slice(count, None), both[1])):
        groups = _groups(*each, kept[rows])
        kept[rows] &= _as_good_as_best(groups, costs[rows], worth[rows], areas[rows])
    return kept[:count], kept[count:]


def _groups(problem: Problem, labeling: Labeling, kept: Bools) -> Ints:
    """The group (k,) of each node that is kept, -1 for the others."""
    labels, rotations = labeling.labels[:, None], labeling.rotations[:, None]
    weight = np.maximum(problem.measures.weight, 1e-12)  # 0 between components
    paid = pair_costs(problem, labels, rotations)[:, 0, 0] / weight
    near = kept[problem.edges].all(axis=1) & (problem.measures.length < GROUP_REACH)
    tied = problem.edges[near & (paid < GROUP_COST)]
    count = len(kept)
    graph = sparse.coo_array((np.ones(len(tied)), tied.T), shape=(count, count))
    _, groups = csgraph.connected_components(graph, directed=False)
    result: Ints = np.where(kept, groups, -1)
    return result


def _as_good_as_best(groups: Ints, costs: Floats, worth: Floats, areas: Floats) -> Bools:
    """Whether each node (k,) is in a group that costs about as little as the one of most worth."""
    inside = groups >= 0
    if not inside.any():
        return inside
    count = int(groups.max()) + 1
    area = np.bincount(groups[inside], areas[inside], minlength=count)
    paid = np.bincount(groups[inside], (areas * costs)[inside], minlength=count)
    mean = paid / np.maximum(area, 1e-300)
    best = int(np.bincount(groups[inside], worth[inside], minlength=count).argmax())
    good: Bools = inside & (mean[np.maximum(groups, 0)] <= MOST_COST * mean[best])
    return good


def missing_area(problem: Problem, kept: Labeling) -> float:
    """Area of what the full shape must have too, by the nodes that are kept, and is not found.

    A node that is not kept lies beside one that is: if the label of that one is farther from the
    full shape's cut than the two are apart, the full shape has the node's place. Two shapes that
    were cut from one whole both have it, so something is wrong there: what is shared ends where
    either shape does. Where one limb is laid on another it ends anywhere.
    """
    inside, outside = np.flatnonzero(kept.placed), np.flatnonzero(~kept.placed)
    if len(inside) == 0 or len(outside) == 0:
        return 0.0
    apart = problem.nodes.between[np.ix_(outside, inside)]
    nearest = inside[apart.argmin(axis=1)]
    missing = problem.label_depth[kept.labels[nearest]] > apart.min(axis=1)
    return float(node_areas(problem)[outside[missing]].sum())


def node_areas(problem: Problem) -> Floats:
    """Area (k,) of the part that is nearest to each node."""
    part = problem.question.part
    cells, areas = part.sparse.cells, part.mesh.vertex_areas
    result: Floats = np.bincount(cells, areas, minlength=len(part.sparse)).astype(np.float64)
    return result


def same_place(
    problems: tuple[Problem, Problem],
    found: tuple[tuple[Labeling, Labeling], tuple[Labeling, Labeling]],
    kept: tuple[tuple[Bools, Bools], tuple[Bools, Bools]],
) -> bool:
    """Whether two answers place half of the smaller one, by area, at about the same labels.

    `found` and `kept` (k,) are of the one and of the other answer, in both directions each.
    """
    same, least = 0.0, 0.0
    for side, problem in enumerate(problems):
        areas, between = node_areas(problem), problem.labels.between
        mine, yours = kept[0][side], kept[1][side]
        near = between[found[0][side].labels, found[1][side].labels] < PLACE_WIDTH
        same += float(areas[mine & yours & near].sum())
        least += min(float(areas[mine].sum()), float(areas[yours].sum()))
    return same >= SAME_PLACE * max(least, 1e-12)


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
