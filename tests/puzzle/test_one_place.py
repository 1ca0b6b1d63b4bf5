"""Several answers to one question: one place is right, or none."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from sherd.puzzle.pairwise import answer as module
from sherd.puzzle.pairwise.answer import Meeting, one_place


def answers(monkeypatch: pytest.MonkeyPatch, *given: tuple[float, int]) -> list[Meeting]:
    """Answers of chances at numbered places."""
    places = np.array([place for _, place in given])
    rivals = places[:, None] != places[None, :]
    monkeypatch.setattr(module, "are_rivals", lambda *_: rivals)
    nothing: Any = None
    return [Meeting(nothing, nothing, nothing, 1.0, chance, twin=False) for chance, _ in given]


def test_an_answer_without_a_rival_keeps_its_chance(monkeypatch) -> None:
    found = one_place(answers(monkeypatch, (0.9, 0), (0.3, 0)))
    assert [each.chance for each in found] == pytest.approx([0.9, 0.3])


def test_what_could_as_well_lie_elsewhere_is_not_sure(monkeypatch) -> None:
    found = one_place(answers(monkeypatch, (0.9, 0), (0.8, 1)))
    assert [each.chance for each in found] == pytest.approx([9 / 14, 4 / 14])


def test_a_rival_that_was_found_twice_counts_once(monkeypatch) -> None:
    found = one_place(answers(monkeypatch, (0.9, 0), (0.8, 1), (0.75, 1)))
    assert found[0].chance == pytest.approx(9 / 14)
    assert found[2].chance == pytest.approx(3 / 13)
