"""At which of several places two shapes are laid, and what is said of it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from sherd.correspondence.confidence import MOST
from sherd.correspondence.shared import answer as module
from sherd.correspondence.shared.answer import LOOKED, SharedAnswer, shared_answer
from sherd.correspondence.shared.likeness import Likeness
from sherd.results.advice import SURE

# What all evidence says of any further place.
FURTHER = 0.8


def logit(chance: float) -> float:
    return float(np.log(chance / (1.0 - chance)))


class Labeled:
    """What saves most or lies elsewhere: what labels, a first look and what is laid say of it."""

    def __init__(
        self,
        name: str,
        *,
        chance: float,
        there: float,
        seen: float | None = None,
        looked: float | None = None,
        most: float = 0.995,
    ) -> None:
        self.name, self.chance, self.there, self.most = name, chance, there, most
        self.looked = there if looked is None else looked
        self.seen = self.looked if seen is None else seen

    def judged(self, there: float) -> SharedAnswer:
        """Whose chance beside no other is `there`."""
        return SharedAnswer(
            self, self.name, logit(there), 0.0, min(self.chance, self.most), self.most, False
        )


class Asked(module._Asked):
    """Knows what all labelings lead to, and what was done with them."""

    done: list[str]
    forms = (None, None)

    def seen(self, labelings: Any) -> Any:
        return labelings

    def expected(self, labelings: Any) -> float:
        return logit(labelings.seen)

    def looked_at(self, labelings: Any) -> SharedAnswer:
        self.done.append(f"look at {labelings.name}")
        return labelings.judged(labelings.looked)

    def answer(self, labelings: Any) -> SharedAnswer:
        self.done.append(f"lay {labelings.name}")
        return labelings.judged(labelings.there)

    def finished(self, look: SharedAnswer) -> SharedAnswer:
        return self.answer(look.labelings)


class Ask:
    """Asks about what saves most and other places; `done` is what was done."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.monkeypatch = monkeypatch
        self.done: list[str] = []
        monkeypatch.setattr(Asked, "done", self.done, raising=False)

    def __call__(self, first: Labeled, *others: Labeled) -> SharedAnswer:
        self.done.clear()
        self.monkeypatch.setattr(module, "labelings_by_form", lambda *_: list(others))
        question = SimpleNamespace(part=SimpleNamespace(mesh=None, viewer=None))
        nothing: Any = (None, None)
        return shared_answer((question, question), nothing, first, nothing, strain=0.3, seed=0)


@pytest.fixture
def ask(monkeypatch) -> Ask:
    monkeypatch.setattr(module, "_Asked", Asked)
    monkeypatch.setattr(module, "may_be_sure", lambda *_: True)
    monkeypatch.setattr(module, "further_chance", lambda *_: FURTHER)
    monkeypatch.setattr(module, "place_log_odds", lambda by_labels, _: by_labels)
    monkeypatch.setattr(module, "CLOSER_RISE", 0.0)
    monkeypatch.setattr(module, "are_rivals", lambda _, each: np.zeros((len(each), len(each))))
    monkeypatch.setattr(
        module, "place_chances", lambda odds, _, __: 1 / (1 + np.exp(-np.array(odds)))
    )
    return Ask(monkeypatch)


def test_a_sure_answer_is_asked_nothing_more(ask) -> None:
    best = ask(Labeled("first", chance=0.9, there=0.1), Labeled("other", chance=0.95, there=0.9))
    assert ask.done == ["lay first"]
    assert best.chance == 0.9


def test_what_cannot_be_sure_is_not_laid_where_another_place_is_likelier(ask, monkeypatch) -> None:
    monkeypatch.setattr(module, "may_be_sure", lambda *_: False)
    first = Labeled("first", chance=0.3, there=0.2)
    assert ask(first, Labeled("other", chance=0.95, there=0.45)).placements == "other"
    assert sorted(ask.done) == ["lay other", "look at first", "look at other"]
    assert ask(first, Labeled("other", chance=0.95, there=0.1)).placements == "first"
    assert ask.done.count("lay first") == 1
    assert "lay other" not in ask.done
    nothing = Labeled("nothing", chance=0.005, there=1e-300)
    assert ask(nothing).placements == "nothing"


