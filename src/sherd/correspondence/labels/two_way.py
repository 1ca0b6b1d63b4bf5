"""Two incomplete shapes labeled there and back, each node with a label or nowhere.

Each direction is labeled alone first, as if the other shape were full and with nowhere as a label.
What both have then often lies right in one direction only: a piece that lies within the other shape
finds its place, while the other shape, most of which the piece lacks, lies anywhere, consistent
with itself, and does not follow. And within one direction what is shared is often a minority: all
the rest agrees on another place. So there are many starts: either direction, or a group of its
neighbors that agree with each other, leads, and its inverse is the start of the other; groups only
where no whole labeling is clearly right. Then both are labeled again, each with what the other says
among its candidates, and the group grows. Those starts go on whose nodes save most against nowhere,
in both directions together, the less the more is missing: where both shapes go on beside what is
shared, they must share that as well.

Nowhere costs half of what a node costs where nothing belongs together: the nodes are given each
other's similarities, which leaves shapes, cuts and likeness what they are and only mixes up what
looks like what, and labeled once. So a group of nodes is placed if it is nearer to a perfect answer
than to chance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias, TypeVar

import numpy as np

from sherd.arrays import Bools
from sherd.correspondence.labels.anchors import (
    candidates_again,
    candidates_around,
    chance_energy,
    first_labeling,
    proposed_anchors,
)
from sherd.correspondence.labels.consistent import (
    consistent_groups,
    consistent_nodes,
    node_areas,
    same_place,
)
from sherd.correspondence.labels.inverse import (
    closing_nodes,
    following,
    inverse_labeling,
    inverse_labels,
)
from sherd.correspondence.labels.labeling import LIMIT, NOWHERE_COST, Labeling, Problem, solve
from sherd.correspondence.labels.saved import PRICE_SHARE, lack, most_saved, saved
from sherd.threads import side_by_side

__all__ = [
    "Agreed",
    "Both",
    "TwoLabelings",
    "all_agreed",
    "described",
    "elsewhere",
    "finished",
    "grown_apart",
    "labeled_around",
    "led",
    "only_placed",
    "two_way_labelings",
]

# Price that whole labelings start with, besides none: at half of chance half of what two species
# share goes nowhere, so a start has little to hold on to; what a higher price lets in that is wrong
# goes in the rounds, in which it is half again.
STARTING_PRICE = 0.7
# So many groups of either labeling start too, those that save most against chance. Where species
# share a third of a body the right group is often not the first: of ten such pairs that came out
# wrong without groups (SMAL) nine had a right one, in all six looked into among the first four.
GROUPS = 4
# After a round to hear of the other direction so many starts go on, then one.
LEFT = (4, 1)
# A whole labeling that saves so much of what a perfect one of all of the smaller shape would is no
# minority that has to grow from a group: a half of the generated animal on all of it saves 0.74,
# two wolves 0.79. Of 33 pairs (half of SMAL's, eight of cuts) no wrong one is above 0.17. At half
# two animals stop at a worse start of the same place (vertex IoU 0.85 instead of 0.90).
SETTLED = 0.6
# Of different places that grow so many go on, then fewer: from a third of what is shared to all
# takes two rounds or three (front and rear of the generated animal that share 0.3, two poses).
GROWN_LEFT = (4, 2, 1)
# The answer itself still grows where species share a third: most are done after one round, a lion
# and a cow (SMAL) go from 0.69 of the nodes right to 0.78 in three.
FINISHING = 3
# At last what is kept grows once into what did not agree, where nowhere costs as much as at the
# start; what that lets in goes if it saves less by the price of half. (Two dogs of SMAL: 0.55 of
# what is shared is found before, 0.93 then; most answers stay as they are.)
FILLING_PRICE = STARTING_PRICE
# What grows so takes nodes along wherever it lies. It is believed if its nodes cost a fifth of
# chance, as those of one animal do where they are right, and nothing is missing: front and rear of
# the generated animal save 0.36 per area, wrong places of half of SMAL and of nine views 0.27 at
# most.
SURE = 0.3
# What a node that counts as evidence may cost, over chance: half of the price. A right one costs a
# fifth on average, one on a wrong limb a third.
WORTH_SHARE = 0.25

Kind = TypeVar("Kind")
Both: TypeAlias = tuple[Kind, Kind]
_Labels: TypeAlias = Callable[[Problem, Labeling, Labeling], Labeling]


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
    lack
        What the nodes that are kept pay for being less alike than the best label, as a share of
        chance; mean of both directions, 0 if none is kept.
    first_ratio
        Energy of a first labeling, which has only similar places to choose from, over that by
        chance, near 1 where nothing is alike; of the better direction, as a piece within the other
        shape is alike all over, and the other shape is not.
    """

    forward: Labeling
    backward: Labeling
    forward_agrees: Bools
    backward_agrees: Bools
    chance: Both[float]
    agreement: float
    worth: float
    lack: float
    first_ratio: float


