"""Groups grown from the largest piece: the surest partner first, then the union is asked again.

Two small pieces share little with each other, and a left leg looks like a right one; with the union
of what is joined already a piece shares more, and its own place there looks more like it than
its twin's. So what was asked of a smaller union is asked again before it is believed. But a twin
that was joined may draw it away from its own place; what was sure before is then recalled.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cache

from sherd.arrays import Bools, Floats, Ints
from sherd.puzzle.growing.answer import JOINED, Meeting
from sherd.puzzle.growing.joined_maps import open_loop
from sherd.puzzle.growing.meeting import NOTHING_KNOWN
from sherd.puzzle.growing.union import (
    Join,
    Union,
    crowding,
    laid_alike,
    left_out,
    recalled,
    taken_by,
    united,
)

__all__ = ["Growth", "grown"]

# A union asks so many others, those that cheap evidence ranks first. So seven pieces ask all, and
# of a dozen that belong together each is asked two or three times.
PARTNERS = 8
# Above all chances: who was never asked is asked first.
UNASKED = 2.0
# One wrong in ten is as sure as a chance that is fitted can tell: with such an answer nobody who
# promised more is asked again first.
ENOUGH = 0.9
# Of two that are laid on more than half of one place one may be wrong, as two arms of a person, or
# they overlap there. Neither is joined unless its place is right with odds of three to one.
CROWD, DECIDED = 0.5, 3.0
# Two right pieces crowd each other so often, if they share a tenth with their neighbors: 6 of 95
# that share something with the largest of six (four animals and people, twelve puzzles); 17 of 116
# and 31 of 120 if a quarter and a half. That a wrong one crowds a right one is taken for certain.
OVERLAPPING = 0.06

# Around three that overlap in one place one comes back on average within what counts as a right
# answer, in units of the largest of the three. Then it is enough that the third answer is more
# likely right than not: a wrong one would have to be wrong in the same way as the other two.
LOOP, LIKELY = 0.06, 0.5

# The larger union, the other one, pairs (p, 2) of vertices that lie on each other, and the vertices
# (n,) of the larger one where the other does not lie, if there are any.
Meet = Callable[[Union, Union, Ints, Bools | None], Meeting]


@dataclass(eq=False)
class Growth:
    """What was asked and joined.

    Attributes
    ----------
    joins
        In the order in which they were made.
    sure
        What could have been joined, too.
    likely
        What was more likely right than not when it was asked.
    groups
        The members of each union at the end.
    chances
        By the members of both, the larger one first, of what was asked.
    aside
        What was asked of two because a third one has both, and of nobody else yet.
    together
        The members of two that lie on one place and on each other.
    settled
        What has a disputed place, and the members of who does not lie there.
    """

    joins: list[Join] = field(default_factory=list)
    sure: list[Join] = field(default_factory=list)
    likely: list[Join] = field(default_factory=list)
    groups: list[tuple[int, ...]] = field(default_factory=list)
    chances: dict[tuple[tuple[int, ...], tuple[int, ...]], float] = field(default_factory=dict)
    aside: dict[tuple[tuple[int, ...], tuple[int, ...]], Join] = field(default_factory=dict)
    together: list[set[tuple[int, ...]]] = field(default_factory=list)
    settled: list[tuple[Join, tuple[int, ...]]] = field(default_factory=list)


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

    What earlier answers promise most is asked first, and an answer stands if it is sure enough or
    none that is still to be asked again promised more. Who was never asked comes before all.
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
        promise = _promise(here, other, growth)
        enough = promise if promise == UNASKED else min(promise, ENOUGH)
        if best is not None and best.met.chance >= enough:
            break
        first, second = sorted((here, other), key=lambda union: -union.mesh.area)
        key = (first.members, second.members)
        if key in growth.chances and key not in growth.aside:
            continue  # asked as they are, and not joined
        join = growth.aside.pop(key, None) or _asked(first, second, meet, growth)
        growth.chances[key] = join.met.chance
        if join.met.chance >= JOINED:
            growth.sure.append(join)
            sure.append(join)
            # who is asked later may dispute what was in nobody's place before
            best = _best_undisputed(sure, others, growth)
            if best is None:
                _close_loops(join, others, meet, growth)
                best = _best_undisputed(sure, others, growth)
    if best is not None or not sure:
        return best
    return _elsewhere(sure, others, meet, growth)


def _best_undisputed(sure: Sequence[Join], others: Sequence[Union], growth: Growth) -> Join | None:
    undisputed = [join for join in sure if not _rivals(join, others, growth)]
    return max(undisputed, key=_chance, default=None)


def _rivals(join: Join, others: Sequence[Union], growth: Growth) -> list[Join]:
    """What is laid on the same place about as surely, and is not known to belong there as well."""
    return [
        before
        for other in others
        if other.members != join.second.members and _promise(join.first, other, growth) >= JOINED
        for before in _sure_before(join.first, other, growth)
        if _odds_beside(join, before) < DECIDED
        and crowding(join, before) > CROWD
        and {join.second.members, other.members} not in growth.together
    ]


def _close_loops(join: Join, others: Sequence[Union], meet: Meet, growth: Growth) -> None:
    """Note who is laid on the same place because the two overlap there.

    Then they belong to each other, too, and around the three one comes back to where one began.
    """
    for rival in _rivals(join, others, growth):
        if _loop_closes(join, rival, meet, growth):
            growth.together.append({join.second.members, rival.second.members})


def _loop_closes(one: Join, other: Join, meet: Meet, growth: Growth) -> bool:
    """Whether two that lie on a third also lie on each other, likely and in the same places."""
    first, second = sorted((one.second, other.second), key=lambda union: -union.mesh.area)
    key = (first.members, second.members)
    if key not in growth.chances:
        join = _asked(first, second, meet, growth)
        growth.chances[key] = join.met.chance
        growth.aside[key] = join
    aside = growth.aside.get(key)
    if aside is not None and aside.met.chance >= LIKELY and open_loop([one, other, aside]) < LOOP:
        return True
    # what both say of the third says where they lie on each other: is it the same skin there?
    pairs = laid_alike(one, other) if first is one.second else laid_alike(other, one)
    if not len(pairs):
        return False
    there = Join(first, second, meet(first, second, pairs, None))
    return there.met.by_skin >= LIKELY and open_loop([one, other, there]) < LOOP


def _elsewhere(
    sure: Sequence[Join], others: Sequence[Union], meet: Meet, growth: Growth
) -> Join | None:
    """The surest of those that dispute each other's places, once each was asked where else it lies.

    A left arm on the place of the right one, which lies there as well: who has the place, and who
    lies elsewhere, is decided for both together. To lie nowhere else surely is no evidence.
    """
    found: list[Join] = []

    @cache  # each pair is met from both sides
    def beside(here: Union, union: Union, other: Join) -> Join:
        return Join(here, union, meet(here, union, NOTHING_KNOWN, taken_by(other, here)))

    for join in sorted(sure, key=_chance, reverse=True):
        if join not in growth.sure:
            continue  # it lost its place
        rivals = _rivals(join, others, growth)
        moved = []
        for rival in rivals:
            own = beside(join.first, join.second, rival)
            its = beside(join.first, rival.second, join)
            stays, goes = (join, its), (rival, own)
            if _odds_of(stays) < DECIDED * _odds_of(goes):
                break
            moved.append(its)
        else:
            found.append(join)
            for rival, its in zip(rivals, moved, strict=True):
                growth.settled.append((join, rival.second.members))
                growth.chances[join.first.members, rival.second.members] = its.met.chance
                growth.sure.remove(rival)
                growth.likely = [each for each in growth.likely if each is not rival]
                growth.sure += [its] if its.met.chance >= JOINED else []
    return max(found, key=_chance, default=None)


def _odds_of(joins: tuple[Join, Join]) -> float:
    """Odds that one of two lies at a place and the other where it was asked then, or nowhere."""
    there, elsewhere = joins
    return _odds(there) * max(_odds(elsewhere), 1.0)


def _taken(first: Union, second: Union, growth: Growth) -> Bools | None:
    """The vertices (n,) of the first union that were settled to be others' places, if any."""
    taken = None
    for join, loser in growth.settled:
        inside = set(join.first.members) <= set(first.members)
        if inside and set(loser) <= set(second.members):
            place = taken_by(join, first)
            taken = place if taken is None else taken | place
    return taken


