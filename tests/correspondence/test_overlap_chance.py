"""The chance that an overlap is right, and what lowers it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from sherd.correspondence.shared.glance import Glance
from sherd.correspondence.shared.judgment import (
    form_log_odds,
    further_chance,
    may_be_sure,
    mirror_is_better,
    mirror_says_something,
    most_chance,
    overlap_chance,
    overlap_log_odds,
    place_chances,
    place_log_odds,
)
from sherd.correspondence.shared.likeness import Likeness

WELL = {
    "agreement": 0.85, "lack": 0.13, "open": 0.2, "leading": 0.75, "handed": 0.62, "mirrored": 0.5
}  # fmt: skip


def chance(**changes: float) -> float:
    """Of an answer that is right, but for the changes."""
    told = SimpleNamespace(**{**WELL, **changes}, first_ratio=0.5)
    likeness = Likeness(0.02, told.leading, told.handed)
    log_odds = overlap_log_odds(told, told.mirrored, likeness, told.open)
    return overlap_chance(log_odds, most_chance(told, told.mirrored))


def test_what_agrees_is_alike_and_misses_nothing_is_sure() -> None:
    assert chance(agreement=0.95, lack=0.05, open=0.0, leading=0.9, handed=0.7) > 0.9


@pytest.mark.parametrize(
    "worse",
    [
        {"agreement": 0.5},
        {"lack": 0.25},
        {"leading": 0.5},
        {"handed": 0.4},
        {"open": 2.0},
        {"mirrored": 0.4},
    ],
)
def test_each_thing_that_is_worse_lowers_the_chance(worse: dict[str, float]) -> None:
    assert chance(**worse) < chance() - 0.1


def test_what_is_right_and_lacks_half_of_what_is_shared_is_doubted() -> None:
    """Where it lies all is alike, but the directions confirm only a part of each other."""
    sure = {"lack": 0.03, "open": 0.0, "leading": 0.98, "handed": 0.9}
    assert chance(**sure, agreement=0.7) > 0.65
    assert chance(**sure, agreement=0.64) <= 0.5


def test_where_too_little_is_shared_to_be_judged_it_is_not_believed() -> None:
    labelings = SimpleNamespace(agreement=1.0, lack=0.0, first_ratio=0.2)
    log_odds = overlap_log_odds(labelings, 0.9, None, 0.0)
    assert overlap_chance(log_odds, most_chance(labelings, 0.9)) < 0.01
    assert further_chance(log_odds, log_odds) < 0.01
    assert form_log_odds(None, 0.0, 0.9) == log_odds
    assert list(beside([-9.0, log_odds], [-9.0, log_odds], apart(2))[1:]) == [0.0]


def test_a_mirror_image_that_is_better_by_accident_says_nothing() -> None:
    assert chance(mirrored=0.48) == chance(mirrored=0.9)


def test_a_limb_of_the_other_side_is_not_believed_however_well_it_agrees() -> None:
    """As far as measured: the mirror image of a leg is better by 0.07 and more."""
    sure = {"agreement": 1.0, "lack": 0.05, "open": 0.0, "leading": 0.85}
    assert chance(**sure, mirrored=0.4, handed=0.58) < 0.2
    assert mirror_is_better(0.7, 0.5)
    assert not mirror_is_better(0.7, 0.68)


def test_the_mirror_image_is_asked_where_places_do_not_say_which_side_it_is() -> None:
    assert mirror_says_something(Likeness(0.02, 0.8, 0.58))
    assert not mirror_says_something(Likeness(0.02, 0.8, 0.75))
    assert not mirror_says_something(None)


def test_a_chance_is_never_certain() -> None:
    best = {"agreement": 1.0, "lack": 0.0, "leading": 1.0, "handed": 1.0, "open": 0.0}
    worst = {
        "agreement": 0.0,
        "lack": 1.0,
        "leading": 0.0,
        "handed": 0.0,
        "open": 2.0,
        "mirrored": 0.0,
    }
    assert 0.0 < chance(**worst) < 0.01
    assert 0.99 < chance(**best) < 1.0


def apart(count: int) -> np.ndarray:
    """All of so many answers lie at different places."""
    return ~np.eye(count, dtype=bool)


def beside(by_labels: list[float], by_form: list[float], rivals: np.ndarray) -> np.ndarray:
    """Chances of answers of which nothing else is a rival."""
    odds = [place_log_odds(*each) for each in zip(by_labels, by_form, strict=True)]
    return place_chances(odds, rivals, [])


def place(**changes: float) -> float:
    """By form, of an answer at the right place, but for the changes."""
    told = {"leading": 0.75, "open": 0.3, "form": 0.4, **changes}
    likeness = Likeness(0.02, told["leading"], 0.6)
    return form_log_odds(likeness, told["open"], told["form"])


@pytest.mark.parametrize("worse", [{"leading": 0.5}, {"open": 1.5}, {"form": 0.1}])
def test_each_thing_that_is_worse_makes_a_place_less_likely(worse: dict[str, float]) -> None:
    assert place() > 0.5
    assert place(**worse) < place() - 0.5


def test_of_several_places_one_is_right_or_none() -> None:
    chances = beside([-1.0, 2.0, 0.0], [2.0, 1.0, -4.0], apart(3))
    assert 0.8 < chances.sum() < 1.0
    assert beside([-4.0], [-4.0], apart(1)).sum() < 0.3


def test_a_place_that_another_one_nearly_equals_is_not_likely() -> None:
    """However much speaks for it: a cow on a lion, 0.6 of the area, head on tail."""
    alone = beside([-0.9], [2.3], apart(1))[0]
    assert alone > 0.65
    both = beside([-0.9, 2.1], [2.3, 2.8], apart(2))
    assert both[0] < 0.5 < both[1] + 0.15


def test_labels_and_form_both_say_which_place_it_is() -> None:
    even = beside([0.0, 0.0], [0.0, 0.0], apart(2))
    by_labels = beside([0.0, 3.0], [0.0, 0.0], apart(2))
    by_form = beside([0.0, 0.0], [0.0, 3.0], apart(2))
    assert by_labels[1] > even[1] + 0.05
    assert by_form[1] > even[1] + 0.2


def test_answers_at_one_place_do_not_contradict_each_other() -> None:
    """A twentieth of a lion found twice: each was half as likely as it is."""
    by_labels, by_form = [2.0, 2.0], [3.0, 3.0]
    alone = beside(by_labels[:1], by_form[:1], apart(1))[0]
    assert list(beside(by_labels, by_form, np.zeros((2, 2), bool))) == [alone, alone]
    assert beside(by_labels, by_form, apart(2)).max() < 0.5


def test_a_further_place_needs_both_kinds_of_evidence() -> None:
    """For the best of six wrong answers labels or form speak, not both so clearly."""
    assert further_chance(6.0, 3.0) > 0.65
    assert further_chance(2.4, 2.4) < 0.5
    assert further_chance(5.7, 0.5) < 0.5
    assert further_chance(-1.0, 3.5) < 0.5


def test_places_where_nothing_was_laid_are_rivals_of_all() -> None:
    odds, alone = [1.0, 1.5], place_chances([1.0, 1.5], apart(2), [])
    assert (place_chances(odds, apart(2), [1.2]) < alone - 0.05).all()
    as_laid = place_chances([*odds, 1.2], apart(3), [])
    assert place_chances(odds, apart(2), [1.2]) == pytest.approx(as_laid[:2])
    assert place_chances(odds, apart(2), [-np.inf]) == pytest.approx(alone)


def test_what_may_be_sure_is_laid_and_what_cannot_be_is_not() -> None:
    """A border around nodes is wide open, and closes once both shapes are laid."""
    told = SimpleNamespace(**{**WELL, "agreement": 0.7}, first_ratio=0.5)
    seen = Glance(Likeness(0.02, 0.6, 0.65), 2.0, 0.3)
    assert may_be_sure(told, seen)
    assert not may_be_sure(SimpleNamespace(**{**vars(told), "agreement": 0.64}), seen)
    assert not may_be_sure(SimpleNamespace(**{**vars(told), "lack": 0.25}), seen)
    assert not may_be_sure(told, Glance(None, 2.0, 0.0))
