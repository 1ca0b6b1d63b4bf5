"""The chance that two pieces are laid on each other rightly, by the skin that they share.

Skin on itself is more alike than its mirror image, its places lead, it is hardly strained, and it
bulges where it did; a limb on another limb, or another animal's, may have all of this but one. And
its relief is the same, more than by accident.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import expit

from sherd.correspondence.confidence import LEAST, MOST, above
from sherd.correspondence.labels.two_way import Both
from sherd.correspondence.question import Question
from sherd.correspondence.shared.accident import most_by_accident
from sherd.correspondence.shared.judgment import share_of_both, shared_area
from sherd.correspondence.shared.likeness import Likeness, handed_by_relief
from sherd.correspondence.shared.relief_correlation import alike_in_form
from sherd.correspondence.shared.two_way_placement import SharedPlacement
from sherd.puzzle.pairwise.join_chance import (
    LED_STEP,
    UNLIKE_STEP,
    ends_with_one,
    lies_within,
    mean_strain,
)
from sherd.puzzle.pairwise.sliding import alike_in_reliefs

__all__ = ["SlidChance", "chance_as_it_lies", "chance_where_it_slid", "least_alike"]

# A slide finds the most alike of what is near, and a rank correlation of n independent places
# scatters by 1 / sqrt(n) where nothing is alike. So reliefs must be as alike as so much over the
# root of the shared area, within bounds: an arm of a woman slides to 0.51 on her other arm, where
# 0.10 is shared, right answers of as much to 0.64 and more, those of a third of an animal to 0.50.
SLID_UNLIKE, LEAST_UNLIKE, MOST_UNLIKE = 0.2, 0.42, 0.58
# However little is shared, reliefs must be more alike than by accident: by two and a half standard
# deviations, over bumps 0.034 wide, as several places of several pieces are looked at. Another
# animal's part had 0.105 and 0.116 of it on two rings of a horse's leg, a foreleg of a horse 0.123
# to 0.136 on the rim of its hind leg, of which 0.02 to 0.03 is shared, a horse's tail 0.147 on that
# of a cat, and a strip of a cat's hind part 0.150 on its rump. Of 76 questions with a sure right
# answer two are lost to this and none to 0.15; what shares so little waits for a union that shares
# more.
ACCIDENT = 0.155
# For what was likely before, by all else, they may be less alike by this. At one width, before they
# slid, reliefs of a small piece of a lion at a wrong place (a chance of 0.62) and of a part of a
# cat on a horse (0.81) were alike by 0.38 and 0.29; slid, they are 0.43 and 0.15 below. Of right
# ones that were sure, in ten puzzles, one is below, by 0.04, of a cat; this is half way.
SPARED = 0.09
# Of two thirds of three other people on a woman 0.67, 0.79 and 0.82 of the places lead; of right
# answers that need this to be sure 0.87 and more.
SLID_LED = 0.85
# Where the skin is as sure as this few places need not lead: those of a leg that is seen to the
# ankle look like those of the other leg. What was seen of other people where fewer lead has up to
# 0.8 by its skin; of five right answers three have 0.89 to 0.95, two 0.82. Between, at least three
# steps to either. Limbs of other people in the same pose have up to 0.997, but there places lead.
OWN_SKIN, OWN_STEP = 0.85, 0.01
# Of one, the share of places that are more alike than mirrored, the share that lead, strain, and
# how alike forms are. A logistic regression over 114 answers to ten puzzles and to eight animals
# and people that were asked for the limb they lack, which slid to where reliefs are nearly that
# alike, wrong ones counting twice: of 87 right ones 11 are below 0.65, of 27 wrong or foreign ones
# one is at 0.65. With each shape left out in turn 11, and three above, all of which the conditions
# here refuse. What an answer was worth before its slide adds nothing to these (a coefficient of
# -0.1 of its log odds). Limbs of other people, strained by 0.05 on a limb as long, are not in it:
# they have up to 0.8, in the same pose up to 0.997.
SLID_COEFFICIENTS = (-14.9, 12.8, 3.6, -6.0, 6.3)
# What fills a gap of the body may be less alike in relief by this. Right answers that only that
# refuses are at -0.03, 0.00 and 0.03, of three puzzles; the most alike wrong ones, as likely by all
# else, at -0.09 and -0.25, which fill a gap, -0.05, and -0.07 (a horse's leg on a lion).
SPARED_IN_A_GAP = 0.04
# What lies within the other has no border there to tell by, so it must be as sure by its skin as
# one's own is: two parts of other people, in the same pose, have 0.86 and 0.89, a half of the
# generated animal 0.995. Three steps to either, and more.
OWN_WITHIN, WITHIN_STEP = 0.95, 0.005
# Between the shares of places that are more alike than mirrored, of limbs on other limbs, which may
# be alike in all else, and of what lies right. A foreleg of a horse on its hind leg has 0.61, with
# forms alike by 0.91 and a strain of 0.12. Of four wrong questions of seven whole puzzles that are
# likely by all else a leg of a cat on another one has 0.68 to 0.70 and one of a horse as much; two
# of a cat have more than many right ones. Of 27 with right answers that are likely by their skin
# none is lost to 0.70, one to 0.71.
SIDED, SIDED_STEP = 0.70, 0.01
# What lies within the other, and of which fewer places than this are more alike than mirrored, lies
# on its twin if its reliefs are alike. Of twelve limbs on their twins, of two men, a horse, a wolf
# and a cat, eight have 0.35 to 0.48, four 0.51 to 0.56.
TURNED = 0.5


@dataclass(frozen=True)
class SlidChance:
    """What is thought of an answer by its skin, where it was laid or where it slid to.

    Attributes
    ----------
    chance
        That it is right.
    by_skin
        The same by the skin that is shared alone: whatever was thought before, whether places lead,
        and whether one piece lies within the other. 0 where too little is shared to be judged.
    fitting
        That by all but reliefs, of which a small place has too few bumps.
    filling
        That by the skin alone if it fills a gap.
    alike
        Whether reliefs are as alike as they must be; asked where it was laid only.
    turned
        Likewise, whether it lies on its twin: within the other, with reliefs alike, but more like
        mirrored.
    """

    chance: float
    by_skin: float
    fitting: float = 0.0
    filling: float = 0.0
    alike: bool = False
    turned: bool = False


def chance_as_it_lies(
    questions: Both[Question], placements: Both[SharedPlacement], likeness: Likeness | None
) -> SlidChance:
    """The chance of an answer by its skin alone, where it was laid.

    A slide looks for what is alike and may leave the right place for it, so what lies right already
    is sure as it is. Of what lies within the other the skin alone makes nothing likelier.
    `likeness` is that of both.
    """
    skin = _skin(questions, placements, likeness)
    if skin is None:
        return SlidChance(LEAST, 0.0)
    within = lies_within(questions, placements)
    led = 0.0 if within else skin.led
    alike = skin.alike >= 0.0
    turned = within and alike and skin.handed < TURNED
    chance = float(np.clip(led, LEAST, MOST))
    return SlidChance(chance, skin.by_skin, skin.fitting, skin.filling, alike, turned)


def chance_where_it_slid(
    before: float,
    questions: Both[Question],
    placements: Both[SharedPlacement],
    likeness: Likeness | None,
) -> SlidChance:
    """The chance of an answer by what is seen where it slid to, too.

    Skin that is laid on itself there is more alike than its mirror image, its places lead, it is
    hardly strained, and it bulges where it did; something else is strained by the slide, and
    bulges elsewhere. With alike reliefs that is enough to be sure, and without them nothing is:
    skin that slid to where it is most alike and is no more so than by accident is not the same
    skin. So what was likely before is no likelier than that. Of what lies wholly within the other
    all places may lead, so what is seen there makes nothing likelier, and must be all the surer.
    `likeness` is that of both there.
    """
    skin = _skin(questions, placements, likeness)
    if skin is None:
        return SlidChance(before, 0.0)
    before = min(before, skin.fitting)
    if lies_within(questions, placements):
        chance = before * above(skin.by_skin, OWN_WITHIN, WITHIN_STEP)
    else:
        chance = max(before * above(skin.alike, -SPARED, UNLIKE_STEP), skin.led)
    chance = float(np.clip(chance, LEAST, min(skin.most, MOST)))
    return SlidChance(chance, skin.by_skin, skin.fitting, skin.filling)


@dataclass(frozen=True)
class _Skin:
    """What the skin says that two pieces share.

    Attributes
    ----------
    seen
        The chance by all but reliefs.
    alike
        By how much reliefs are more alike than they must be.
    handed, leading
        The share of places that are more alike than mirrored, by normals and by relief, and the
        share that lead.
    ending
        How surely it ends where one of both pieces does.
    most
        What a chance may be at the most, as all may be alike by accident.
    """

    seen: float
    alike: float
    handed: float
    leading: float
    ending: float
    most: float

    @property
    def fitting(self) -> float:
        """The chance by all but reliefs.

        Only if most places are more alike than mirrored, and what is shared ends with one of both.
        """
        return self.seen * above(self.handed, SIDED, SIDED_STEP) * self.ending

    @property
    def by_skin(self) -> float:
        """The same with reliefs."""
        return min(self.fitting * above(self.alike, 0.0, UNLIKE_STEP), self.most)

    @property
    def filling(self) -> float:
        """The same of what fills a gap, where reliefs may be a little less alike."""
        return min(self.fitting * above(self.alike, -SPARED_IN_A_GAP, UNLIKE_STEP), self.most)

    @property
    def led(self) -> float:
        """The same where many places lead, as of others' skin they seldom do, or it is surer."""
        own = max(above(self.leading, SLID_LED, LED_STEP), above(self.by_skin, OWN_SKIN, OWN_STEP))
        return self.by_skin * own


