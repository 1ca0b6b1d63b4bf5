"""One question to two unions, and what earlier answers to their parts say of the answer.

Larger unions have what their parts have: what was sure of these is recalled where an answer is not,
what was likely of these and is left out contradicts it.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

import numpy as np

from sherd.arrays import Bools, Ints
from sherd.correspondence.confidence import LEAST
from sherd.correspondence.shared.judgment import shared_area
from sherd.puzzle.growing.common_places import left_out, recalled, taken_by
from sherd.puzzle.growing.record import CROWD, Growth, chance_at, laid_there, odds_of
from sherd.puzzle.growing.union import Join, Union
from sherd.puzzle.pairwise.answer import JOINED, LIKELY, Ground, Meeting, ground_of
from sherd.puzzle.pairwise.body import Told
from sherd.puzzle.pairwise.meeting import NOTHING_KNOWN

__all__ = [
    "Asking",
    "Meet",
    "against",
    "asked",
    "common_area",
    "remembering",
    "share_enough",
    "unless_strangers",
]

# Two strangers, neither of which has the root of a group, share more than this of the area of the
# first root, or are not believed: no larger union will see it again. A man's limb on a part of a
# cat, neither of which the man's others knew, had 0.91 by all that is seen (0.96 in the unit of the
# largest piece), with a common area of 0.04; the three right joins of such pairs, of a cat and a
# wolf, have 0.10, 0.21 and 0.25. Half way by ratio.
BESIDE = 0.065

# So many answers with something recalled are remembered: when groups are completed these are asked
# once more, mostly those that were asked last. Each holds what both surfaces were described by.
REMEMBERED = 4

# The larger union, the other one, pairs (p, 2) of vertices that lie on each other, and the vertices
# (n,) of the larger one where the other does not lie, if there are any.
Meet = Callable[[Union, Union, Ints, Bools | None], Meeting]


@dataclass(frozen=True)
class Asking:
    """The ways in which two unions are asked, the larger one first.

    Attributes
    ----------
    meet
        What they share; what is given besides is known of them.
    glance
        The same where that is plain to see, a third of the time where it is not.
    lay
        What they share if the other lies where that is told.
    across
        Where the other lies across from its twin on the larger one; None if it does not.
    as_a_part
        The chance that the other, or its mirror image, is matched rightly with the larger one as
        its whole.
    mirrored
        What the larger one shares with the mirror image of the other, where that is plain to see.
    kinship
        How much more alike the skin of pieces is to that of others than to its reverse, both by
        their numbers; see :class:`sherd.puzzle.growing.kinship.Kinship`.
    """

    meet: Meet
    glance: Callable[[Union, Union], Meeting]
    lay: Callable[[Union, Union, Told], Meeting]
    across: Callable[[Union, Union], Meeting | None]
    as_a_part: Callable[[Union, Union], float]
    mirrored: Callable[[Union, Union], Meeting]
    kinship: Callable[[Collection[int], Collection[int]], float]


def remembering(meet: Meet) -> Meet:
    """The same, but what was recalled of two unions is not asked twice."""
    said: deque[tuple[Union, Union, Ints, Bools | None, Meeting]] = deque(maxlen=REMEMBERED)

    def met(first: Union, second: Union, known: Ints, taken: Bools | None) -> Meeting:
        for one, other, recalled_before, taken_before, found in said:
            if (
                one is first
                and other is second
                and np.array_equal(recalled_before, known)
                and _equal(taken_before, taken)
            ):
                return found
        found = meet(first, second, known, taken)
        if len(known):
            said.append((first, second, known, taken, found))
        return found

    return met


def _equal(one: Bools | None, other: Bools | None) -> bool:
    if one is None or other is None:
        return one is other
    return np.array_equal(one, other)


def asked(first: Union, second: Union, meet: Meet, growth: Growth) -> Join:
    """The answer of two unions, the larger one first; what is likely is kept in mind.

    So is what fills a gap of one of them, and how much is recognized, however likely.
    """

    def met(one: Union, other: Union, known: Ints, taken: Bools | None) -> Meeting:
        found = meet(one, other, known, taken)
        if found.in_gap is not None:
            growth.in_gaps.append(Join(one, other, found.in_gap))
        key = (one.members, other.members)
        growth.recognized[key] = max(found.recognized, growth.recognized.get(key, 0.0))
        return found

    join = _answered(first, second, met, growth)
    growth.keep_in_mind(join)
    return join


def unless_strangers(join: Join, growth: Growth) -> Join:
    """The same, but that tells nothing of two that share too little, neither of which has a root.

    What was kept in mind of it is forgotten.
    """
    if growth.has_root(join.members) or share_enough(join, growth):
        return join
    growth.forget(join)
    return join.with_chance(LEAST)


def share_enough(join: Join, growth: Growth) -> bool:
    """Whether strangers are believed that share so much."""
    return common_area(join) >= BESIDE * growth.root.mesh.area


def common_area(join: Join) -> float:
    """What both share, in the unit of their meshes."""
    return shared_area(join.met.questions, join.met.placements) * join.met.unit**2


def _answered(first: Union, second: Union, meet: Meet, growth: Growth) -> Join:
    """The answer of two unions; if it is not sure, that elsewhere or with what was sure recalled.

    What is laid on its twin has another place, so it is asked where else it lies. If it surely does
    it is kept from its twin's place from then on; a right place may look like a twin's, too. What
    lies where it surely lay before is likely to, see `_confirmed`; what is sure must not contradict
    what was likely, see `_uncontradicted`, and what is not is asked where that was, too.
    """
    taken = growth.taken(first, second)
    join = Join(first, second, meet(first, second, NOTHING_KNOWN, taken))
    if join.met.twin:
        place = taken_by(join, first)
        place = place if taken is None else taken | place
        elsewhere = Join(first, second, meet(first, second, NOTHING_KNOWN, place))
        if elsewhere.met.chance >= JOINED:
            growth.settle(join, second.members)
            taken = place
        join = max(join, elsewhere, key=_ground_of)
    likely = growth.likely_before(first, second)
    contradicting = [each for each in likely if left_out(each, join) > CROWD]
    if join.met.chance >= JOINED:
        return _uncontradicted(join, contradicting, taken, meet)
    before = next(iter([*growth.sure_before(first, second), *contradicting]), None)
    if before is None:
        return join
    known = recalled(before, first, second)
    if len(known):
        again = Join(first, second, meet(first, second, known, taken))
        join = max(join, again, key=_ground_of)
    return _confirmed(join, before)


def _ground_of(join: Join) -> tuple[Ground, float]:
    return ground_of(join.met)


def _uncontradicted(
    join: Join, contradicting: Sequence[Join], taken: Bools | None, meet: Meet
) -> Join:
    """A sure answer, or what is likelier, where earlier ones contradict it.

    They are at another place, and one of both is right, or none (a conditional logit, as of the
    places of one question). The likeliest earlier place is asked again with what was said of it.
    """
    if not contradicting:
        return join
    before = contradicting[0]
    known = recalled(before, join.first, join.second)
    if len(known):
        again = Join(join.first, join.second, meet(join.first, join.second, known, taken))
        if left_out(before, again) <= CROWD:
            if odds_of(again) > odds_of(join):
                return against(again, join)
            before = max(before, again, key=_ground_of)
    return against(join, before)


def against(join: Join, rival: Join) -> Join:
    """An answer that another one contradicts: of both places one is right, or none."""
    odds = odds_of(join) / (1.0 + odds_of(rival))
    return join.with_chance(chance_at(odds))


def _confirmed(join: Join, before: Join) -> Join:
    """An answer that is likely, and as sure as it and an earlier one at the same place are in mean.

    A union has all that the earlier piece of it had there, so both see much of the same; what two
    strangers said apart would count as the sum of their log odds, and not as the mean.
    """
    repeated = LIKELY <= join.met.chance < JOINED and laid_there(before, join, join.second.members)
    if not repeated:
        return join
    odds = math.sqrt(odds_of(before) * odds_of(join))
    return join.with_chance(chance_at(odds))
