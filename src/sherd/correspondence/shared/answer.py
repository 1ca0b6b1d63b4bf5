"""What two incomplete shapes share: the labeling that saves most, or the surest of several places.

What saves most is not always right. Half of a body laid on a third that is shared may save more
than that third does, and two species are so little alike that wrong places save as much as right
ones. So where the first answer is not sure, answers at other places are laid and judged as well.
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
from sherd.correspondence.shared.judgment import (
    form_log_odds,
    further_chance,
    likeness_of_both,
    mirror_is_better,
    mirror_says_something,
    most_chance,
    most_open,
    overlap_chance,
    overlap_log_odds,
    place_chances,
    shared_area,
)
from sherd.correspondence.shared.likeness import Likeness
from sherd.correspondence.shared.places_by_form import labelings_by_form
from sherd.correspondence.shared.relief import alike_in, form
from sherd.correspondence.shared.rivals import are_rivals
from sherd.correspondence.shared.two_way_placement import SharedPlacement, placed_together
from sherd.correspondence.shared.viewed import are_views, viewed_problems
from sherd.correspondence.working_placement import Queries
from sherd.results.advice import SURE
from sherd.threads import cached_property, side_by_side

__all__ = ["SharedAnswer", "shared_answer"]


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
    placements
        Of the second shape on the first, and of the first on the second.
    likeness, is_open
        What is seen of what is shared, and how much of its border lies inside both shapes.
    log_odds
        That the answer as a whole is right, by its labels and what is seen inside.
    chance
        The same as a chance, or a better one where other places were asked.
    most
        What the chance may be at the most, where something forbids to believe it.
    twin
        Whether the mirror image of one shape is more alike the other, at the same place too.
    """

    placements: Both[SharedPlacement]
    likeness: Likeness | None
    is_open: float
    log_odds: float
    chance: float
    most: float
    twin: bool


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
    laid = partial(placed_together, questions, queries=queries, strain=strain)
    judge = _Judge(questions, labelings, seed)
    first = judge.answer(labelings, laid(labelings))
    if first.chance >= SURE:
        return first
    others = labelings_by_form(problems, judge.forms, labelings)
    places = side_by_side(partial(laid, each) for each in others)
    answers = [first, *(judge.answer(*each) for each in zip(others, places, strict=True))]
    by_form = [judge.by_form(each) for each in answers]
    there = judge.place_chances(answers, by_form)
    preference = np.ones(len(answers))
    if are_views(questions):
        # where viewers stood may be right though the place is not
        begun = dict.fromkeys((0, int(np.argmax(there))))
        seen = [_labelings_of_viewers(questions, answers[each], seed) for each in begun]
        places = side_by_side(partial(laid, each) for each in seen)
        viewed = [judge.answer(*each) for each in zip(seen, places, strict=True)]
        answers += viewed
        by_form += [judge.by_form(each) for each in viewed]
        there = judge.place_chances(answers, by_form)
        preference = np.append(preference, np.full(len(seen), VIEWED))
    surest = int(np.argmax(preference * there / (1.0 - there)))
    best, place = answers[surest], float(there[surest])
    if surest > len(others):
        chance = min(best.chance, place, VIEWED_CHANCE)
    elif surest > 0:
        chance = min(best.chance, place, further_chance(best.log_odds, by_form[surest]))
    elif are_views(questions):
        chance = first.chance
    else:
        chance = float(np.clip(place, LEAST, first.most))
    return replace(best, chance=chance)


def _labelings_of_viewers(
    questions: Both[Question], answer: SharedAnswer, seed: int
) -> TwoLabelings:
    """The nodes of both shapes labeled by what both viewers saw, as an answer places them."""
    rngs = (np.random.default_rng(seed + 1), np.random.default_rng(seed + 1))
    return two_way_labelings(*viewed_problems(questions, answer.placements, seed), rngs)


class _Judge:
    """Says how likely answers to one question are.

    Parameters
    ----------
    questions
        The second shape on the first, and the first on the second.
    labelings
        What saves most.
    seed
        Of all random choices.
    """

    def __init__(self, questions: Both[Question], labelings: TwoLabelings, seed: int) -> None:
        self.questions, self.labelings, self.seed = questions, labelings, seed

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

    def answer(self, labelings: TwoLabelings, placements: Both[SharedPlacement]) -> SharedAnswer:
        """The answer that was laid by labelings, and how likely it is."""
        likeness = likeness_of_both(self.questions, placements)
        mirrored = labelings.first_ratio
        if mirror_says_something(likeness):
            mirrored = self.mirrored_ratio
        is_open = most_open(self.questions, placements)
        log_odds = overlap_log_odds(labelings, mirrored, likeness, is_open)
        most = most_chance(labelings, mirrored)
        return SharedAnswer(
            placements,
            likeness,
            is_open,
            log_odds,
            chance=overlap_chance(log_odds, most),
            most=most,
            twin=mirror_is_better(labelings.first_ratio, mirrored),
        )

    def by_form(self, answer: SharedAnswer) -> float:
        """The logarithm of the odds that an answer lies at the right place, by its form."""
        alike = alike_in(self.forms, self.questions, answer.placements)
        area = shared_area(self.questions, answer.placements)
        return form_log_odds(answer.likeness, answer.is_open, alike, area)

    def place_chances(self, answers: list[SharedAnswer], by_form: list[float]) -> Floats:
        """How likely each of several answers is beside the others."""
        rivals = are_rivals(self.questions, [each.placements for each in answers])
        return place_chances([each.log_odds for each in answers], by_form, rivals)
