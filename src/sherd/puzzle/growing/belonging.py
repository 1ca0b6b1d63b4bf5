"""Who belongs to the largest group, though where it lies there is not likely enough to be told.

That is easier to see than a place: a limb on the place of its missing twin, or slid along its own,
lies wrongly and belongs. What is of another kind fills no gap of the group, has not its skin, looks
like no part of it, nor does its mirror image, nothing that is said of its place is half likely, and
wherever it is laid its skin is not recognized.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.puzzle.growing.asking import Asking
from sherd.puzzle.growing.common_places import is_within
from sherd.puzzle.growing.kinship import KIN
from sherd.puzzle.growing.record import Growth, undisputed
from sherd.puzzle.growing.union import Join, Union
from sherd.puzzle.pairwise.answer import LIKELY, RECOGNIZED
from sherd.puzzle.pairwise.body import Body
from sherd.threads import one_blas_thread

__all__ = ["belonging", "chance_as_a_part", "with_kin"]

# Of what is larger than this share of a group it tells nothing that it looks like a part: wherever
# it belongs it shares much with the group, where its skin tells, or the group is far from a whole.
# Trunks of another animal look most like a part: a cow's with 0.44, 0.46 and 0.62 of the area of a
# wolf or a dog have 0.54, 0.45 and 0.69, and nothing is alike where they are asked. Of what belongs
# as a part the largest has 0.18. Half way by ratio.
PART = 0.28


def belonging(
    largest: Union, others: Sequence[Union], asking: Asking, growth: Growth
) -> list[Union]:
    """Those of the others that belong to the largest group.

    They have its skin, or fill a gap of it, or are small and more likely than not a part of it or
    of its twin; or a place on it, or on who belongs to it so, is half likely, or their skin is
    recognized there; or their mirror image fills a gap or is recognized. Of a single piece all that
    is missing is a gap, and it is no whole, so but for its skin it tells nothing.
    """
    if len(largest.members) == 1:
        return with_kin(largest, [], others, asking)
    found = _filling_a_gap(largest, others, growth)
    found = _with_akin(largest, found, others, growth)
    found = with_kin(largest, found, others, asking)
    # a match takes seconds, so who belongs already is not asked
    found += [
        other
        for other in others
        if other not in found
        and other.mesh.area < PART * largest.mesh.area
        and asking.as_a_part(largest, other) >= LIKELY
    ]
    found += [
        other
        for other in others
        if other not in found
        and len(other.members) == 1
        and _belongs_mirrored(Join(largest, other, asking.mirrored(largest, other)))
    ]
    return _with_akin(largest, found, others, growth)


def _with_akin(
    largest: Union, belonging: Sequence[Union], others: Sequence[Union], growth: Growth
) -> list[Union]:
    """Who belongs, and the pieces that may lie on the largest group or on them, in any place.

    Or whose skin is recognized there. But what lies within may as well be a part of another body of
    the same kind, and so may a group of its own that has no sure place there.
    """

    def is_akin(other: Union, body: Collection[int]) -> bool:
        return len(other.members) == 1 and (
            _is_half_likely(other, body, growth)
            or _recognized(other, body, growth) >= RECOGNIZED * largest.mesh.area
        )

    return _with_all(largest, belonging, others, is_akin)


def with_kin(
    group: Union, belonging: Sequence[Union], others: Sequence[Union], asking: Asking
) -> list[Union]:
    """Who belongs to a group, and who has its skin or theirs, wherever that is."""

    def is_kin(other: Union, body: Collection[int]) -> bool:
        return asking.kinship(other.members, body) >= KIN

    return _with_all(group, belonging, others, is_kin)


def _with_all(
    group: Union,
    belonging: Sequence[Union],
    others: Sequence[Union],
    belongs: Callable[[Union, Collection[int]], bool],
) -> list[Union]:
    """Who belongs to a group, and who then belongs to that or to one of them, until nobody does."""
    found = list(belonging)
    while True:
        body = [member for union in (group, *found) for member in union.members]
        more = [other for other in others if other not in found and belongs(other, body)]
        if not more:
            return found
        found += more


def _belongs_mirrored(image: Join) -> bool:
    """Whether the mirror image of a piece fills a gap of a group, or is recognized there.

    A tail, a head or a trunk is its own mirror image but for how it bends: what bends to the left
    where the group bends to the right lies there mirrored, and not as it is. A fox's tail so fills
    its gap and has 0.023 of the group recognized (0.006 as it is). Of 70 images of pieces of other
    species, on the two largest pieces of 35 puzzles, none fills a gap, and 0.0053 of the whole is
    the most that is recognized; but three are half likely, up to 0.79, so that is not asked.
    """
    return image.met.fills or image.met.recognized >= RECOGNIZED * image.first.mesh.area


def _is_half_likely(other: Union, body: Collection[int], growth: Growth) -> bool:
    return any(
        _is_about(each.members, body, other) and not is_within(each) for each in growth.half_likely
    )


def _recognized(other: Union, body: Collection[int], growth: Growth) -> float:
    """The most of its skin that is recognized on some of the members of a body."""
    found = (
        area
        for (first, second), area in growth.recognized.items()
        if _is_about((*first, *second), body, other)
    )
    return max(found, default=0.0)


def _is_about(sides: Collection[int], members: Collection[int], other: Union) -> bool:
    """Whether an answer is about a union and some of these members, which are not its own."""
    return set(other.members) < set(sides) <= {*members, *other.members}


def _filling_a_gap(largest: Union, others: Sequence[Union], growth: Growth) -> list[Union]:
    """Who fills a gap of the largest group by any answer to a question about parts of both.

    Unless that place was filled since, or two claim it.
    """
    claims = [
        (other, each)
        for other in others
        for each in growth.in_gaps
        if set(each.first.members) <= set(largest.members)
        and set(each.second.members) <= set(other.members)
        and not growth.made_there(each)
    ]
    claiming = {id(other) for other, _ in undisputed(claims)}
    return [other for other in others if id(other) in claiming]


@one_blas_thread()
def chance_as_a_part(body: Body, second: TriangleMesh) -> float:
    """The chance that a surface, or its mirror image, is matched rightly with a body as its whole.

    So it is seen by its twin, or by half of its own place if the other half is missing. Of groups
    of three pieces and more (two men, two cats, a horse) ten of 13 own ones that were left have
    0.62 and more, a cat's tail 0.19; 71 of other species 0.46 at most (a horse's leg on a man, the
    next 0.37), five of other animals of the same kind 0.29. What speaks against the place counts: a
    cow's trunk that is matched with a wolf by 0.54 is folded there.
    """
    asked = (body.matched(second), body.image_matched(second))
    return max((found.chance for found in asked if found is not None), default=0.0)
