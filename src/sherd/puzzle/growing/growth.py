"""Groups grown from the largest piece: the surest partner first, then the union is asked again.

Two small pieces share little with each other, and a left leg looks like a right one; with the union
of what is joined already a piece shares more, and its own place there looks more like it than
its twin's. So what was asked of a smaller union is asked again before it is believed. But a twin
that was joined may draw it away from its own place; what was sure before is then recalled.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.puzzle.growing.meeting import Meeting
from sherd.puzzle.growing.union import Join, Union, crowding, recalled, united
from sherd.results.advice import SURE

__all__ = ["Growth", "grown"]

# A union asks so many others, those that cheap evidence ranks first. So seven pieces ask all, and
# of a dozen that belong together each is asked two or three times.
PARTNERS = 8
# Above all chances: who was never asked is asked first.
UNASKED = 2.0
# Of two that are laid on more than half of one place one is wrong, as two arms of a person; neither
# is joined there unless its odds are three times those of the other.
CROWD, DECIDED = 0.5, 3.0

# The larger union, the other one, and pairs (p, 2) of vertices that lie on each other.
Meet = Callable[[Union, Union, Ints], Meeting]
NOTHING = np.empty((0, 2), dtype=np.int64)


@dataclass(eq=False)
class Growth:
    """What was asked and joined.

    Attributes
    ----------
    joins
        In the order in which they were made.
    sure
        What could have been joined, too.
    groups
        The members of each union at the end.
    chances
        By the members of both, the larger one first, of what was asked.
    """

    joins: list[Join] = field(default_factory=list)
    sure: list[Join] = field(default_factory=list)
    groups: list[tuple[int, ...]] = field(default_factory=list)
    chances: dict[tuple[tuple[int, ...], tuple[int, ...]], float] = field(default_factory=dict)


def grown(pieces: Sequence[Union], evidence: Floats, meet: Meet) -> Growth:
    """Join what belongs together.

    Parameters
    ----------
    pieces
        One piece each, numbered as they stand here.
    evidence
        (k, k) symmetric, how much speaks for asking two pieces.
    meet
        Asks two unions, the larger one first; what is given besides is known of them.
    """
    growth = Growth()
    growing = list(pieces)
    done: list[Union] = []
    while growing:
        here = max(growing, key=lambda union: union.mesh.area)
        growing.remove(here)
        others = [*growing, *done]
        partner = _surest(here, others, evidence, meet, growth)
        if partner is None:
            done.append(here)
            continue
        for union in {partner.first, partner.second} - {here}:
            (growing if union in growing else done).remove(union)
        growth.joins.append(partner)
        growing.append(united(partner))
    growth.groups = [union.members for union in done]
    return growth


def _surest(
    here: Union, others: Sequence[Union], evidence: Floats, meet: Meet, growth: Growth
) -> Join | None:
    """The partner that `here` surely belongs to and is surest of; None if there is none.

    What earlier answers promise most is asked first, and an answer stands if none that is still to
    be asked again promised more. Who was never asked comes before all.
    """
    rank = {
        other.members: max(float(evidence[i, j]) for i in here.members for j in other.members)
        for other in others
    }
    partners = sorted(others, key=lambda other: -rank[other.members])[:PARTNERS]
    best: Join | None = None
    sure: list[Join] = []
    waiting = sorted(partners, key=lambda other: -_promise(here, other, growth))
    for other in waiting:
        if best is not None and best.met.chance >= _promise(here, other, growth):
            break
        first, second = sorted((here, other), key=lambda union: -union.mesh.area)
        if (first.members, second.members) in growth.chances:
            continue  # asked as they are, and not joined
        join = _asked(first, second, meet, growth)
        growth.chances[first.members, second.members] = join.met.chance
        if join.met.chance >= SURE:
            growth.sure.append(join)
            sure.append(join)
            # who is asked later may dispute what was in nobody's place before
            undisputed = [each for each in sure if not _disputed(each, others, growth)]
            best = max(undisputed, key=_chance, default=None)
    return best


def _disputed(join: Join, others: Sequence[Union], growth: Growth) -> bool:
    """Whether another piece is laid on the same place about as surely, so one of both is wrong.

    Or both are right and overlap; then one of them is joined by way of something else.
    """
    rivals = [
        other
        for other in others
        if other.members != join.second.members and _promise(join.first, other, growth) >= SURE
    ]
    for rival in rivals:
        for before in _sure_before(join.first, rival, growth):
            if _odds(join) < DECIDED * _odds(before) and crowding(join, before) > CROWD:
                return True
    return False


def _chance(join: Join) -> float:
    return join.met.chance


def _odds(join: Join) -> float:
    return join.met.chance / (1.0 - join.met.chance)


def _asked(first: Union, second: Union, meet: Meet, growth: Growth) -> Join:
    """The answer of two unions, or that with what was sure before recalled, if that is surer."""
    join = Join(first, second, meet(first, second, NOTHING))
    before = next(iter(_sure_before(first, second, growth)), None)
    if before is None or join.met.chance >= SURE:
        return join
    known = recalled(before, first, second)
    if not len(known):
        return join
    again = Join(first, second, meet(first, second, known))
    return max(join, again, key=_chance)


def _promise(here: Union, other: Union, growth: Growth) -> float:
    """The chance when parts of both were asked last; above all if they never were."""
    own, its = set(here.members), set(other.members)
    found = UNASKED
    for (first, second), chance in growth.chances.items():
        if (own >= set(first) and its >= set(second)) or (own >= set(second) and its >= set(first)):
            found = chance
    return found


def _sure_before(first: Union, second: Union, growth: Growth) -> list[Join]:
    """What was sure of parts of both, the surest first; of the same piece what was said last."""
    own, its = set(first.members), set(second.members)
    found = {}
    for join in growth.sure:
        sides = (set(join.first.members), set(join.second.members))
        if (own >= sides[0] and its >= sides[1]) or (own >= sides[1] and its >= sides[0]):
            found[join.second.members] = join
    return sorted(found.values(), key=lambda join: -join.met.chance)
