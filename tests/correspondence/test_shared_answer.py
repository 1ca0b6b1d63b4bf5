"""Which of several places two shapes are laid at, and what is said of it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from sherd.correspondence.shared import answer as module
from sherd.correspondence.shared.answer import SharedAnswer, shared_answer
from sherd.correspondence.shared.likeness import Likeness
from sherd.results.advice import SURE

# What all evidence says of any further place.
FURTHER = 0.8


def labeling(name: str, *, chance: float, there: float, most: float = 0.995) -> Any:
    """What saves most or lies elsewhere, with its chances, as an answer and beside others."""
    return SimpleNamespace(
        name=name, own=chance, there=there, most=most, first_ratio=0.6, chance=(20.0, 20.0)
    )


@pytest.fixture
def asked(monkeypatch) -> list[str]:
    """Answers are labelings, which know their chances; the names of those that were laid."""
    laid: list[str] = []

    def lay(_: Any, each: Any, **__: Any) -> Any:
        laid.append(each.name)
        return each

    monkeypatch.setattr(module, "placed_together", lay)
    monkeypatch.setattr(module, "likeness_of_both", lambda *_: Likeness(0.02, 0.8, 0.8))
    monkeypatch.setattr(module, "most_open", lambda *_: 0.0)
    monkeypatch.setattr(module, "overlap_log_odds", lambda each, *_: each.own)
    monkeypatch.setattr(module, "overlap_chance", min)
    monkeypatch.setattr(module, "most_chance", lambda each, _: each.most)
    monkeypatch.setattr(module, "further_chance", lambda *_: FURTHER)
    monkeypatch.setattr(module, "form", lambda _: None)
    monkeypatch.setattr(module, "alike_in", lambda _, __, each: each.there)
    monkeypatch.setattr(module, "shared_area", lambda *_: 1.0)
    monkeypatch.setattr(module, "form_log_odds", lambda _, __, form, *___: form)
    monkeypatch.setattr(module, "place_chances", lambda _, by_form, __: np.array(by_form))
    monkeypatch.setattr(module, "are_rivals", lambda *_: None)
    return laid


def answered(monkeypatch: Any, first: Any, *others: Any) -> SharedAnswer:
    monkeypatch.setattr(module, "labelings_by_form", lambda *_: list(others))
    question = SimpleNamespace(part=SimpleNamespace(mesh=None, viewer=None))
    nothing: Any = (None, None)
    return shared_answer((question, question), nothing, first, nothing, strain=0.3, seed=0)


def test_a_sure_answer_is_asked_nothing_more(monkeypatch, asked) -> None:
    best = answered(
        monkeypatch,
        labeling("first", chance=0.9, there=0.1),
        labeling("other", chance=0.95, there=0.9),
    )
    assert asked == ["first"]
    assert best.chance == 0.9


def test_another_place_is_believed_as_far_as_both_chances_say(monkeypatch, asked) -> None:
    first = labeling("first", chance=0.3, there=0.2)
    other = labeling("other", chance=0.95, there=0.45)
    worse = labeling("worse", chance=0.99, there=0.4)
    best = answered(monkeypatch, first, worse, other)
    assert sorted(asked) == ["first", "other", "worse"]
    assert best.placements is other
    assert best.chance == 0.45
    assert answered(monkeypatch, first, labeling("dim", chance=0.4, there=0.9)).chance == 0.4


def test_another_place_needs_more_evidence_than_what_saves_most(monkeypatch, asked) -> None:
    """Who asks until the answer pleases has proved nothing."""
    first = labeling("first", chance=0.3, there=0.2)
    best = answered(monkeypatch, first, labeling("other", chance=0.99, there=0.99))
    assert best.chance == FURTHER > SURE
    monkeypatch.setattr(module, "further_chance", lambda *_: 0.4)
    best = answered(monkeypatch, first, labeling("other", chance=0.99, there=0.99))
    assert best.placements.name == "other"
    assert best.chance == 0.4


def test_what_saves_most_is_as_likely_as_its_place_beside_the_others(monkeypatch, asked) -> None:
    first = labeling("first", chance=0.3, there=0.9)
    best = answered(monkeypatch, first, labeling("other", chance=0.99, there=0.5))
    assert best.placements is first
    assert best.chance == 0.9
    assert answered(monkeypatch, first).chance == 0.9
    assert len(asked) == 3


def test_what_saves_most_is_not_believed_where_something_forbids_it(monkeypatch, asked) -> None:
    """Limbs of both sides are as alike in form as limbs of one, and no place is better."""
    first = labeling("first", chance=0.1, there=0.9, most=0.15)
    best = answered(monkeypatch, first, labeling("other", chance=0.99, there=0.5))
    assert best.placements is first
    assert best.chance == 0.15


def test_what_viewers_saw_is_preferred_and_never_good(monkeypatch, asked) -> None:
    """It begins where the others lie, so it shares their chance; it knows more."""
    monkeypatch.setattr(module, "are_views", lambda _: True)
    seen = iter([labeling("seen", chance=0.99, there=0.4), labeling("also", chance=0.9, there=0.1)])
    monkeypatch.setattr(module, "_labelings_of_viewers", lambda *_: next(seen))
    first = labeling("first", chance=0.3, there=0.2)
    best = answered(monkeypatch, first, labeling("other", chance=0.9, there=0.5))
    assert sorted(asked) == ["also", "first", "other", "seen"]
    assert best.placements.name == "seen"
    assert best.chance == 0.4
    seen = iter([labeling("seen", chance=0.99, there=0.9), labeling("also", chance=0.9, there=0.1)])
    best = answered(monkeypatch, first, labeling("other", chance=0.9, there=0.5))
    assert best.chance == module.VIEWED_CHANCE < SURE


def test_what_viewers_saw_gives_way_to_what_is_far_more_likely(monkeypatch, asked) -> None:
    monkeypatch.setattr(module, "are_views", lambda _: True)
    monkeypatch.setattr(
        module, "_labelings_of_viewers", lambda *_: labeling("seen", chance=0.99, there=0.2)
    )
    first = labeling("first", chance=0.3, there=0.5)
    best = answered(monkeypatch, first)
    assert asked == ["first", "seen"]
    assert best.placements is first
    assert best.chance == 0.3  # half of a view may be laid wrongly where its place is right
