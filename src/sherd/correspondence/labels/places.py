"""Further places of one shape on another, besides the one where most is saved.

What saves most is not always right: half of a body laid on a sixth that is shared may save more
than that sixth. Who has other evidence, of the surfaces themselves, can choose among several. And
where a place was found in one direction and half lost in the other, the other one follows.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sherd.arrays import Bools
from sherd.correspondence.labels.consistent import node_areas, same_place
from sherd.correspondence.labels.inverse import inverse_labeling
from sherd.correspondence.labels.labeling import LIMIT, Labeling, Problem
from sherd.correspondence.labels.local_groups import local_groups
from sherd.correspondence.labels.two_way import (
    Agreed,
    Both,
    TwoLabelings,
    all_agreed,
    described,
    finished,
    grown_apart,
    labeled_around,
    led,
)

__all__ = ["followed", "further_labelings", "is_known"]

# Groups of either direction. Of 12 pairs of pieces of a wolf that share 0.12 and more of the
# smaller one eight had a right group among so many, the last of these the 21st; of 32 one more.
GROUPS = 24
# Different places that go on; of those eight seven right ones were among the last four.
LEFT = (16, 8, 4)
# What two shapes share has one area. A direction that keeps less than half of what the other one
# keeps has lost its way: two right answers on pieces of a cat and of a horse have 0.2 and 0.4, laid
# so they cover 0.5 and 0.7 of what is shared, and 0.9 where the other direction is followed.
UNEQUAL = 0.5


def further_labelings(
    forward: Problem, backward: Problem, known: TwoLabelings
) -> list[TwoLabelings]:
    """Labelings of both directions at different places, what saves most first; four at most.

    None lies where the known one does: to ask there again until the answer pleases proves nothing.
    Two thirds of another person, laid on a woman, had a chance of 0.61 and at the same place 0.65.

    Parameters
    ----------
    forward, backward
        Problems without a price: the nodes of each are those of the other's labels' shape.
    known
        The labeling of both that saves most.
    """
    problems, chance = (forward, backward), known.chance
    groups = [
        local_groups(problem, energy, GROUPS)
        for problem, energy in zip(problems, chance, strict=True)
    ]
    starts = led(problems, *groups)
    tried = all_agreed(problems, chance, starts, inside=LIMIT, labeled=labeled_around)
    places = [
        finished(problems, chance, each)
        for each in grown_apart(problems, chance, tried, LEFT)[: LEFT[-1]]
    ]
    return [
        described(problems, chance, each, known.first_ratio)
        for each in places
        if not is_known(problems, each, known)
    ]


def followed(problems: Both[Problem], labelings: TwoLabelings) -> TwoLabelings:
    """The labelings; where one direction keeps far less, it follows the other beside what it keeps.

    A small piece has many nodes in what is shared, a large one few, with few neighbors there, and
    many that belong elsewhere beside them. So most of these go nowhere, and a placement that begins
    with what both agree on covers a part of what is shared. Where both keep about as much, nothing
    changes.
    """
    directions = (labelings.forward, labelings.backward)
    kept = (labelings.forward_agrees, labelings.backward_agrees)
    areas = [
        float(node_areas(problem)[own].sum()) for problem, own in zip(problems, kept, strict=True)
    ]
    if min(areas) >= UNEQUAL * max(areas):
        return labelings
    lead = int(np.argmax(areas))
    leading = replace(directions[lead], placed=kept[lead])
    behind = _filled(
        directions[1 - lead], kept[1 - lead], inverse_labeling(problems[1 - lead], leading)
    )
    if lead == 0:
        return replace(labelings, backward=behind, backward_agrees=behind.placed)
    return replace(labelings, forward=behind, forward_agrees=behind.placed)


def _filled(own: Labeling, kept: Bools, other: Labeling) -> Labeling:
    """Where `kept` (k,) a labeling's own, elsewhere that of the other."""
    return Labeling(
        np.where(kept, own.labels, other.labels),
        np.where(kept, own.rotations, other.rotations),
        np.where(kept, own.local_cost, other.local_cost),
        own.energy,
        kept | other.placed,
    )


def is_known(problems: Both[Problem], each: Agreed, known: TwoLabelings) -> bool:
    """Whether labelings lie where the known ones do."""
    found = (each.found, (known.forward, known.backward))
    kept = (each.agrees, (known.forward_agrees, known.backward_agrees))
    return same_place(problems, found, kept)
