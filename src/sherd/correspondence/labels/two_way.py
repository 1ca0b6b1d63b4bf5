"""Two incomplete shapes labeled there and back, each node with a label or nowhere.

Each direction is labeled alone first, as if the other shape were full and with nowhere as a label.
What both shapes have then often lies right in one direction only: a piece that lies
within the other shape finds its place, while the other shape, most of which the piece lacks, lies
anywhere, consistent with itself, and does not follow. And within one direction what is shared is
often a minority: all the rest agrees on another place. So there are many starts: either direction,
or one group of its neighbors that agree with each other, leads, and its inverse is the start of the
other. Then both are labeled again, each with what the other says among its candidates, and the
group grows. Those starts go on whose nodes save most against nowhere, in both directions together,
the less the more is missing: where a shape goes on beside what is shared, and the other one does
too, they must share that as well.

Nowhere costs half of what a node costs where nothing belongs together: the nodes are given each
other's similarities, which leaves shapes, cuts and likeness what they are and only mixes up what
looks like what, and labeled once. So a group of nodes is placed if it is nearer to a perfect answer
than to chance.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias, TypeVar

import numpy as np

from sherd.arrays import Bools
from sherd.correspondence.labels.anchors import (
    candidates_again,
    chance_energy,
    first_labeling,
    proposed_anchors,
)
from sherd.correspondence.labels.consistent import (
    consistent_groups,
    consistent_nodes,
    missing_area,
    node_areas,
    node_costs,
)
from sherd.correspondence.labels.inverse import closing_nodes, inverse_labeling, inverse_labels
from sherd.correspondence.labels.labeling import LIMIT, NOWHERE_COST, Labeling, Problem, solve
from sherd.threads import side_by_side

__all__ = ["Both", "TwoLabelings", "two_way_labelings"]

# Half way between a perfect answer, which costs nothing, and chance. With their true labels nodes
# of one animal cost a fifth of chance on average, those of other species 0.35 to 0.8 (four pairs of
# SMAL), so half of these go nowhere. At 0.65 more of them stay, and more of what is wrong: of 24
# pairs of cuts the mean error was 2.1 instead of 1.1.
PRICE_SHARE = 0.5
# Price that whole labelings start with, besides none: at half of chance half of what two species
# share goes nowhere, so a start has little to hold on to; what a higher price lets in that is wrong
# goes in the rounds, in which it is half again.
STARTING_PRICE = 0.7
# So many groups of either labeling start too, those that save most against chance. Where different
# species share a third of a body the right group is often not the first: of ten such pairs that
# came out wrong without groups (SMAL), nine had a group of ten and more nodes of which most were
# right, and in all six of these that were looked into it was among the first four.
GROUPS = 4
# After a round to hear of the other direction so many starts go on, then one.
LEFT = (4, 1)
# A placement that misses a fifth of what it keeps counts a third (1 / e): right placements hardly
# miss anything, wrong ones a seventh of what they keep (SMAL), and what is found is found nearly as
# alike in wrong places. At four times a wrong placement of a horse's cut that keeps more saves as
# much as the right one; between three and eight the choice between species is the same.
MISSING_WEIGHT = 5.0
# What a node that counts as evidence may cost, as a share of chance: half of the price. A right one
# costs a fifth on average, one on a wrong limb a third.
WORTH_SHARE = 0.25

Kind = TypeVar("Kind")
Both: TypeAlias = tuple[Kind, Kind]


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
    worth
        What the nodes that are kept save against nowhere, the less the more is missing, over their
        area: half is perfect.
    first_ratio
        Energy of a first labeling, which has only similar places to choose from, over that by
        chance, near 1 where nothing is alike; of the better direction, as a piece that lies within
        the other shape is alike all over, and the other shape is not.
    """

    forward: Labeling
    backward: Labeling
    forward_agrees: Bools
    backward_agrees: Bools
    chance: Both[float]
    agreement: float
    worth: float
    first_ratio: float


@dataclass(frozen=True, eq=False)
class _Alone:
    """What one direction says alone, without hearing of the other.

    The energy of its nodes by chance and that of a first labeling over it, and what to start from:
    labelings of all nodes, and of groups of them.
    """

    chance: float
    first_ratio: float
    wholes: list[Labeling]
    groups: list[Labeling]


@dataclass(frozen=True, eq=False)
class _Agreed:
    """Both labelings after a round, placed where `agrees`; `placed` before, and what it saves."""

    found: Both[Labeling]
    agrees: Both[Bools]
    placed: Both[int]
    saved: float