def _chance(join: Join) -> float:
    return join.met.chance


def _odds(join: Join) -> float:
    return join.met.chance / (1.0 - join.met.chance)


def _odds_beside(join: Join, rival: Join) -> float:
    """Odds that a place is right which a rival claims as well, rightly or not.

        P(right) : P(wrong) = (OVERLAPPING o o' + o) : (o' + 1),     o, o': odds of both

    Both right, it alone; the rival alone, neither. So where both are beyond doubt they overlap.
    """
    own, its = _odds(join), _odds(rival)
    return own * (1.0 + OVERLAPPING * its) / (1.0 + its)


def _asked(first: Union, second: Union, meet: Meet, growth: Growth) -> Join:
    """The answer of two unions; what is likely is kept in mind."""
    join = _answered(first, second, meet, growth)
    if join.met.chance >= LIKELY:
        growth.likely.append(join)
    return join


def _answered(first: Union, second: Union, meet: Meet, growth: Growth) -> Join:
    """The answer of two unions; if it is not sure, that elsewhere or with what was sure recalled.

    What is laid on its twin has another place, so it is asked where else it lies. If it surely does
    it is kept from its twin's place from then on; a right place may look like a twin's, too. What
    lies where it surely lay before is likely to, see `_confirmed`; what is sure must not contradict
    what was likely, see `_uncontradicted`, and what is not is asked where that was, too.
    """
    taken = _taken(first, second, growth)
    join = Join(first, second, meet(first, second, NOTHING_KNOWN, taken))
    if join.met.twin:
        place = taken_by(join, first)
        place = place if taken is None else taken | place
        elsewhere = Join(first, second, meet(first, second, NOTHING_KNOWN, place))
        if elsewhere.met.chance >= JOINED:
            growth.settled.append((join, second.members))
            growth.sure = [each for each in growth.sure if not _repeated(each, join)]
            growth.likely = [each for each in growth.likely if not _repeated(each, join)]
            taken = place
        join = max(join, elsewhere, key=_chance)
    contradicting = _contradicting(join, growth)
    if join.met.chance >= JOINED:
        return _uncontradicted(join, contradicting, taken, meet)
    before = next(iter([*_sure_before(first, second, growth), *contradicting]), None)
    if before is None:
        return join
    known = recalled(before, first, second)
    if len(known):
        again = Join(first, second, meet(first, second, known, taken))
        join = max(join, again, key=_chance)
    return _confirmed(join, before)