def _skin(
    questions: Both[Question], placements: Both[SharedPlacement], likeness: Likeness | None
) -> _Skin | None:
    """None where too little is shared to be judged."""
    if likeness is None:
        return None
    both = tuple(zip(questions, placements, strict=True))
    strain = float(np.mean([mean_strain(*each) for each in both]))
    area = shared_area(questions, placements)
    bulging = alike_in_form(questions, placements)
    features = np.array([1.0, likeness.handed, likeness.leading, strain, bulging])
    seen = float(expit(features @ np.array(SLID_COEFFICIENTS)))
    alike = alike_in_reliefs(questions, placements) - least_alike(area)
    handed = _handed(questions, placements, likeness)
    ending = ends_with_one(questions, placements)
    most = most_by_accident(questions, placements)
    return _Skin(seen, alike, handed, likeness.leading, ending, most)


def _handed(
    questions: Both[Question], placements: Both[SharedPlacement], likeness: Likeness
) -> float:
    """The share of places that are more alike than mirrored, mean of normals and of relief.

    Both count the same places and see something else there: of a foreign part's answers on a horse
    0.71 are by normals and 0.70 by relief, of a horse's right ones at the edge 0.65 to 0.70 and
    0.75 to 0.90.
    """
    by_relief = share_of_both(handed_by_relief, questions, placements)
    return likeness.handed if by_relief is None else 0.5 * (likeness.handed + by_relief)


def least_alike(area: float) -> float:
    """How alike reliefs of an area must be."""
    root = max(math.sqrt(area), 1e-12)
    most = max(MOST_UNLIKE, ACCIDENT / root)
    return float(np.clip(SLID_UNLIKE / root, LEAST_UNLIKE, most))
