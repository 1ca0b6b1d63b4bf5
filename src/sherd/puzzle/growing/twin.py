"""A piece whose mirror image lies on what is joined already belongs beside that.

Of a body with two sides each limb has a twin. Where one of them is joined, and the other one is to
be, the mirror image of the second lies on the first as a whole, from its tip to what both share
with the trunk. What is shared at the place where the limb belongs is a rim, and how the limb goes
on beyond it nobody sees there; what another animal's limb shares with the same rim may be as
alike. The twin tells, since it has all of the limb.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from sherd.arrays import Bools
from sherd.correspondence.confidence import LEAST, MOST
from sherd.puzzle.growing.answer import JOINED, Meeting
from sherd.puzzle.growing.join_chance import ends_with_one, lies_within

__all__ = ["beside_their_twins"]

# How many times as likely it is that a limb belongs there, if its mirror image surely lies on what
# is there. Five bodies that lack a limb were asked for its mirror image: their own surely lies on
# the twin in five of five (0.95 and more), that of another species in none of eight (0.39 at most).
# So nearly all that belong have that evidence, and of the others one in ten at most.
TWIN_ODDS = 10.0
# More of a place than this is not beside another one.
COMMON = 0.5


def beside_their_twins(
    answers: Sequence[Meeting], asked_mirrored: Callable[[], Meeting], taken: Bools | None
) -> Meeting:
    """The likeliest of several answers of which none is sure, by what the mirror image says, too.

    What lies beside the place of the mirror image, and could be sure by that, has TWIN_ODDS times
    the odds of what is seen of its skin but for reliefs. That few of its places lead is no evidence
    then, as they look like those of its twin; nor is it that one of two places is more alike, or
    that a rim has few bumps.

    Where the piece itself was laid on that place before, too, which is taken then, it is a limb and
    lies on its twin. What is laid first of all beside that, with enough places that lead, and ends
    where one of both pieces ends, is as sure as that the twin is one: joints bend beside a rim, so
    of the skin that is shared there often nothing can be told.

    Parameters
    ----------
    answers
        At least one; the first one is what saves most.
    asked_mirrored
        Asks the same of the mirror image of the second surface.
    taken
        Vertices (m,) of the first surface's working mesh where nothing was laid as the second one
        was there before; none if None.
    """
    best, first = max(answers, key=_chance), answers[0]
    beside = [each for each in answers if not lies_within(each.questions, each.placements)]
    likely = [each for each in beside if _raised(each.fitting) >= JOINED]
    ending = 0.0
    if taken is not None and first in beside and first.leads:
        ending = ends_with_one(first.questions, first.placements)
    if best.chance >= JOINED or (not likely and ending < JOINED):
        return best
    twin = asked_mirrored()
    if twin.by_skin < JOINED or not lies_within(twin.questions, twin.placements):
        return best
    raised = [(each, _raised(each.fitting)) for each in likely]
    if taken is not None and _share(twin, taken) > COMMON:
        raised.append((first, ending * twin.by_skin))
    sure = [
        replace(each, chance=chance, twin=False)
        for each, chance in raised
        if _share(each, twin.placements[1].shared) < COMMON
    ]
    return max([best, *sure], key=_chance)


def _raised(chance: float) -> float:
    odds = TWIN_ODDS * chance / (1.0 - chance)
    return float(np.clip(odds / (1.0 + odds), LEAST, MOST))


def _share(answer: Meeting, region: Bools) -> float:
    """The share of an answer's place on the first surface that is in a region (m,)."""
    areas = answer.questions[0].full.mesh.vertex_areas
    place = areas * answer.placements[1].shared
    return float(place @ region / max(place.sum(), 1e-12))


def _chance(met: Meeting) -> float:
    return met.chance
