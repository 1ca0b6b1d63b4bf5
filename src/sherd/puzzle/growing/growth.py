"""Groups grown from the largest piece: the surest partner first, then the union is asked again.

Two small pieces share little with each other, and a left leg looks like a right one; with the union
of what is joined already a piece shares more, and its own place there looks more like it than
its twin's. So what was asked of a smaller union is asked again before it is believed. But a twin
that was joined may draw it away from its own place; what was sure before is then recalled. When
nothing is sure any more, what is likely completes the groups, and these are asked once more.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

from sherd.arrays import Floats
from sherd.puzzle.growing.asking import Asking, Meet, asked, share_enough, unless_strangers
from sherd.puzzle.growing.belonging import belonging, with_kin
from sherd.puzzle.growing.common_places import crowding, laid_alike, taken_by
from sherd.puzzle.growing.completion import with_likely, with_twins
from sherd.puzzle.growing.joined_maps import open_loop
from sherd.puzzle.growing.members import ask_members, told_by_members
from sherd.puzzle.growing.poses import ask_in_poses
from sherd.puzzle.growing.record import (
    CROWD,
    CROWDED,
    UNASKED,
    Growth,
    chance_of,
    laid_there,
    odds_beside,
    odds_of,
)
from sherd.puzzle.growing.union import (
    Join,
    Union,
    larger_first,
    largest_first,
    main_group_first,
    united,
)
from sherd.puzzle.pairwise.answer import JOINED, LIKELY
from sherd.puzzle.pairwise.meeting import NOTHING_KNOWN

__all__ = ["grow"]

# A union asks so many others, those that cheap evidence ranks first. So seven pieces ask all, and
# of a dozen that belong together each is asked two or three times.
PARTNERS = 8
# One wrong in ten is as sure as a chance that is fitted can tell: with such an answer nobody who
# promised more is asked again first.
ENOUGH = 0.9
# Of two that are laid on one place one may be wrong, as two arms of a person, or they overlap
# there. Neither is joined unless its place is right with odds of three to one.
DECIDED = 3.0

# Around three that overlap in one place one comes back on average within what counts as a right
# answer, in units of the largest of the three. Then it is enough that the third answer is more
# likely right than not: a wrong one would have to be wrong in the same way as the other two.
LOOP = 0.06


def grow(growth: Growth, evidence: Floats, asking: Asking) -> None:
    """Join what belongs together.

    Parameters
    ----------
    growth
        Begun, of single pieces. All that is asked and joined is noted.
    evidence
        (k, k) symmetric, by their numbers, how much speaks for asking two pieces.
    asking
        How two of them, or two unions, are asked.
    """
    found = _with_sure([*growth.pieces.values()], evidence, asking, growth)
    if not growth.joins:
        growth.root = growth.largest
    while True:
        count = len(growth.joins)
        found = with_likely(found, asking, growth)
        if len(growth.joins) == count:
            found = with_twins(found, asking, growth)
        if len(growth.joins) == count and ask_in_poses(found, evidence, asking, growth):
            found = with_likely(found, asking, growth)
        if len(growth.joins) == count:
            break
        found = _with_what_follows(found, evidence, asking, growth)
    _name_groups(found, asking, growth)


def _name_groups(found: Sequence[Union], asking: Asking, growth: Growth) -> None:
    """The members of all groups; who belongs to one, wherever it lies, is named there.

    That is told of the largest one in all ways, and of others by their skin.
    """
    here, *left = main_group_first(found)
    belong = belonging(here, left, asking, growth)
    while True:
        more = [member for union in belong for member in union.members]
        growth.groups.append((*here.members, *more))
        growth.unplaced += more
        left = largest_first([union for union in left if union not in belong])
        if not left:
            return
        here, *left = left
        belong = with_kin(here, [], left, asking)


def _with_what_follows(
    groups: Sequence[Union], evidence: Floats, asking: Asking, growth: Growth
) -> list[Union]:
    """Groups of which something is only likely, joined where that is sure then.

    A last limb may share its joint with another last one. No surer than what it follows from.
    """
    count, least = len(growth.joins), min(map(chance_of, growth.last))
    found = _with_sure(groups, evidence, asking, growth)
    growth.last += [join.with_chance(min(join.met.chance, least)) for join in growth.joins[count:]]
    return found


def _with_sure(
    groups: Sequence[Union], evidence: Floats, asking: Asking, growth: Growth
) -> list[Union]:
    """Groups, joined where that is sure; the largest one grows first."""
    growing = list(groups)
    done: list[Union] = []
    while growing:
        here, *growing = largest_first(growing)
        if not growth.joins:
            growth.root = here
        others = [*growing, *done]
        # what members said already is sure, so the union need not be asked
        partner = _by_members(here, others, evidence, asking, growth)
        if partner is None:
            ask = _surest if growth.has_root(here.members) else _surest_of_stranger
            partner = ask(here, others, evidence, asking.meet, growth)
        if partner is None:
            _ask_members(here, others, evidence, asking, growth)
            partner = _by_members(here, others, evidence, asking, growth)
        if partner is None:
            done.append(here)
            continue
        for union in {*partner.both} - {here}:
            (growing if union in growing else done).remove(union)
        growth.joins.append(partner)
        growing.append(united(partner))
    return done


def _surest(
    here: Union, others: Sequence[Union], evidence: Floats, meet: Meet, growth: Growth
) -> Join | None:
    """The partner that `here` surely belongs to and is surest of; None if there is none.

    What earlier answers promise most is asked first, and an answer stands if it is sure enough or
    none that is still to be asked again promised more. Who was never asked comes before all.
    """
    best: Join | None = None
    sure: list[Join] = []
    partners = _ranked(here, others, evidence)
    waiting = sorted(partners, key=lambda other: -growth.promise(here, other))
    for other in waiting:
        promise = growth.promise(here, other)
        enough = promise if promise == UNASKED else min(promise, ENOUGH)
        if best is not None and best.met.chance >= enough:
            break
        first, second = larger_first(here, other)
        key = (first.members, second.members)
        if key in growth.chances and key not in growth.aside:
            continue  # asked as they are, and not joined
        join = growth.aside.pop(key, None) or asked(first, second, meet, growth)
        join = unless_strangers(join, growth)
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


def _surest_of_stranger(
    here: Union, others: Sequence[Union], evidence: Floats, meet: Meet, growth: Growth
) -> Join | None:
    """The surest partner of what has no root yet.

    If it surely shares enough with somebody a group grows from it, and it is believed of all. If
    not it stays a stranger, and what it said of others that it shares too little with is forgotten.
    """
    growth.roots.add(here.members[0])
    partner = _surest(here, others, evidence, meet, growth)
    said = growth.said_to_strangers(here)
    little = [join for join in said if not share_enough(join, growth)]
    if partner is not None and any(join in growth.sure for join in said if join not in little):
        return partner
    growth.roots.remove(here.members[0])
    for join in little:
        growth.disbelieve(join)
    if partner is None or partner in growth.sure:
        return partner
    asked_now = {here, *others}
    left = [join for join in growth.sure if here in join.both and asked_now.issuperset(join.both)]
    return _best_undisputed(left, others, growth)


def _by_members(
    here: Union, others: Sequence[Union], evidence: Floats, asking: Asking, growth: Growth
) -> Join | None:
    """The surest of those that members of `here` surely share something with in their own poses."""
    sure: list[Join] = []
    for other in _ranked(here, others, evidence):
        first, second = larger_first(here, other)
        join = told_by_members(first, second, asking, growth)
        if join is not None:
            growth.chances[first.members, second.members] = join.met.chance
            growth.sure.append(join)
            sure.append(join)
    return _best_undisputed(sure, others, growth)


def _ask_members(
    here: Union, others: Sequence[Union], evidence: Floats, asking: Asking, growth: Growth
) -> None:
    for other in _ranked(here, others, evidence):
        first, second = larger_first(here, other)
        ask_members(first, second, evidence, asking, growth)


def _ranked(here: Union, others: Sequence[Union], evidence: Floats) -> list[Union]:
    """Those of which cheap evidence says most, as far as they are asked."""

    def rank(other: Union) -> float:
        return max(float(evidence[i, j]) for i in here.members for j in other.members)

    return sorted(others, key=rank, reverse=True)[:PARTNERS]


def _best_undisputed(sure: Sequence[Join], others: Sequence[Union], growth: Growth) -> Join | None:
    undisputed = [join for join in sure if not _rivals(join, others, growth)]
    return max(undisputed, key=chance_of, default=None)


def _rivals(join: Join, others: Sequence[Union], growth: Growth) -> list[Join]:
    """What is laid on the same place about as surely, and is not known to belong there as well."""
    return [
        before
        for other in others
        if other.members not in (join.first.members, join.second.members)
        and growth.promise(join.first, other) >= JOINED
        for before in growth.sure_before(join.first, other)
        if odds_beside(join, before, CROWDED) < DECIDED
        and crowding(join, before) > CROWD
        and not growth.are_together(join.second, other)
    ]


def _close_loops(join: Join, others: Sequence[Union], meet: Meet, growth: Growth) -> None:
    """Note who is laid on the same place because the two overlap there.

    Then they belong to each other, too, and around the three one comes back to where one began.
    """
    for rival in _rivals(join, others, growth):
        if _loop_closes(join, rival, meet, growth):
            growth.together.append((join.second.members, rival.second.members))


def _loop_closes(one: Join, other: Join, meet: Meet, growth: Growth) -> bool:
    """Whether two that lie on a third also lie on each other, likely and in the same places."""
    first, second = larger_first(one.second, other.second)
    key = (first.members, second.members)
    if key not in growth.chances:
        join = asked(first, second, meet, growth)
        growth.chances[key] = join.met.chance
        growth.aside[key] = join
    aside = growth.aside.get(key)
    if aside is not None and aside.met.chance >= LIKELY and open_loop([one, other, aside]) < LOOP:
        return True
    # what both say of the third says where they lie on each other: is it the same skin there?
    pairs = laid_alike(one, other) if first is one.second else laid_alike(other, one)
    if len(pairs):
        there = Join(first, second, meet(first, second, pairs, None))
        if there.met.by_skin >= LIKELY and open_loop([one, other, there]) < LOOP:
            return True
    if aside is not None:
        unless_strangers(aside, growth)  # what nothing confirms is forgotten
    return False


def _elsewhere(
    sure: Sequence[Join], others: Sequence[Union], meet: Meet, growth: Growth
) -> Join | None:
    """The surest of those that dispute each other's places, once each was asked where else it lies.

    A left arm on the place of the right one, which lies there as well: who has the place, and who
    lies elsewhere, is decided for both together. To lie nowhere else surely is no evidence. Who
    likely lies where it did, by labels outside the place of the other, overlaps it there.
    """
    found: list[Join] = []

    @cache  # each pair is met from both sides
    def beside(here: Union, union: Union, other: Join) -> Join:
        return Join(here, union, meet(here, union, NOTHING_KNOWN, taken_by(other, here)))

    for join in sorted(sure, key=chance_of, reverse=True):
        if join not in growth.sure:
            continue  # it lost its place
        moved: list[tuple[Join, Join]] = []
        for rival in _rivals(join, others, growth):
            # each of both is a question of a minute, so the second is asked if it is needed
            if _still_there(own := beside(join.first, join.second, rival), join) or _still_there(
                its := beside(join.first, rival.second, join), rival
            ):
                growth.together.append((join.second.members, rival.second.members))
            elif _odds_of((join, its)) < DECIDED * _odds_of((rival, own)):
                break
            else:
                moved.append((rival, its))
        else:
            found.append(join)
            for rival, its in moved:
                growth.settle(join, rival.second.members)
                growth.chances[join.first.members, rival.second.members] = its.met.chance
                growth.sure += [its] if its.met.chance >= JOINED else []
    return max(found, key=chance_of, default=None)


def _still_there(again: Join, before: Join) -> bool:
    """Whether what was asked elsewhere likely lies where it did."""
    return again.met.chance >= LIKELY and laid_there(before, again, again.second.members)


def _odds_of(joins: tuple[Join, Join]) -> float:
    """Odds that one of two lies at a place and the other where it was asked then, or nowhere."""
    there, elsewhere = joins
    return odds_of(there) * max(odds_of(elsewhere), 1.0)
