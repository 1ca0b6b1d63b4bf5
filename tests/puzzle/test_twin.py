"""The mirror image of a limb that lies on its twin says that the limb belongs where it lies."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from sherd.puzzle.growing import twin as module
from sherd.puzzle.growing.answer import Meeting
from sherd.puzzle.growing.twin import beside_their_twins
from sherd.results.advice import SURE

# Of ten vertices of one area each the first four are where a limb is missing, the last four are its
# twin.
HOLE = np.arange(10) < 4
TWIN = np.arange(10) >= 6


@pytest.fixture(autouse=True)
def within(monkeypatch) -> None:
    """What lies on the twin lies within it."""
    monkeypatch.setattr(module, "lies_within", lambda _, placed: bool(placed[1].shared[-1]))


def met(place: np.ndarray, chance: float, by_skin: float, *, twin: bool = False) -> Meeting:
    mesh = SimpleNamespace(vertex_areas=np.ones(len(place)))
    questions: Any = (SimpleNamespace(full=SimpleNamespace(mesh=mesh)), None)
    placements: Any = (None, SimpleNamespace(shared=place))
    queries: Any = None
    return Meeting(questions, queries, placements, chance, twin, by_skin)


def never() -> Meeting:
    raise AssertionError("asked the mirror image")


def test_a_limb_beside_its_twin_is_sure() -> None:
    limb, wrong = met(HOLE, 0.01, 0.3), met(TWIN, 0.2, 0.2, twin=True)
    found = beside_their_twins([wrong, limb], lambda: met(TWIN, 0.9, 0.9))
    assert found.placements is limb.placements
    assert found.chance == pytest.approx(0.3 / 0.7 * 10 / (1 + 0.3 / 0.7 * 10))
    assert found.chance >= SURE


@pytest.mark.parametrize(
    "image", [met(TWIN, 0.9, 0.4), met(HOLE, 0.9, 0.9), met(np.zeros(10, dtype=bool), 0.9, 0.0)]
)
def test_without_a_sure_twin_elsewhere_it_stays_as_it_was(image: Meeting) -> None:
    """A mirror image that is hardly alike, or lies where the limb does, says nothing."""
    limb = met(HOLE, 0.1, 0.3)
    assert beside_their_twins([limb], lambda: image).chance == 0.1


def test_what_lies_on_its_twin_is_not_believed_for_that() -> None:
    wrong = met(TWIN, 0.2, 0.9, twin=True)
    assert beside_their_twins([wrong], never).chance == 0.2


def test_who_is_sure_or_cannot_be_is_not_asked_again() -> None:
    sure, unlikely = met(HOLE, 0.9, 0.9), met(HOLE, 0.1, 0.05)
    assert beside_their_twins([sure], never) is sure
    assert beside_their_twins([unlikely], never) is unlikely
