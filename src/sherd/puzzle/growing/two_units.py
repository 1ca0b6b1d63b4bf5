"""What two unions share, asked in their own unit, and where that is not sure in units of the whole.

Bumps of the skin are looked at, and neighborhoods, that are as wide as they are on the larger of
both. Where that is a small piece the finer ones differ from pose to pose, and its mesh hardly has
them. So what is not sure may be sure at large.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from sherd.puzzle.growing.asking import against, common_area
from sherd.puzzle.growing.common_places import left_out
from sherd.puzzle.growing.record import CROWD
from sherd.puzzle.growing.union import Join, Union
from sherd.puzzle.pairwise.answer import JOINED, Meeting, likelier
from sherd.puzzle.pairwise.meeting import PairQuestion
from sherd.threads import cached_property

__all__ = ["QuestionInTwoUnits"]

# Units that differ by less show the same bumps.
WIDER = 1.15
# What has no more than this, by all that is seen or by its skin, may only seem sure at large: a
# cat's leg on another leg and a part of another animal on its neck, which have 0.87 and 0.92 there,
# have 0.01 and 0.00. Of answers with 0.1 to 0.5 by their skin two thirds are right (23 of ten
# puzzles). A horse's leg with 0.14 is sure at large (0.86), wrong answers of 0.45 and 0.59 are not
# (0.18, 0.01).
SEEN = 0.1
# What shares so much of the whole's area is believed at large by itself: there bumps are wide, so a
# small place has few of them, and reliefs scatter as one over the root of their number. In most
# pairs of four puzzles of a horse and a cat (two of cells, two of balls) all 12 answers that are
# sure at large where labels save most are right, with 0.06 to 0.31 of the whole; of three at
# further places two are wrong, with 0.05 and 0.06. So further places are asked at large only if
# that can confirm one, and this is above what wrong ones have.
SEEN_AT_LARGE = 0.1
# But not what shares more than this of the larger one, whose own unit sees all of it: a cow's leg
# on a lion's, 0.81 of that, is sure at large (0.9) and found at no place in their own unit. Of what
# is right and found at large alone the most is a ball on a ball, 0.6 of it. Half way by ratio.
SEEN_IN_OWN_UNIT = 0.7
# What shares less must not have a mirror image that fits clearly better at large. A part of a horse
# on one of a cat, 0.05 of the whole, seems sure there (0.81; 0.22 in their own unit) and has -0.64;
# right ones of four puzzles that share 0.05 to 0.12 have -0.21 and more. This is half way.
MIRRORED = -0.42


@dataclass(frozen=True, eq=False)
class QuestionInTwoUnits:
    """What two unions share.

    Attributes
    ----------
    first, second
        The larger union and the other one.
    whole
        What sqrt(area) of the whole may be, in the unit of their meshes.
    asked_in
        Asks it in a unit of length, at least that of the larger one.
    """

    first: Union
    second: Union
    whole: float
    asked_in: Callable[[float], PairQuestion]

    def at_a_glance(self) -> Meeting:
        """Where labels save most; in units of the whole if only that is sure, and much is shared.

        Less sure if something was likely elsewhere.
        """
        own = self._own.at_a_glance()
        if own.chance >= JOINED or self._wide is None:
            return own
        there, before = self._join(self._wide.at_a_glance()), self._join(own)
        met = there.met
        if met.chance < JOINED or not self._believed_at_large(common_area(there)):
            met = own
        elif left_out(before, there) > CROWD:
            met = against(there, before).met
        return _recognizing(met, [own, there.met])

    def in_full(self) -> Meeting:
        """All places, if none is sure at a glance; in units of the whole where one has a chance.

        That counts if it is sure, at the same place as in their own unit, and if its mirror image
        does not fit clearly better. If not, it is evidence whether they belong together.
        """
        met = self.at_a_glance()
        if met.chance >= JOINED:
            return met
        found = self._own.in_full()
        own = _recognizing(found, [found, met])
        if own.chance >= JOINED or likelier(own) < SEEN or self._wide is None:
            return own
        there = self._join(self._wide.in_full())
        sure = there.met.chance >= JOINED and there.met.handedness >= MIRRORED
        sure = sure and left_out(self._join(own), there) <= CROWD
        found = there.met if sure else replace(own, at_large=likelier(there.met))
        return _recognizing(found, [own, there.met])

    def _believed_at_large(self, area: float) -> bool:
        """Whether what shares so much is believed in units of the whole by itself."""
        most = SEEN_IN_OWN_UNIT * self.first.mesh.area
        return SEEN_AT_LARGE * self.whole**2 <= area <= most

    @cached_property
    def _own(self) -> PairQuestion:
        return self.asked_in(0.0)

    @cached_property
    def _wide(self) -> PairQuestion | None:
        """In units of the whole; None if these are hardly wider."""
        return self.asked_in(self.whole) if self.whole >= WIDER * self._own.unit else None

    def _join(self, met: Meeting) -> Join:
        return Join(self.first, self.second, met)


def _recognizing(met: Meeting, answers: Sequence[Meeting]) -> Meeting:
    """The same where as much of the skin is recognized as by any answer to the question."""
    return replace(met, recognized=max(each.recognized for each in answers))
