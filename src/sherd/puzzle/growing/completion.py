"""What is likely when nothing is sure any more: the last limbs, each of which is seen at its joint.

While groups grow only what is sure is joined, since a wrong piece draws others after it. At the end
nothing follows, so what is more likely right than not belongs, unless something contradicts it.
What fills a gap of the group needs less to be likely. And then who is still alone is asked whether
the largest group has its twin.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from sherd.correspondence.confidence import LEAST
from sherd.puzzle.growing.asking import Asking
from sherd.puzzle.growing.common_places import is_within, left_out, lying_in, recalled
from sherd.puzzle.growing.members import laid_as_before
from sherd.puzzle.growing.record import (
    CROWD,
    CROWDED_AT_LAST,
    Growth,
    chance_at,
    chance_of,
    odds_beside,
    undisputed,
)
from sherd.puzzle.growing.union import Join, Union, larger_first, main_group_first, united
from sherd.puzzle.pairwise.answer import JOINED, LIKELY
from sherd.puzzle.pairwise.join_chance import fills_a_gap

__all__ = ["with_likely", "with_twins"]


def with_likely(groups: Sequence[Union], asking: Asking, growth: Growth) -> list[Union]:
    """Groups, joined where that was found likely, then where one fills a gap of another."""
    return _with_filled(_with_found(groups, asking, growth), asking, growth)


def _with_found(groups: Sequence[Union], asking: Asking, growth: Growth) -> list[Union]:
    """Groups, joined where that was found likely and is not contradicted; the likeliest first.

    Of what was likely of parts the whole may see less, as the more of a union is carried along the
    less it looks like itself. So it is as sure as it was, if the groups lie there as well when they
    are asked with what was said.

    While groups grow the skin alone is not believed where few places lead, as of other people few
    do. That refuses right answers as well, and of 300 at last no wrong one more
    (docs/method/without-a-whole.md).
    """
    growth.likely += growth.by_skin
    growth.by_skin = []
    # what fills a gap counts among the likely since an earlier round
    found = [each for each in growth.likely if each not in growth.filling]
    return _with_what_lies(found, _of_groups, groups, asking, growth)


def _with_filled(groups: Sequence[Union], asking: Asking, growth: Growth) -> list[Union]:
    """Groups, joined where one fills a gap of another one; the likeliest first.

    While others are missing a gap has no border yet, so that is asked of the groups at last.
    """
    growth.likely += [each for each in growth.filling if each not in growth.likely]
    return _with_what_lies(growth.filling, _in_a_gap, groups, asking, growth)


def _with_what_lies(
    answers: Sequence[Join],
    lying: Callable[[Join, Union, Union, Asking, Growth], Join | None],
    groups: Sequence[Union],
    asking: Asking,
    growth: Growth,
) -> list[Union]:
    """Groups, joined where earlier answers lie there as well, by `lying`; the likeliest first."""
    found = list(groups)
    for before in sorted(answers, key=chance_of, reverse=True):
        first, second = larger_first(_with(found, before.first), _with(found, before.second))
        # what is cheap to know is looked at before groups are asked again
        if first is second or is_within(before):
            continue
        join = lying(before, first, second, asking, growth)
        if join is None or is_within(join) or _contradicted(join, before, found, growth):
            continue
        found = _joined(found, join, growth)
    return found


def with_twins(groups: Sequence[Union], asking: Asking, growth: Growth) -> list[Union]:
    """Groups, joined where one lies across from its twin in the largest; the likeliest first.

    Who was joined may have the place of who comes later, or its twin, so these are asked again. Two
    that claim one place contradict each other. A single piece has seldom both sides of a body, and
    is not asked; nobody is asked twice.
    """
    found = list(groups)
    while True:
        largest, *others = main_group_first(found)
        if len(largest.members) == 1:
            return found
        others = [
            other for other in others if (largest.members, other.members) not in growth.asked_across
        ]
        growth.asked_across |= {(largest.members, other.members) for other in others}
        answers = [(other, asking.across(largest, other)) for other in others]
        claims = [
            (other, Join(largest, other, met))
            for other, met in answers
            if met is not None and met.chance >= LIKELY
        ]
        joins = [join for _, join in undisputed(claims)]
        if not joins:
            return found
        best = max(joins, key=chance_of)
        growth.across.append(best)
        found = _joined(found, best, growth)


def _joined(groups: Sequence[Union], join: Join, growth: Growth) -> list[Union]:
    growth.joins.append(join)
    growth.last.append(join)
    growth.chances[join.first.members, join.second.members] = join.met.chance
    return [*_others(groups, join), united(join)]


def _others(groups: Sequence[Union], join: Join) -> list[Union]:
    """All groups but the two of a join, in whatever pose these are."""
    return [each for each in groups if set(join.members).isdisjoint(each.members)]


def _with(groups: Sequence[Union], part: Union) -> Union:
    return next(each for each in groups if set(each.members) >= set(part.members))


def _of_groups(
    before: Join, first: Union, second: Union, asking: Asking, growth: Growth
) -> Join | None:
    """What was said of parts, of the groups that have them; None if these do not lie there.

    If groups do not find it again they may be laid there, where that fills a gap.
    """
    before = before.with_chance(_chance_beside(before, growth))
    if before.met.chance < LIKELY:
        return None
    if _of_these(before, first, second):
        return before
    known = recalled(before, first, second)
    if len(known):
        met = asking.meet(first, second, known, growth.taken(first, second))
        join = Join(first, second, replace(met, chance=max(met.chance, before.met.chance)))
        if left_out(before, join) <= CROWD:
            return join
    return _in_a_gap(before, first, second, asking, growth)


def _in_a_gap(
    before: Join, first: Union, second: Union, asking: Asking, growth: Growth
) -> Join | None:
    """Groups laid as parts of them were; None if that fills no gap."""
    join = (
        before
        if _of_these(before, first, second)
        else laid_as_before(before, first, second, asking, growth)
    )
    if join is None or join.met.chance < LIKELY:
        return None
    return join if _fills_a_gap(join) else None


def _of_these(join: Join, first: Union, second: Union) -> bool:
    """Whether a join of parts of two unions, one of each, is of all of both, in whatever pose."""
    return set(join.members) == {*first.members, *second.members}


def _fills_a_gap(join: Join) -> bool:
    """Whether each goes on all around where the other one ends."""
    return fills_a_gap(join.met.questions, join.met.placements)


def _chance_beside(before: Join, growth: Growth) -> float:
    """The chance of an earlier answer if what was joined lies in that place.

    Pieces overlap, so two may have one place rightly: as likely as that follows from both of what
    was sure; what was only likely does not tell.
    """
    rivals = growth.made_there(before)
    if not rivals:
        return before.met.chance
    if before.met.chance < JOINED:
        return LEAST
    odds = odds_beside(before, max(rivals, key=chance_of), CROWDED_AT_LAST)
    return chance_at(odds)


def _contradicted(join: Join, before: Join, groups: Sequence[Union], growth: Growth) -> bool:
    """Whether the two were likely to lie elsewhere, or another one to lie in that place."""
    if any(
        each is not before and left_out(each, join) > CROWD
        for each in growth.likely_before(join.first, join.second)
    ):
        return True
    return any(
        lying_in(join, each) > CROWD
        for other in _others(groups, join)
        if not growth.are_together(join.second, other)
        for each in growth.likely_before(join.first, other)
    )