def _contradicting(join: Join, growth: Growth) -> list[Join]:
    """What parts of both likely share and an answer leaves out, the likeliest first.

    Larger unions have what their parts have, so they share it, too.
    """
    found = [
        before
        for before in growth.likely
        if _of_parts(before, join) and left_out(before, join) > CROWD
    ]
    return sorted(found, key=_chance, reverse=True)


def _uncontradicted(
    join: Join, contradicting: Sequence[Join], taken: Bools | None, meet: Meet
) -> Join:
    """A sure answer, or what is likelier, where earlier ones contradict it.

    They are at another place, and one of both is right, or none (a conditional logit, as of the
    places of one question). The earlier place is asked again with what was said of it.
    """
    if not contradicting:
        return join
    before = contradicting[0]
    known = recalled(before, join.first, join.second)
    rival, there = before, None
    if len(known):
        there = Join(join.first, join.second, meet(join.first, join.second, known, taken))
        rival = max(before, there, key=_chance)
    if there is not None and _odds(there) > _odds(join):
        return _against(there, join)
    return _against(join, rival)


def _against(join: Join, rival: Join) -> Join:
    """An answer that another one contradicts: of both places one is right, or none."""
    odds = _odds(join) / (1.0 + _odds(rival))
    return replace(join, met=replace(join.met, chance=odds / (1.0 + odds)))


def _of_parts(before: Join, join: Join) -> bool:
    """Whether an earlier question was about parts of both sides of a later one."""
    own, its = set(join.first.members), set(join.second.members)
    first, second = set(before.first.members), set(before.second.members)
    return (own >= first and its >= second) or (own >= second and its >= first)


def _confirmed(join: Join, before: Join) -> Join:
    """An answer that is likely, and as sure as it and an earlier one at the same place are in mean.

    A union has all that the earlier piece of it had there, so both see much of the same; what two
    strangers said apart would count as the sum of their log odds, and not as the mean.
    """
    if not LIKELY <= join.met.chance < JOINED or not _repeated(before, join):
        return join
    odds = math.sqrt(_odds(before) * _odds(join))
    return replace(join, met=replace(join.met, chance=odds / (1.0 + odds)))


def _repeated(before: Join, join: Join) -> bool:
    """Whether the same piece was laid on the same place before."""
    return before.second.members == join.second.members and crowding(before, join) > CROWD


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
