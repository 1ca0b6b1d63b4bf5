"""What is likely when nothing is sure any more: the last limbs, each of which is seen at its joint.

While groups grow only what is sure is joined, since a wrong piece draws others after it. At the end
nothing follows, so what is more likely right than not belongs, unless something contradicts it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from sherd.puzzle.growing.asking import Meet
from sherd.puzzle.growing.common_places import crowding, left_out, recalled
from sherd.puzzle.growing.join_chance import lies_within
from sherd.puzzle.growing.record import CROWD, Growth, chance_of
from sherd.puzzle.growing.union import Join, Union, united

__all__ = ["completed"]


def completed(groups: Sequence[Union], meet: Meet, growth: Growth) -> list[Union]:
    """Groups, joined where that was found likely and is not contradicted; the likeliest first.

    Of what was likely of parts the whole may see less, as the more of a union is carried along the
    less it looks like itself. So it is as sure as it was, if the groups lie there as well when they
    are asked with what was said.
    """
    found = list(groups)
    for before in sorted(growth.likely, key=chance_of, reverse=True):
        first, second = sorted(
            (_with(found, side) for side in (before.first, before.second)),
            key=lambda union: -union.mesh.area,
        )
        # what is cheap to know is looked at before groups are asked again
        if first is second or _lies_within(before) or _has_another(before, growth):
            continue
        join = _of_groups(before, first, second, meet, growth)
        if join is None or _lies_within(join) or _contradicted(join, before, found, growth):
            continue
        found = [each for each in found if each is not first and each is not second]
        found.append(united(join))
        growth.joins.append(join)
        growth.last.append(join)
    return found


def _with(groups: Sequence[Union], part: Union) -> Union:
    return next(each for each in groups if set(each.members) >= set(part.members))


def _of_groups(
    before: Join, first: Union, second: Union, meet: Meet, growth: Growth
) -> Join | None:
    """What was said of parts, of the groups that have them; None if these do not lie there."""
    if {before.first, before.second} == {first, second}:
        return before
    known = recalled(before, first, second)
    if not len(known):
        return None
    met = meet(first, second, known, growth.taken(first, second))
    join = Join(first, second, replace(met, chance=max(met.chance, before.met.chance)))
    return join if left_out(before, join) <= CROWD else None


def _lies_within(join: Join) -> bool:
    """Whether one lies within the other, which adds nothing and has no border there to tell by."""
    return lies_within(join.met.questions, join.met.placements)


def _has_another(before: Join, growth: Growth) -> bool:
    """Whether what was joined lies in that place.

    Pieces overlap, so two may have one place rightly; but what is only likely does not tell.
    """
    return any(crowding(before, made) > CROWD for made in growth.joins)


def _contradicted(join: Join, before: Join, groups: Sequence[Union], growth: Growth) -> bool:
    """Whether the two were likely to lie elsewhere, or another one to lie in that place."""
    if any(
        each is not before and left_out(each, join) > CROWD
        for each in growth.likely_before(join.first, join.second)
    ):
        return True
    return any(
        crowding(join, each) > CROWD
        for other in groups
        if other is not join.first
        and other is not join.second
        and {join.second.members, other.members} not in growth.together
        for each in growth.likely_before(join.first, other)
    )
