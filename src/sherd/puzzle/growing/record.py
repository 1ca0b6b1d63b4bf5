"""What was asked and joined while groups grew, and what earlier answers say of a later question."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from sherd.arrays import Bools
from sherd.correspondence.confidence import LEAST
from sherd.puzzle.growing.common_places import crowding, lying_in, taken_by
from sherd.puzzle.growing.union import Join, Union, largest_first
from sherd.puzzle.pairwise.answer import HALF_LIKELY, Ground, chance_to_belong, ground_of

__all__ = [
    "CROWD",
    "CROWDED",
    "CROWDED_AT_LAST",
    "UNASKED",
    "Growth",
    "chance_at",
    "chance_of",
    "laid_there",
    "odds_beside",
    "odds_of",
    "undisputed",
]

# Above all chances: who was never asked is asked first.
UNASKED = 2.0
# Two that are laid on more than half of one place are in each other's way, or lie there both; what
# lies on less than half of a place is elsewhere.
CROWD = 0.5
# Two right pieces crowd each other so often, if they share a tenth with their neighbors: 6 of 95
# that share something with the largest of six (four animals and people, twelve puzzles); 17 of 116
# and 31 of 120 if a quarter and a half. That a wrong one crowds a right one is taken for certain.
# While groups grow the first counts, as a wrong one draws others after it. At last the third does:
# what was joined by then overlaps by about a half.
CROWDED, CROWDED_AT_LAST = 0.06, 0.26

# What belongs together overlaps, so pieces have more area than their whole: half as much again, if
# each reaches half as far again. Right answers of a horse and a cat whose pieces have a third of
# the whole each have chances of 0.97 to 0.99 in units of the whole, in units of 0.8 of it 0.94 to
# 0.99, of 1.3 as many, but for what shares little, which is not found.
COVERED = 1.5
# And where pieces of several wholes are asked together, none of which is known, one is thought to
# have no more than so much of the area of its largest piece.
MOST_OF_LARGEST = 3.0


@dataclass(eq=False)
class Growth:
    """What was asked and joined.

    Attributes
    ----------
    pieces
        By their numbers, as they are.
    root
        The piece from which the first group grows: the largest, or the next one if that was asked
        and surely belongs to nobody. A piece of a horse may be larger than a wolf.
    roots
        By their numbers, the largest piece and those from which groups grow.
    joins
        In the order in which they were made.
    last
        The last of them, made when nothing was sure any more.
    across
        The last of these, of what lies across from its twin.
    asked_across
        The members of both, of those that were asked whether they do.
    sure
        What could have been joined, too.
    likely
        What was more likely right than not when it was asked.
    by_skin
        What was, by the skin that is shared alone, with that chance.
    filling
        What is by the skin alone if it fills a gap of what is joined at last, with that chance.
    half_likely
        What was half likely at least to belong, see `chance_to_belong`.
    recognized
        By the members of both, what of the area that they share is recognized; see `Meeting`.
    in_gaps
        What fills a gap of one of two unions, however likely it lies there, in the order asked.
    groups
        The members of each union at the end, and of what belongs to it wherever it lies.
    unplaced
        The members of those that belong so.
    chances
        By the members of both, the larger one first, of what was asked.
    of_members
        The same of members that were asked as they are when their unions found nothing.
    sure_of_members
        What was sure of these.
    posed
        A member of the largest group, and the members of who was asked of that in its pose.
    poses
        By the members of who was, the number of poses that differ, and the group's own.
    told
        By the members of two unions, what of this told them where they lie on each other.
    aside
        What was asked of two because a third one has both, and of nobody else yet.
    together
        The members of two that lie on one place and on each other.
    settled
        What has a disputed place, and the members of who does not lie there.
    """

    pieces: Mapping[int, Union]
    root: Union
    roots: set[int]
    joins: list[Join] = field(default_factory=list)
    last: list[Join] = field(default_factory=list)
    across: list[Join] = field(default_factory=list)
    asked_across: set[tuple[tuple[int, ...], tuple[int, ...]]] = field(default_factory=set)
    sure: list[Join] = field(default_factory=list)
    likely: list[Join] = field(default_factory=list)
    by_skin: list[Join] = field(default_factory=list)
    filling: list[Join] = field(default_factory=list)
    half_likely: list[Join] = field(default_factory=list)
    recognized: dict[tuple[tuple[int, ...], tuple[int, ...]], float] = field(default_factory=dict)
    in_gaps: list[Join] = field(default_factory=list)
    groups: list[tuple[int, ...]] = field(default_factory=list)
    unplaced: list[int] = field(default_factory=list)
    chances: dict[tuple[tuple[int, ...], tuple[int, ...]], float] = field(default_factory=dict)
    of_members: dict[tuple[tuple[int, ...], tuple[int, ...]], float] = field(default_factory=dict)
    sure_of_members: list[Join] = field(default_factory=list)
    posed: set[tuple[int, tuple[int, ...]]] = field(default_factory=set)
    poses: dict[tuple[int, ...], int] = field(default_factory=dict)
    told: dict[tuple[tuple[int, ...], tuple[int, ...]], Join] = field(default_factory=dict)
    aside: dict[tuple[tuple[int, ...], tuple[int, ...]], Join] = field(default_factory=dict)
    together: list[tuple[tuple[int, ...], tuple[int, ...]]] = field(default_factory=list)
    settled: list[tuple[Join, tuple[int, ...]]] = field(default_factory=list)

    @classmethod
    def begun(cls, pieces: Sequence[Union]) -> Growth:
        """Before anything is asked."""
        largest = largest_first(pieces)[0]
        return cls({each.members[0]: each for each in pieces}, largest, {*largest.members})

    @property
    def largest(self) -> Union:
        """The largest piece."""
        return largest_first([*self.pieces.values()])[0]

    @property
    def length_of_whole(self) -> float:
        """What sqrt(area) of the whole of the first group may be.

        Of that nothing is known but its pieces, and what is larger than its root is none of them.
        """
        largest = self.root.mesh.area
        areas = [each.mesh.area for each in self.pieces.values() if each.mesh.area <= largest]
        return math.sqrt(np.clip(sum(areas) / COVERED, largest, MOST_OF_LARGEST * largest))

    def promise(self, here: Union, other: Union) -> float:
        """The chance when parts of both were asked last; above all if they never were."""
        found = UNASKED
        for (first, second), chance in self.chances.items():
            if _are_parts((first, second), (here, other)):
                found = chance
        return found

    def sure_before(self, first: Union, second: Union) -> list[Join]:
        """What was sure of parts of both, the surest first; of one piece what was said last."""
        found = {}
        for join in self.sure:
            if _are_parts(_members(join), (first, second)):
                found[join.second.members] = join
        return sorted(found.values(), key=chance_of, reverse=True)

    def likely_before(self, first: Union, second: Union) -> list[Join]:
        """What was likely of parts of both, the likeliest first."""
        found = [each for each in self.likely if _are_parts(_members(each), (first, second))]
        return sorted(found, key=chance_of, reverse=True)

    def made_there(self, join: Join) -> list[Join]:
        """What was joined in the place of an answer, or in most of it."""
        return [made for made in self.joins if lying_in(join, made) > CROWD]

    def taken(self, first: Union, second: Union) -> Bools | None:
        """The vertices (n,) of the first union that were settled to be others' places, if any."""
        taken = None
        for join, loser in self.settled:
            inside = set(join.first.members) <= set(first.members)
            if inside and set(loser) <= set(second.members):
                place = taken_by(join, first)
                taken = place if taken is None else taken | place
        return taken

    def are_together(self, one: Union, other: Union) -> bool:
        """Whether parts of both are known to lie on one place and on each other."""
        return any(_are_parts(members, (one, other)) for members in self.together)

    def keep_in_mind(self, join: Join) -> None:
        """Note what is likely, by its ground; it may be joined when nothing is sure any more.

        And what is half likely, by which somebody may belong.
        """
        if chance_to_belong(join.met) >= HALF_LIKELY:
            self.half_likely.append(join)
        ground, chance = ground_of(join.met)
        if ground == Ground.ALL:
            self.likely.append(join)
        elif ground == Ground.SKIN:
            self.by_skin.append(join.with_chance(chance))
        elif ground == Ground.GAP:
            self.filling.append(join.with_chance(chance))

    def last_chances(self) -> dict[int, float]:
        """By piece, of what was joined last, the chance of its place.

        Where what was joined so is in a group that was joined so later, that of the less likely
        one: its place follows from both.
        """
        found: dict[int, float] = {}
        for join in self.last:
            for member in join.second.members:
                found[member] = min(chance_of(join), found.get(member, 1.0))
        return found

    def settle(self, join: Join, loser: tuple[int, ...]) -> None:
        """Keep who lost it from a place, and forget that it lay there."""
        self.settled.append((join, loser))
        self.sure = [each for each in self.sure if not laid_there(each, join, loser)]
        self._forget_likely(lambda each: laid_there(each, join, loser))

    def forget(self, join: Join) -> None:
        """Forget that what was said of two unions was likely."""
        self.half_likely = [each for each in self.half_likely if not _same(each, join)]
        self._forget_likely(lambda each: _same(each, join))

    def has_root(self, members: Collection[int]) -> bool:
        """Whether one of these is the root of a group."""
        return not self.roots.isdisjoint(members)

    def said_to_strangers(self, here: Union) -> list[Join]:
        """What was kept in mind of a union and others, of those that have no root."""
        kept = (self.sure, self.likely, self.by_skin, self.filling, self.half_likely)
        return [
            join
            for joins in kept
            for join in joins
            if here in join.both and not self.has_root({*join.members} - {*here.members})
        ]

    def disbelieve(self, join: Join) -> None:
        """Forget that what was said of two unions was sure or likely."""
        self.sure = [each for each in self.sure if not _same(each, join)]
        self.chances[_members(join)] = LEAST
        self.forget(join)

    def _forget_likely(self, gone: Callable[[Join], bool]) -> None:
        self.likely = [each for each in self.likely if not gone(each)]
        self.by_skin = [each for each in self.by_skin if not gone(each)]
        self.filling = [each for each in self.filling if not gone(each)]


