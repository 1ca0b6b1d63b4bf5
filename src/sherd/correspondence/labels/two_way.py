"""Two incomplete shapes labeled there and back, each node with a label or nowhere.

Each direction is labeled alone first, as if the other shape were full: what both have then mostly
lies where it belongs, and what only one has lies anywhere. Then both are labeled again, with
nowhere as a label and with what the other direction says among the candidates, so that the
direction that went wrong can follow the one that did not.

Nowhere costs half of what a node costs where nothing belongs together: the nodes are given each
other's similarities, which leaves shapes, cuts and likeness what they are and only mixes up what
looks like what, and labeled once. A right labeling costs a quarter to a half of that. So a group
of nodes is placed if it is nearer to a perfect answer than to chance.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.correspondence.labels.anchors import (
    candidates_again,
    chance_energy,
    find_anchors,
    first_labeling,
)
from sherd.correspondence.labels.consistent import consistent_nodes
from sherd.correspondence.labels.labeling import NOWHERE_COST, Labeling, Problem, solve

__all__ = ["TwoLabelings", "two_way_labelings"]

# Half way between a perfect answer, which costs nothing, and chance.
PRICE_SHARE = 0.5
# One round to hear of the other direction, two to follow what both agree on.
ROUNDS = 3
# What a node that counts as evidence may cost, as a share of chance: a right one costs a fifth on
# average, one on a wrong limb a third.
WORTH_SHARE = 0.25
# So many nodes of the other shape say where a node lies; further ones lie two spacings away.
INVERSE = 4
# A node and the four nearest nodes of the other shape's there are as far apart here, up to the
# spacing of labels at both ends and a quarter for stretch (as for pairs of nodes, twice sigma).
CLOSES, CLOSES_STRETCH = 0.05, 0.25


@dataclass(frozen=True, eq=False)
class TwoLabelings:
    """Nodes of the second shape on the first and of the first on the second.

    Attributes
    ----------
    forward, backward
        Nodes of the second shape with labels of the first, and the other way around.
    forward_agrees, backward_agrees
        (k,) bool, nodes that are placed and that the other direction brings back.
    chance
        Energy per node of both when nodes are mixed up.
    agreement
        Of the nodes that were worth their price, the share that both directions agree on:
        geometric mean of both, so that one direction alone proves nothing.
    first_ratio
        Energy of a first labeling, which has only similar places to choose from, over that by
        chance, near 1 where nothing is alike; of the better direction, as a piece that lies within
        the other shape is alike all over, and the other shape is not.
    """

    forward: Labeling
    backward: Labeling
    forward_agrees: Bools
    backward_agrees: Bools
    chance: tuple[float, float]
    agreement: float
    first_ratio: float


def two_way_labelings(
    forward: Problem, backward: Problem, rngs: tuple[np.random.Generator, np.random.Generator]
) -> TwoLabelings:
    """Label both directions, each hearing of the other.

    Parameters
    ----------
    forward, backward
        Problems without a price: the nodes of each are those of the other's labels' shape.
    rngs
        One for each direction, so that swapping the shapes swaps the answer.
    """
    problems = (forward, backward)
    chance = (chance_energy(forward, rngs[0]), chance_energy(backward, rngs[1]))
    start = (first_labeling(forward), first_labeling(backward))
    ratios = [one.energy / max(energy, 1e-12) for one, energy in zip(start, chance, strict=True)]
    found = (find_anchors(forward, start=start[0]), find_anchors(backward, start=start[1]))
    priced = tuple(
        replace(problem, price=PRICE_SHARE * energy)
        for problem, energy in zip(problems, chance, strict=True)
    )
    worth = (WORTH_SHARE * chance[0], WORTH_SHARE * chance[1])
    agrees = (found[0].placed, found[1].placed)
    agreement = 0.0
    for _ in range(ROUNDS):
        found = (
            _labeled_again(priced[0], found[0], found[1]),
            _labeled_again(priced[1], found[1], found[0]),
        )
        closing = (
            closing_nodes(forward, found[0], found[1]),
            closing_nodes(backward, found[1], found[0]),
        )
        agrees = consistent_nodes(problems, found, closing, worth)
        agreement = _agreement(found, agrees)
        # the next round hears only of what can be true together
        found = (_only(found[0], agrees[0]), _only(found[1], agrees[1]))
    return TwoLabelings(*found, *agrees, chance, agreement, min(ratios))


def _agreement(found: tuple[Labeling, Labeling], agrees: tuple[Bools, Bools]) -> float:
    shares = [
        kept.sum() / max(int(labeling.placed.sum()), 1)
        for labeling, kept in zip(found, agrees, strict=True)
    ]
    return float(np.sqrt(shares[0] * shares[1]))


def _only(labeling: Labeling, kept: Bools) -> Labeling:
    cost = np.where(kept, labeling.local_cost, NOWHERE_COST)
    return replace(labeling, placed=kept, local_cost=cost)


def _labeled_again(problem: Problem, own: Labeling, other: Labeling) -> Labeling:
    labels, rotations = candidates_again(problem, own, also=_inverse_labels(problem, other))
    return solve(problem, labels, rotations)


def _inverse_labels(problem: Problem, other: Labeling) -> Ints:
    """Labels (k, INVERSE) of each node where the other direction says: nearest first."""
    near, _ = _nearest_images(problem, other)
    full = problem.question.full
    labels: Ints = full.dense.cells[full.sparse.vertices][near]
    return labels


def _nearest_images(problem: Problem, other: Labeling) -> tuple[Ints, Floats]:
    """The placed nodes (k, INVERSE) of the full shape whose images lie nearest to each node."""
    part = problem.question.part
    reach = part.dense.distances[other.labels][:, problem.nodes.vertices].T
    if other.placed.any():
        reach = np.where(other.placed[None, :], reach, np.inf)
    near = np.argsort(reach, axis=1, kind="stable")[:, :INVERSE]
    return near, np.take_along_axis(reach, near, axis=1).astype(np.float64)


def closing_nodes(problem: Problem, own: Labeling, other: Labeling) -> Bools:
    """Nodes (k,) that are placed and that the other direction brings back.

    Nodes of the full shape near the label of a node have their images as near to the node.
    """
    full, part = problem.question.full, problem.question.part
    there = full.dense.distances[own.labels][:, full.sparse.vertices]  # (k, nodes of full)
    there = np.where(other.placed[None, :], there, np.inf)
    near = np.argsort(there, axis=1, kind="stable")[:, :INVERSE]
    length = np.take_along_axis(there, near, axis=1)
    known = np.isfinite(length)
    back = part.dense.distances[other.labels[near], problem.nodes.vertices[:, None]]
    off = np.abs(np.where(known, back, np.inf) - np.where(known, length, 0.0))
    close = off <= CLOSES + CLOSES_STRETCH * np.where(known, length, 0.0)
    # two of four, so that a single neighbor that went wrong does not decide
    agrees: Bools = own.placed & (close.sum(axis=1) >= INVERSE // 2)
    return agrees