def two_way_labelings(
    forward: Problem, backward: Problem, rngs: tuple[np.random.Generator, np.random.Generator]
) -> TwoLabelings:
    """Label both directions, each hearing of the other, from the start that saves most.

    Parameters
    ----------
    forward, backward
        Problems without a price: the nodes of each are those of the other's labels' shape.
    rngs
        One for each direction, so that swapping the shapes swaps the answer.
    """
    problems = (forward, backward)
    there, back = side_by_side(
        partial(_alone, problem, rng) for problem, rng in zip(problems, rngs, strict=True)
    )
    chance = (there.chance, back.chance)
    starts = _led(problems, there.wholes, back.wholes)
    starts += _led(problems, there.groups, back.groups)
    tried = _all_agreed(problems, chance, starts, inside=1.0)
    for left in LEFT:
        # where none saves anything, swapping the shapes must still swap what is chosen
        tried = sorted(tried, key=_worth, reverse=True)[:left]
        again = _all_agreed(problems, chance, [each.found for each in tried], inside=LIMIT)
        tried = [max(pair, key=_worth) for pair in zip(tried, again, strict=True)]
    best = max(tried, key=_worth)
    kept = sum(
        float(node_areas(problem)[agrees].sum())
        for problem, agrees in zip(problems, best.agrees, strict=True)
    )
    worth = best.saved / kept if kept > 0 else 0.0
    ratio = min(there.first_ratio, back.first_ratio)
    return TwoLabelings(*best.found, *best.agrees, chance, _agreement(best), worth, ratio)


def _alone(problem: Problem, rng: np.random.Generator) -> _Alone:
    """Label one direction as if the other did not exist."""
    chance = chance_energy(problem, rng)
    first = first_labeling(problem)
    whole = proposed_anchors(problem, first)
    groups = consistent_groups(problem, whole, chance)[:GROUPS]
    # nodes that the other shape lacks then neither say where others lie nor take their places
    priced = problem.priced(STARTING_PRICE * chance)
    return _Alone(
        chance=chance,
        first_ratio=first.energy / max(chance, 1e-12),
        wholes=[whole, proposed_anchors(priced, first_labeling(priced))],
        groups=[_only(whole, group) for group in groups],
    )


def _led(
    problems: Both[Problem], ones: list[Labeling], others: list[Labeling]
) -> list[Both[Labeling]]:
    """Each labeling of either direction with its inverse as that of the other."""
    forward, backward = problems
    starts = [(one, inverse_labeling(backward, one)) for one in ones]
    return starts + [(inverse_labeling(forward, other), other) for other in others]


def _all_agreed(
    problems: Both[Problem],
    chance: Both[float],
    starts: list[Both[Labeling]],
    *,
    inside: float,
) -> list[_Agreed]:
    """One round from each start."""
    return side_by_side(
        partial(_agreed, problems, chance, start, inside=inside) for start in starts
    )


def _agreed(
    problems: Both[Problem],
    chance: Both[float],
    start: Both[Labeling],
    *,
    inside: float,
) -> _Agreed:
    """One round: both labeled again, each hearing of the other, and what can be true together."""
    priced = [
        problem.priced(PRICE_SHARE * energy, inside=inside)
        for problem, energy in zip(problems, chance, strict=True)
    ]
    found = (
        _labeled_again(priced[0], start[0], start[1]),
        _labeled_again(priced[1], start[1], start[0]),
    )
    closing = (
        closing_nodes(problems[0], found[0], found[1]),
        closing_nodes(problems[1], found[1], found[0]),
    )
    worth = (WORTH_SHARE * chance[0], WORTH_SHARE * chance[1])
    agrees = consistent_nodes(problems, found, closing, worth)
    # the next round hears only of what can be true together
    kept = (_only(found[0], agrees[0]), _only(found[1], agrees[1]))
    placed = (int(found[0].placed.sum()), int(found[1].placed.sum()))
    return _Agreed(kept, agrees, placed, _saved(problems, kept, chance))


def _saved(problems: Both[Problem], kept: Both[Labeling], chance: Both[float]) -> float:
    """What the nodes that are kept save against nowhere, as a share of chance, times their area.

    So a few nodes that are much alike save as much as twice as many that are hardly worth their
    price. Times `exp(-5 missing / kept area)`.
    """
    saved = missing = area = 0.0
    for problem, labeling, energy in zip(problems, kept, chance, strict=True):
        less = PRICE_SHARE - node_costs(problem, labeling) / max(energy, 1e-12)
        areas = node_areas(problem)[labeling.placed]
        saved += float(areas @ less[labeling.placed])
        area += float(areas.sum())
        missing += missing_area(problem, labeling)
    if saved <= 0:
        return saved
    return saved * float(np.exp(-MISSING_WEIGHT * missing / area))


def _agreement(agreed: _Agreed) -> float:
    shares = [
        int(kept.sum()) / max(placed, 1)
        for kept, placed in zip(agreed.agrees, agreed.placed, strict=True)
    ]
    return float(np.sqrt(shares[0] * shares[1]))


def _only(labeling: Labeling, kept: Bools) -> Labeling:
    cost = np.where(kept, labeling.local_cost, NOWHERE_COST)
    return replace(labeling, placed=kept, local_cost=cost)


def _labeled_again(problem: Problem, own: Labeling, other: Labeling) -> Labeling:
    labels, rotations = candidates_again(problem, own, also=inverse_labels(problem, other))
    return solve(problem, labels, rotations)


def _worth(agreed: _Agreed) -> tuple[float, float]:
    return agreed.saved, -agreed.found[0].energy - agreed.found[1].energy