def _same(one: Join, other: Join) -> bool:
    """Whether both are answers of the same two unions."""
    return one.first is other.first and one.second is other.second


def chance_of(join: Join) -> float:
    """Of what was found."""
    return join.met.chance


def odds_of(join: Join) -> float:
    """The same as odds."""
    return join.met.chance / (1.0 - join.met.chance)


def chance_at(odds: float) -> float:
    """Odds as a chance."""
    return odds / (1.0 + odds)


def odds_beside(join: Join, rival: Join, often: float) -> float:
    """Odds that a place is right which a rival claims as well, rightly or not.

        P(right) : P(wrong) = (often o o' + o) : (o' + 1),     o, o': odds of both

    Both right, which is so `often` of two that are; it alone; the rival alone, neither. So where
    both are beyond doubt they overlap.
    """
    own, its = odds_of(join), odds_of(rival)
    return own * (1.0 + often * its) / (1.0 + its)


def laid_there(before: Join, join: Join, members: tuple[int, ...]) -> bool:
    """Whether an answer laid these members, or a union of them, where the second of a join lies."""
    return set(members) <= set(before.second.members) and crowding(before, join) > CROWD


def undisputed(claims: Sequence[tuple[Union, Join]]) -> list[tuple[Union, Join]]:
    """The claims of unions that claim no place which another one claims as well.

    Of two that do one may be another body's limb, and nothing tells which.
    """
    disputed = {
        id(union)
        for (one, claim), (other, rival) in combinations(claims, 2)
        if one is not other and crowding(claim, rival) > CROWD
        for union in (one, other)
    }
    return [(union, claim) for union, claim in claims if id(union) not in disputed]


def _members(join: Join) -> tuple[tuple[int, ...], tuple[int, ...]]:
    return join.first.members, join.second.members


def _are_parts(
    members: tuple[tuple[int, ...], tuple[int, ...]], larger: tuple[Union, Union]
) -> bool:
    """Whether a question was about parts of two unions, one of each."""
    first, second = (set(each) for each in members)
    own, its = (set(each.members) for each in larger)
    return (own >= first and its >= second) or (own >= second and its >= first)