@dataclass(frozen=True, eq=False)
class _Alone:
    """What one direction says alone, without hearing of the other.

    The energy of its nodes by chance, that of a first labeling over it, and the labeling after it.
    """

    chance: float
    first_ratio: float
    whole: Labeling


@dataclass(frozen=True, eq=False)
class Agreed:
    """Both labelings after a round, placed where `agrees`; the `agreement`, and what it saves."""

    found: Both[Labeling]
    agrees: Both[Bools]
    agreement: float
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
    alone = side_by_side(
        partial(_alone, problem, rng) for problem, rng in zip(problems, rngs, strict=True)
    )
    chance = (alone[0].chance, alone[1].chance)
    settled = SETTLED * most_saved(problems)
    begun: list[Agreed] = []
    for starts in (_wholes, _priced_wholes, _groups):
        begun += all_agreed(problems, chance, led(problems, *starts(problems, alone)))
        best = max(begun, key=_worth)
        if best.saved >= settled:
            break
    unsettled = best.saved < settled
    best = _continued(problems, chance, begun)
    if unsettled:
        grown = _grown(problems, chance, begun)
        if grown.saved > best.saved and _saved_per_area(problems, grown) >= SURE:
            best = grown
        best = finished(problems, chance, best)
    return described(problems, chance, best, min(each.first_ratio for each in alone))


def described(
    problems: Both[Problem], chance: Both[float], agreed: Agreed, first_ratio: float
) -> TwoLabelings:
    """The answer after all rounds."""
    return TwoLabelings(
        *agreed.found,
        *agreed.agrees,
        chance,
        agreement=agreed.agreement,
        worth=_saved_per_area(problems, agreed),
        lack=lack(problems, agreed.found, chance),
        first_ratio=first_ratio,
    )


def _alone(problem: Problem, rng: np.random.Generator) -> _Alone:
    """Label one direction as if the other did not exist."""
    chance, first = chance_energy(problem, rng), first_labeling(problem)
    return _Alone(chance, first.energy / max(chance, 1e-12), proposed_anchors(problem, first))


def _wholes(_: Both[Problem], alone: list[_Alone]) -> list[list[Labeling]]:
    """Labelings of either direction to start from: of all nodes."""
    return [[each.whole] for each in alone]


def _priced_wholes(problems: Both[Problem], alone: list[_Alone]) -> list[list[Labeling]]:
    """And of those that are worth a price; the others do not say where these lie."""
    return side_by_side(partial(_priced, *each) for each in zip(problems, alone, strict=True))


def _priced(problem: Problem, alone: _Alone) -> list[Labeling]:
    priced = problem.priced(STARTING_PRICE * alone.chance)
    return [proposed_anchors(priced, first_labeling(priced))]


def _groups(problems: Both[Problem], alone: list[_Alone]) -> list[list[Labeling]]:
    """And of groups of nodes that agree with each other."""
    return [
        [
            only_placed(each.whole, group)
            for group in consistent_groups(problem, each.whole, each.chance)[:GROUPS]
        ]
        for problem, each in zip(problems, alone, strict=True)
    ]


def _continued(problems: Both[Problem], chance: Both[float], tried: list[Agreed]) -> Agreed:
    """What saves most after the rounds in which each direction hears of the other's agreement."""
    for left in LEFT:
        # where none saves anything, swapping the shapes must still swap what is chosen
        tried = sorted(tried, key=_worth, reverse=True)[:left]
        again = all_agreed(problems, chance, [each.found for each in tried], inside=LIMIT)
        tried = [max(pair, key=_worth) for pair in zip(tried, again, strict=True)]
    return max(tried, key=_worth)


def finished(problems: Both[Problem], chance: Both[float], best: Agreed) -> Agreed:
    """One answer in further rounds, while it saves more; see `FINISHING` and `FILLING_PRICE`."""
    for _ in range(FINISHING):
        again = _agreed(problems, chance, best.found, inside=LIMIT, labeled=_labeled_again)
        if again.saved <= best.saved:
            break
        best = again
    filled = _agreed(
        problems, chance, best.found, inside=LIMIT, labeled=labeled_around, price=FILLING_PRICE
    )
    # its nodes heard of little but what agrees, so that they agree now proves nothing
    return replace(filled, agreement=best.agreement) if filled.saved > best.saved else best


def _grown(problems: Both[Problem], chance: Both[float], tried: list[Agreed]) -> Agreed:
    """What saves most of different places that grow from what agrees, and from nothing else.

    In one direction most nodes may belong nowhere, agree on a wrong place and hold back neighbors
    that the other direction brings to the right one. So what did not agree is forgotten.
    """
    return grown_apart(problems, chance, tried, GROWN_LEFT)[0]


