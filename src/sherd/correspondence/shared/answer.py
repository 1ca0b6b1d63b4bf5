"""What two incomplete shapes share: the labeling that saves most, or the surest of several places.

What saves most is not always right. Half of a body laid on a third that is shared may save more
than that third does, and two species are so little alike that wrong places save as much as right
ones. So where the first answer is not sure, other places are looked at as well. To lay both shapes
on each other in full takes longest, so labels say at which places a first look is taken, and that
which of them is laid in full.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from sherd.arrays import Floats
from sherd.correspondence.confidence import LEAST
from sherd.correspondence.labels.labeling import Problem
from sherd.correspondence.labels.two_way import Both, TwoLabelings, two_way_labelings
from sherd.correspondence.plausibility import mirrored_energies
from sherd.correspondence.question import Question
from sherd.correspondence.shared.accident import most_by_accident
from sherd.correspondence.shared.glance import Glance, glance
from sherd.correspondence.shared.judgment import (
    CLOSER_RISE,
    LAID_RISE,
    form_log_odds,
    further_chance,
    likeness_of_both,
    may_be_sure,
    mirror_is_better,
    mirror_says_something,
    most_chance,
    most_open,
    overlap_chance,
    overlap_log_odds,
    place_chances,
    place_log_odds,
    shared_area,
)
from sherd.correspondence.shared.places_by_form import finished_place, labelings_by_form
from sherd.correspondence.shared.relief_correlation import alike_in
from sherd.correspondence.shared.rivals import are_rivals
from sherd.correspondence.shared.two_way_placement import (
    SharedPlacement,
    first_look,
    looked_closer,
    placed_together,
)
from sherd.correspondence.shared.viewed import are_views, viewed_problems
from sherd.correspondence.working_placement import Queries
from sherd.descriptors.relief import form
from sherd.results.advice import SURE
from sherd.threads import cached_property, side_by_side

__all__ = ["SharedAnswer", "shared_answer"]


# At so many places a first look is taken, the likeliest by their labels. Of 25 pairs of SMAL that
# are not sure all 11 right places are among the first three, 10 among two; in another order of
# starts one was the fourth, by a hair.
LOOKED = 4
# The logarithm of odds below which what saves most stays: where no place is even a tenth as likely
# to be right as to be wrong, another one is a guess as well, and saves less.
LEAST_BELIEVED = -2.3
# What knows what viewers could not see is believed where its odds are half of those of what does
# not know it.
VIEWED = 2.0
# No chance was fitted on what viewers saw, so it is never called good.
VIEWED_CHANCE = 0.5


@dataclass(frozen=True, eq=False)
class SharedAnswer:
    """Both shapes laid on each other, and how likely that is right.

    Attributes
    ----------
    labelings
        By which they were laid.
    placements
        Of the second shape on the first, and of the first on the second.
    log_odds
        That the answer as a whole is right, by its labels and what is seen inside.
    by_form
        The logarithm of the odds that it lies at the right place, by its form.
    chance
        The first as a chance, or a better one where other places were asked.
    most
        What the chance may be at the most, where something forbids to believe it.
    twin
        Whether the mirror image of one shape is more alike the other, at the same place too.
    """

    labelings: TwoLabelings
    placements: Both[SharedPlacement]
    log_odds: float
    by_form: float
    chance: float
    most: float
    twin: bool

    @property
    def place_log_odds(self) -> float:
        """The logarithm of the odds of its place against none, by both kinds of evidence."""
        return place_log_odds(self.log_odds, self.by_form)


def shared_answer(
    questions: Both[Question],
    problems: Both[Problem],
    labelings: TwoLabelings,
    queries: Both[Queries],
    *,
    strain: float,
    seed: int,
) -> SharedAnswer:
    """Lay both shapes on each other by the labeling that saves most, or where they fit better.

    What saves most, and fits best of all places, is as likely as its place is beside the others;
    views of one camera are not, whose place may be right and half of them laid wrongly. An answer
    at another place is as likely as all that is said of it: see :func:`further_chance`.

    Parameters
    ----------
    questions
        The second shape on the first, and the first on the second.
    problems, labelings
        What was labeled, without a price, and what saves most.
    queries
        Vertices of the second and of the first shape that look for similar places.
    strain
        What is accepted as shared.
    seed
        Of all random choices.
    """
    asked = _Asked(questions, problems, labelings, queries, strain, seed)
    views = are_views(questions)
    laid: list[SharedAnswer] = []
    if views or may_be_sure(labelings, asked.seen(labelings)):
        laid.append(asked.answer(labelings))
        if laid[0].chance >= SURE:
            return laid[0]
    elsewhere = _laid_where_likely(asked, laid)
    there = asked.place_chances(laid, elsewhere)
    preference = np.ones(len(laid))
    if views:
        # where viewers stood may be right though the place is not
        stood = dict.fromkeys((0, int(np.argmax(there))))
        seen = [_labelings_of_viewers(questions, laid[each], seed) for each in stood]
        laid += [asked.answer(each) for each in seen]
        there = asked.place_chances(laid, elsewhere)
        preference = np.append(preference, np.full(len(seen), VIEWED))
    surest = int(np.argmax(preference * there / (1.0 - there)))
    best, place = laid[surest], float(there[surest])
    if preference[surest] == VIEWED:
        chance = min(best.chance, place, VIEWED_CHANCE)
    elif best.labelings is not labelings:
        chance = min(best.chance, place, further_chance(best.log_odds, best.by_form))
    elif views:
        chance = best.chance
    else:
        chance = float(np.clip(place, LEAST, best.most))
    return replace(best, chance=chance)


def _laid_where_likely(asked: _Asked, laid: list[SharedAnswer]) -> list[float]:
    """Lay both shapes at the likeliest of all places too, unless that is laid already.

    Appended to `laid`. Returns the expected log odds of all places that are not laid.
    """
    done = [each.labelings for each in laid]
    begun = labelings_by_form(asked.problems, asked.forms, asked.labelings)
    promising = sorted([asked.labelings, *begun], key=asked.expected, reverse=True)
    near = [each for each in promising[:LOOKED] if each not in done]
    found = side_by_side(partial(asked.looked_at, each) for each in near)
    looks = dict(zip(near, found, strict=True))
    odds = {each: asked.expected(each) for each in promising[LOOKED:] if each not in done}
    odds |= {each: look.place_log_odds + CLOSER_RISE for each, look in looks.items()}
    best = max(looks, key=lambda each: odds[each], default=asked.labelings)
    if odds.get(best, LEAST_BELIEVED) < LEAST_BELIEVED:
        best = asked.labelings
    reached = max((each.place_log_odds for each in laid), default=None)
    if best not in done and (reached is None or odds[best] > reached):
        laid.append(asked.finished(looks[best]) if best in looks else asked.answer(best))
        odds.pop(best, None)
    return list(odds.values())


def _labelings_of_viewers(
    questions: Both[Question], answer: SharedAnswer, seed: int
) -> TwoLabelings:
    """The nodes of both shapes labeled by what both viewers saw, as an answer places them."""
    rngs = (np.random.default_rng(seed + 1), np.random.default_rng(seed + 1))
    return two_way_labelings(*viewed_problems(questions, answer.placements, seed), rngs)


@dataclass(frozen=True, eq=False)
class _Asked:
    """One question about two shapes: lays answers to it, and says how likely they are.

    The attributes are what :func:`shared_answer` takes.
    """

    questions: Both[Question]
    problems: Both[Problem]
    labelings: TwoLabelings
    queries: Both[Queries]
    strain: float
    seed: int

    @cached_property
    def forms(self) -> Both[Floats]:
        """Of the second shape and of the first."""
        return form(self.questions[0].part.mesh), form(self.questions[1].part.mesh)

    @cached_property
    def mirrored_ratio(self) -> float:
        """`first_ratio` of the mirror images."""
        energies = mirrored_energies(self.questions, self.seed)
        chances = self.labelings.chance
        return min(
            energy / max(by_chance, 1e-12)
            for energy, by_chance in zip(energies, chances, strict=True)
        )

    @cached_property
    def _seen(self) -> dict[TwoLabelings, Glance]:
        return {}

    def seen(self, labelings: TwoLabelings) -> Glance:
        """What labelings say of their place before anything is laid there."""
        if labelings not in self._seen:
            found = glance(self.questions, self.problems, labelings, self.forms)
            self._seen[labelings] = found
        return self._seen[labelings]

    def expected(self, labelings: TwoLabelings) -> float:
        """The log odds that a place is expected to have once both shapes are laid there."""
        seen = self.seen(labelings)
        ratio = labelings.first_ratio  # the mirror image is not asked of what may not be laid
        by_labels = overlap_log_odds(labelings, ratio, seen.likeness, seen.is_open)
        by_form = form_log_odds(seen.likeness, seen.is_open, seen.form)
        return place_log_odds(by_labels, by_form) + LAID_RISE

    def looked_at(self, labelings: TwoLabelings) -> SharedAnswer:
        """What labelings lead to at a first look."""
        look = first_look(self.questions, labelings, self.queries, strain=self.strain)
        return self._judged(labelings, look)

    def answer(self, labelings: TwoLabelings) -> SharedAnswer:
        """The answer that labelings lead to."""
        placed = placed_together(self.questions, labelings, self.queries, strain=self.strain)
        return self._judged(labelings, placed)

    def finished(self, look: SharedAnswer) -> SharedAnswer:
        """The answer that a first look leads to, by labels after all rounds."""
        labelings = look.labelings
        if labelings is not self.labelings:  # what saves most has had them
            labelings = finished_place(self.problems, labelings)
        if labelings is not look.labelings:
            return self.answer(labelings)
        found = looked_closer(self.questions, self.queries, look.placements, strain=self.strain)
        return self._judged(labelings, found)

    def _judged(self, labelings: TwoLabelings, placements: Both[SharedPlacement]) -> SharedAnswer:
        """What was laid by labelings, and how likely it is."""
        likeness = likeness_of_both(self.questions, placements)
        mirrored = labelings.first_ratio
        if mirror_says_something(likeness):
            mirrored = self.mirrored_ratio
        is_open = most_open(self.questions, placements)
        log_odds = overlap_log_odds(labelings, mirrored, likeness, is_open)
        by_accident = most_by_accident(self.questions, placements)
        most = min(most_chance(labelings, mirrored), by_accident)
        alike = alike_in(self.forms, self.questions, placements)
        proved = alike * np.sqrt(shared_area(self.questions, placements))
        return SharedAnswer(
            labelings,
            placements,
            log_odds,
            by_form=form_log_odds(likeness, is_open, proved),
            chance=overlap_chance(log_odds, most),
            most=most,
            twin=mirror_is_better(labelings.first_ratio, mirrored),
        )

    def place_chances(self, laid: list[SharedAnswer], elsewhere: list[float]) -> Floats:
        """How likely each of several answers is beside the others, and beside what is not laid."""
        rivals = are_rivals(self.questions, [each.placements for each in laid])
        return place_chances([each.place_log_odds for each in laid], rivals, elsewhere)
