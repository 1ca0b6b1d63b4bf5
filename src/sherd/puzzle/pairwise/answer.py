"""What two surfaces share by one labeling of both, and how likely it is right."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np
from scipy.special import expit, logit

from sherd.arrays import Bools
from sherd.correspondence.confidence import LEAST, MOST
from sherd.correspondence.labels.two_way import Both
from sherd.correspondence.question import Question
from sherd.correspondence.shared.judgment import place_chances
from sherd.correspondence.shared.rivals import are_rivals
from sherd.correspondence.shared.two_way_placement import SharedPlacement
from sherd.correspondence.working_placement import Queries

__all__ = [
    "HALF_LIKELY",
    "JOINED",
    "LIKELY",
    "RECOGNIZED",
    "Ground",
    "Meeting",
    "chance_to_belong",
    "ground_of",
    "likelier",
    "one_place",
]

# What is so likely is joined. More than is called good of a piece on its whole: what is joined is
# asked again as one, and a wrong piece draws others after it (a cat's leg on a horse that lacks it,
# and then the horse's own). That leg has 0.76, and so has an arm within another person's; of what
# is right 0.79 is the least that no larger union had to make surer (a half of the generated animal
# within the other one); of all right answers to nine puzzles above 0.65 two are below.
JOINED = 0.78
# More likely right than not.
LIKELY = 0.5
# Whose place is as likely as this belongs, at that place or at another one, as places are mistaken
# for others of the same body: of 641 answers about pieces of one body 49 have 0.4 to 0.78, and 12
# of these lie wrongly; of 204 about pieces of other species one has (0.56, by its skin), and that
# has nothing in units of the whole, see `chance_to_belong`.
HALF_LIKELY = 0.4
# Of whom so much of the group's area is recognized, less what is not, halved, belongs as well.
# Pieces of other species have 0.018 (a cow's on a dog) and 0.0156 at most on some 50 groups of all
# kinds; own ones that were left 0.0205 to 0.072, or, as many, less. Half way by ratio.
RECOGNIZED = 0.0192


class Ground(IntEnum):
    """What makes an answer more likely right than not: the weaker, the later it is joined."""

    NONE = 0
    GAP = 1
    SKIN = 2
    ALL = 3


@dataclass(frozen=True, eq=False)
class Meeting:
    """What two surfaces share.

    Attributes
    ----------
    questions
        The second on the first, and the first on the second.
    queries, placements
        Of both.
    unit
        What the questions' unit of length is in that of the surfaces.
    chance
        That what they share is found rightly, and they belong together.
    twin
        Whether what they share is laid on its twin, as a left leg on a right one.
    by_skin
        The chance by the skin alone that is shared where it lies; 0 where that was not asked.
    fitting
        That by all but reliefs.
    filling
        By the skin alone if it fills a gap of a body, where reliefs may be a little less alike.
    leads
        Whether so many places lead that it may lie there, or beside its place.
    handedness
        The logarithm of the energy of its mirror image over its own, as first laid.
    fills
        Whether each goes on all around where the other one ends, where it may be right as first
        laid and reliefs are as alike as they must be: all that tells own skin but its side and its
        form, which twins and tails lack. Of 30 pieces of other species none does so; five fill a
        gap by less, with 0.06 to 0.3 less relief, or 0.08 as laid.
    recognized
        The area that is recognized by its relief less what is not, halved, in units of the meshes:
        what is shared times how much more than a half of it is recognized. With many places this
        goes as the logarithm of the odds that both have one skin. As first laid or slid, and of all
        answers to the same question the most; 0 of what lies within, or where it is little.
    at_large
        The likelier of its chance and that by its skin in units of the whole, where the question
        was asked in full in these, too, and does not count in them; None if it was not.
    in_gap
        Of all answers to the same question the likeliest that fills so; None if none does.
    """

    questions: Both[Question]
    queries: Both[Queries]
    placements: Both[SharedPlacement]
    unit: float
    chance: float
    twin: bool
    by_skin: float = 0.0
    fitting: float = 0.0
    filling: float = 0.0
    leads: bool = False
    handedness: float = 0.0
    fills: bool = False
    recognized: float = 0.0
    at_large: float | None = None
    in_gap: Meeting | None = None


def ground_of(met: Meeting) -> tuple[Ground, float]:
    """The strongest ground on which an answer is likely, and its chance by that.

    What several answers to one question are chosen by: of most all that is seen leaves no chance
    (LEAST), also of some whose skin alone makes them likely.
    """
    if met.chance >= LIKELY:
        return Ground.ALL, met.chance
    if met.by_skin >= LIKELY:
        return Ground.SKIN, met.by_skin
    if met.filling >= LIKELY:
        return Ground.GAP, met.filling
    return Ground.NONE, likelier(met)


def likelier(met: Meeting) -> float:
    """The chance by all that is seen or by the skin alone, whichever is more."""
    return max(met.chance, met.by_skin)


def chance_to_belong(met: Meeting) -> float:
    """The chance that two pieces belong together, wherever they lie: by all or by the skin.

    Where they were asked in units of the whole, too, and are less likely there, the mean of both
    log odds: both see the same skin, and count as one. A cat's part on a horse has 0.53 by its skin
    in their own unit and nothing at large, and so have two wrong places of a horse (0.45 and 0.59).
    More at large proves nothing: what is sure there only may be of another animal.
    """
    own = likelier(met)
    if met.at_large is None or met.at_large >= own:
        return own
    odds = logit(np.clip([own, met.at_large], LEAST, MOST))
    return float(expit(odds.mean()))


def one_place(answers: Sequence[Meeting]) -> list[Meeting]:
    """The same answers to one question, of whose places one is right or none.

    See :func:`sherd.correspondence.shared.judgment.place_chances`: what looks right and could as
    well lie elsewhere is not sure. Of several answers at one place the likeliest counts.
    """
    chances = np.array([each.chance for each in answers])
    rivals = are_rivals(answers[0].questions, [each.placements for each in answers])
    rank = np.argsort(np.argsort(-chances, kind="stable"))
    repeated: Bools = np.any(~rivals & (rank[None, :] < rank[:, None]), axis=1)
    found = place_chances(logit(chances).tolist(), rivals & ~repeated, ())
    return [
        replace(answer, chance=float(chance)) for answer, chance in zip(answers, found, strict=True)
    ]
