"""A place of one shape on another: whether it is known, and one direction that follows the other.

Where a place was found in one direction and half lost in the other, the other one follows. Places
that began apart may grow into one, which need not be laid twice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sherd.arrays import Bools
from sherd.correspondence.labels.consistent import node_areas, same_place
from sherd.correspondence.labels.inverse import inverse_labeling
from sherd.correspondence.labels.labeling import Labeling, Problem
from sherd.correspondence.labels.two_way import Agreed, Both, TwoLabelings

__all__ = ["followed", "is_known", "not_said_before"]

# What two shapes share has one area. A direction that keeps less than half of what the other one
# keeps has lost its way: two right answers on pieces of a cat and of a horse have 0.2 and 0.4, laid
# so they cover 0.5 and 0.7 of what is shared, and 0.9 where the other direction is followed.
UNEQUAL = 0.5
# Labelings are one answer if of the nodes that either keeps so many are at one label in both. Of 45
# further places of ten questions eight are the same as an earlier one to the last node; four are
# alike by 0.93 to 0.99, and once laid none of these is likelier than the earlier one, but by 0.004;
# of another question one is, by 0.03.
SAID = 0.9


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


def not_said_before(tried: Sequence[TwoLabelings], known: TwoLabelings) -> list[TwoLabelings]:
    """Those that are not the known answer once more, nor another one's that agrees as much.

    The more they agree the earlier.
    """
    said = [known]
    for each in sorted(tried, key=lambda labelings: labelings.agreement, reverse=True):
        if not any(_says_no_more(each, other) for other in said):
            said.append(each)
    return said[1:]


def _says_no_more(one: TwoLabelings, other: TwoLabelings) -> bool:
    """Whether the one is the answer of the other in both directions, which agree no more on it."""
    if one.agreement > other.agreement:
        return False
    forward = _in_common(one.forward, one.forward_agrees, other.forward, other.forward_agrees)
    backward = _in_common(one.backward, one.backward_agrees, other.backward, other.backward_agrees)
    return min(forward, backward) >= SAID


def _in_common(one: Labeling, kept: Bools, other: Labeling, others_kept: Bools) -> float:
    """Of the nodes that either labeling keeps, the share that both keep at one label.

    All of them if neither keeps any.
    """
    either = kept | others_kept
    if not either.any():
        return 1.0
    return float((kept & others_kept & (one.labels == other.labels)).sum() / either.sum())