def test_the_likeliest_by_their_labels_are_looked_at_and_one_of_them_is_laid(ask) -> None:
    first = Labeled("first", chance=0.3, there=0.2, seen=0.1)
    dim = [Labeled(f"dim {k}", chance=0.9, there=0.99, seen=0.02 * k) for k in range(1, 4)]
    bright = [
        Labeled(f"bright {k}", chance=0.9, there=0.3 + 0.1 * k, seen=0.9) for k in range(LOOKED)
    ]
    best = ask(first, *dim, *bright)
    assert best.placements == f"bright {LOOKED - 1}"
    looks = [each for each in ask.done if each.startswith("look")]
    assert sorted(looks) == [f"look at bright {k}" for k in range(LOOKED)]
    assert [each for each in ask.done if each.startswith("lay")] == [
        "lay first",
        f"lay bright {LOOKED - 1}",
    ]


@pytest.mark.parametrize("may_be", [True, False])
def test_where_no_place_is_likely_what_saves_most_stays(ask, monkeypatch, may_be) -> None:
    monkeypatch.setattr(module, "may_be_sure", lambda *_: may_be)
    first = Labeled("first", chance=0.3, there=0.01)
    assert ask(first, Labeled("other", chance=0.9, there=0.05)).placements == "first"
    assert "lay other" not in ask.done
    others = [Labeled(f"other {k}", chance=0.9, there=0.05) for k in range(LOOKED)]
    assert ask(first, *others).placements == "first"
    assert ask(first, Labeled("other", chance=0.9, there=0.15)).placements == "other"


def test_what_is_not_laid_is_a_rival_all_the_same(ask, monkeypatch) -> None:
    rivals: list[list[float]] = []

    def chances(odds: list[float], _: Any, elsewhere: list[float]) -> np.ndarray:
        rivals.append(elsewhere)
        return 1 / (1 + np.exp(-np.array(odds)))

    monkeypatch.setattr(module, "place_chances", chances)
    first = Labeled("first", chance=0.3, there=0.9)
    others = [Labeled(f"other {k}", chance=0.9, there=0.1 + 0.1 * k) for k in range(LOOKED + 2)]
    ask(first, *others)
    assert sorted(rivals[-1]) == pytest.approx([logit(each.there) for each in others])


def test_another_place_is_believed_as_far_as_both_chances_say(ask) -> None:
    first = Labeled("first", chance=0.3, there=0.2)
    other = Labeled("other", chance=0.95, there=0.45)
    best = ask(first, Labeled("worse", chance=0.99, there=0.4), other)
    assert best.placements == "other"
    assert best.chance == pytest.approx(0.45)
    assert ask(first, Labeled("dim", chance=0.4, there=0.9)).chance == 0.4


def test_another_place_needs_more_evidence_than_what_saves_most(ask, monkeypatch) -> None:
    """Who asks until the answer pleases has proved nothing."""
    first = Labeled("first", chance=0.3, there=0.2)
    best = ask(first, Labeled("other", chance=0.99, there=0.99))
    assert best.chance == FURTHER > SURE
    monkeypatch.setattr(module, "further_chance", lambda *_: 0.4)
    best = ask(first, Labeled("other", chance=0.99, there=0.99))
    assert best.placements == "other"
    assert best.chance == 0.4


def test_what_saves_most_is_as_likely_as_its_place_beside_the_others(ask) -> None:
    first = Labeled("first", chance=0.3, there=0.9)
    best = ask(first, Labeled("other", chance=0.99, there=0.5))
    assert best.placements == "first"
    assert best.chance == pytest.approx(0.9)
    assert ask(first).chance == pytest.approx(0.9)