def grown_apart(
    problems: Both[Problem], chance: Both[float], tried: list[Agreed], lefts: Sequence[int]
) -> list[Agreed]:
    """Different places that grow, so many in each round as `lefts` says; most saved first."""
    for left in lefts:
        tried = elsewhere(problems, sorted(tried, key=_worth, reverse=True))[:left]
        again = all_agreed(
            problems, chance, [each.found for each in tried], inside=LIMIT, labeled=labeled_around
        )
        tried = [max(pair, key=_worth) for pair in zip(tried, again, strict=True)]
    return elsewhere(problems, sorted(tried, key=_worth, reverse=True))


def elsewhere(problems: Both[Problem], tried: list[Agreed]) -> list[Agreed]:
    """Those that lay most of what they share with none before them at the same places."""
    different: list[Agreed] = []
    for each in tried:
        if not any(_same_place(problems, each, other) for other in different):
            different.append(each)
    return different


def _same_place(problems: Both[Problem], one: Agreed, other: Agreed) -> bool:
    found, kept = (one.found, other.found), (one.agrees, other.agrees)
    return same_place(problems, found, kept)


def led(
    problems: Both[Problem], ones: list[Labeling], others: list[Labeling]
) -> list[Both[Labeling]]:
    """Each labeling of either direction with its inverse as that of the other."""
    forward, backward = problems
    starts = [(one, inverse_labeling(backward, one)) for one in ones]
    return starts + [(inverse_labeling(forward, other), other) for other in others]


def all_agreed(
    problems: Both[Problem],
    chance: Both[float],
    starts: list[Both[Labeling]],
    *,
    inside: float = 1.0,
    labeled: _Labels | None = None,
) -> list[Agreed]:
    """One round from each start; see :func:`_agreed`."""
    labeled = labeled or _labeled_again
    return side_by_side(
        partial(_agreed, problems, chance, start, inside=inside, labeled=labeled)
        for start in starts
    )


def _agreed(
    problems: Both[Problem],
    chance: Both[float],
    start: Both[Labeling],
    *,
    inside: float,
    labeled: _Labels,
    price: float = PRICE_SHARE,
) -> Agreed:
    """One round: both labeled again, each hearing of the other, and what can be true together.

    `inside` is what an edge to nowhere costs inside the other shape, `labeled` what labels a
    direction by its own labeling and the other's, `price` what nowhere costs, as a share of chance.
    """
    priced = [
        problem.priced(price * energy, inside=inside)
        for problem, energy in zip(problems, chance, strict=True)
    ]
    found = (
        labeled(priced[0], start[0], start[1]),
        labeled(priced[1], start[1], start[0]),
    )
    closing = (
        closing_nodes(problems[0], found[0], found[1]),
        closing_nodes(problems[1], found[1], found[0]),
    )
    worth = (WORTH_SHARE * chance[0], WORTH_SHARE * chance[1])
    agrees = consistent_nodes(problems, found, closing, worth)
    # the next round hears only of what can be true together
    kept = (only_placed(found[0], agrees[0]), only_placed(found[1], agrees[1]))
    gained = saved(problems, kept, chance)
    return Agreed(following(problems, kept), agrees, _agreement(found, agrees), gained)


def _saved_per_area(problems: Both[Problem], agreed: Agreed) -> float:
    kept = sum(
        float(node_areas(problem)[agrees].sum())
        for problem, agrees in zip(problems, agreed.agrees, strict=True)
    )
    return agreed.saved / kept if kept > 0 else 0.0


def _agreement(found: Both[Labeling], agrees: Both[Bools]) -> float:
    pairs = zip(found, agrees, strict=True)
    shares = [int(kept.sum()) / max(int(each.placed.sum()), 1) for each, kept in pairs]
    return float(np.sqrt(shares[0] * shares[1]))


def only_placed(labeling: Labeling, kept: Bools) -> Labeling:
    """The same, but only the nodes (k,) that are `kept` have a place."""
    cost = np.where(kept, labeling.local_cost, NOWHERE_COST)
    return replace(labeling, placed=kept, local_cost=cost)


def _labeled_again(problem: Problem, own: Labeling, other: Labeling) -> Labeling:
    labels, rotations = candidates_again(problem, own, also=inverse_labels(problem, other))
    return solve(problem, labels, rotations)


def labeled_around(problem: Problem, own: Labeling, other: Labeling) -> Labeling:
    """One direction where its placed nodes and the other direction say; nothing else is tried."""
    return solve(problem, *candidates_around(problem, own, inverse_labels(problem, other)))


def _worth(agreed: Agreed) -> tuple[float, float]:
    return agreed.saved, -agreed.found[0].energy - agreed.found[1].energy