def test_a_place_that_a_closer_look_disappoints_gives_way_to_what_is_laid(ask) -> None:
    first = Labeled("first", chance=0.3, there=0.4)
    other = Labeled("other", chance=0.9, there=0.1, looked=0.6)
    assert ask(first, other).placements == "first"
    assert ask.done[-1] == "lay other"


def test_what_saves_most_is_not_believed_where_something_forbids_it(ask) -> None:
    """Limbs of both sides are as alike in form as limbs of one, and no place is better."""
    first = Labeled("first", chance=0.1, there=0.9, most=0.15)
    best = ask(first, Labeled("other", chance=0.99, there=0.5))
    assert best.placements == "first"
    assert best.chance == 0.15


def test_what_viewers_saw_is_preferred_and_never_good(ask, monkeypatch) -> None:
    """It begins where the others lie, so it shares their chance; it knows more."""
    monkeypatch.setattr(module, "are_views", lambda _: True)
    monkeypatch.setattr(module, "may_be_sure", lambda *_: False)
    seen = iter([Labeled("seen", chance=0.99, there=0.4), Labeled("also", chance=0.9, there=0.1)])
    monkeypatch.setattr(module, "_labelings_of_viewers", lambda *_: next(seen))
    first = Labeled("first", chance=0.3, there=0.2)
    best = ask(first, Labeled("other", chance=0.9, there=0.5))
    laid = [each for each in ask.done if each.startswith("lay")]
    assert sorted(laid) == ["lay also", "lay first", "lay other", "lay seen"]
    assert best.placements == "seen"
    assert best.chance == pytest.approx(0.4)
    seen = iter([Labeled("seen", chance=0.99, there=0.9), Labeled("also", chance=0.9, there=0.1)])
    best = ask(first, Labeled("other", chance=0.9, there=0.5))
    assert best.chance == module.VIEWED_CHANCE < SURE


def test_what_viewers_saw_gives_way_to_what_is_far_more_likely(ask, monkeypatch) -> None:
    monkeypatch.setattr(module, "are_views", lambda _: True)
    monkeypatch.setattr(
        module, "_labelings_of_viewers", lambda *_: Labeled("seen", chance=0.99, there=0.2)
    )
    best = ask(Labeled("first", chance=0.3, there=0.5))
    assert ask.done == ["lay first", "lay seen"]
    assert best.placements == "first"
    assert best.chance == 0.3  # half of a view may be laid wrongly where its place is right


def judged(monkeypatch, *, alike: float = 0.5, area: float = 0.4, own: float = 1.0) -> SharedAnswer:
    """An answer of which all else speaks for it."""
    first = SimpleNamespace(
        agreement=0.9, lack=0.05, worth=0.3, first_ratio=0.3, chance=(20.0, 20.0)
    )
    nothing: Any = (None, None)
    asked = module._Asked(nothing, nothing, first, nothing, 0.3, 0)
    monkeypatch.setattr(module._Asked, "forms", nothing)
    for name, value in (
        ("likeness_of_both", Likeness(0.02, 0.8, 0.8)),
        ("most_open", 0.3),
        ("alike_in", alike),
        ("shared_area", area),
        ("most_by_accident", own),
    ):
        monkeypatch.setattr(module, name, lambda *_, value=value: value)
    return asked._judged(first, nothing)


def test_form_proves_more_on_a_large_area_than_on_a_small_one(monkeypatch) -> None:
    """Half as much on four times the area proves as much."""

    def by_form(alike: float, area: float) -> float:
        return judged(monkeypatch, alike=alike, area=area).by_form

    assert by_form(0.3, 0.4) == pytest.approx(by_form(0.6, 0.1))
    assert by_form(0.6, 0.4) > by_form(0.6, 0.1) + 0.5


def test_what_is_alike_by_accident_is_not_sure_at_its_place_either(monkeypatch) -> None:
    """On skin without bumps all else may speak for it."""
    answer = judged(monkeypatch, own=0.45)
    assert max(answer.chance, answer.most) <= 0.45
    sure = judged(monkeypatch)
    assert sure.most == MOST
    assert answer.log_odds == sure.log_odds
