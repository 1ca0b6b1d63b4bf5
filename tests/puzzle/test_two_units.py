"""Two units: what is not sure in its own may be sure in that of the whole."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.puzzle.growing import two_units
from sherd.puzzle.growing.two_units import QuestionInTwoUnits
from sherd.puzzle.growing.union import Union

SQUARE = TriangleMesh(
    np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), [[0, 1, 2], [0, 2, 3]]
)
WHOLE = 1.5


@dataclass(frozen=True)
class Answer:
    """A meeting, as far as it is chosen by."""

    chance: float
    by_skin: float = 0.0
    handedness: float = 0.0
    recognized: float = 0.0
    at_large: float | None = None


@dataclass(frozen=True)
class Asked:
    """In one unit, and how often in full."""

    glance: Answer
    full: Answer | None
    unit: float = 1.0

    def at_a_glance(self) -> Answer:
        return self.glance

    def in_full(self) -> Answer:
        assert self.full is not None, "asked in full"
        return self.full


SURE, UNLIKELY = Answer(0.9), Answer(0.01)


def question(
    own: Asked, wide: Answer | None, whole: float = WHOLE, full: Answer | None = None
) -> QuestionInTwoUnits:
    """At large it is not asked at all if that is None, and in full only if it has that answer."""

    def asked_in(unit: float) -> Any:
        if not unit:
            return own
        assert wide is not None, "asked at large"
        return Asked(wide, wide if wide.chance >= 0.78 else full, unit)

    return QuestionInTwoUnits(Union.of_piece(SQUARE, 0), Union.of_piece(SQUARE, 1), whole, asked_in)


@pytest.fixture
def sharing(monkeypatch: pytest.MonkeyPatch) -> Callable[[float, float], None]:
    """Sets the share of the whole that both have, and how much of an earlier place is left out."""

    def shared(share: float, left: float) -> None:
        monkeypatch.setattr(two_units, "common_area", lambda join: share * WHOLE**2)
        monkeypatch.setattr(two_units, "left_out", lambda before, join: left)

    monkeypatch.setattr(
        two_units,
        "against",
        lambda join, rival: replace(join, met=Answer(join.met.chance - rival.met.chance)),
    )
    return shared


@pytest.mark.parametrize(
    ("full", "left", "sure"),
    [
        (Answer(0.05, by_skin=0.6), 0.0, True),
        (Answer(0.4, by_skin=0.05), 0.0, True),
        (Answer(0.05, by_skin=0.6), 1.0, False),
        (Answer(0.05, by_skin=0.05), 0.0, False),
        (Answer(0.8), 0.0, False),
    ],
)
def test_what_has_a_chance_in_its_own_unit_may_be_sure_at_large(sharing, full, left, sure) -> None:
    """At the same place, however little is shared."""
    sharing(0.05, left)
    found = question(Asked(UNLIKELY, full), SURE).in_full()
    assert replace(found, at_large=None) == (SURE if sure else full)


@pytest.mark.parametrize(
    ("before", "left", "chance"), [(0.01, 0.0, 0.9), (0.5, 0.0, 0.9), (0.5, 1.0, 0.4)]
)
def test_what_shares_much_of_the_whole_is_believed_at_large_at_a_glance(
    sharing, before, left, chance
) -> None:
    """Less so if something was likely at another place."""
    sharing(0.15, left)
    asked = question(Asked(Answer(before), UNLIKELY), SURE)
    assert asked.at_a_glance().chance == pytest.approx(chance)


def test_what_is_believed_at_a_glance_is_not_asked_in_full(sharing) -> None:
    sharing(0.15, 0.0)
    assert question(Asked(UNLIKELY, None), SURE).in_full() == SURE


@pytest.mark.parametrize(("share", "sure"), [(0.69, True), (0.71, False)])
def test_unless_it_is_most_of_the_larger_one(sharing, share, sure) -> None:
    """Its own unit would see that: a leg of a cow on that of a lion."""
    sharing(share / WHOLE**2, 0.0)
    assert question(Asked(UNLIKELY, UNLIKELY), SURE).at_a_glance() == (SURE if sure else UNLIKELY)


@pytest.mark.parametrize(("left", "sure"), [(0.0, True), (1.0, False)])
def test_what_has_a_chance_is_asked_at_large_in_full(sharing, left, sure) -> None:
    """If it is not sure there at a glance; a leg of a horse is so at a further place."""
    sharing(0.05, left)
    own = Answer(0.05, by_skin=0.14)
    asked = question(Asked(UNLIKELY, own), UNLIKELY, full=SURE)
    assert asked.in_full() == (SURE if sure else replace(own, at_large=0.9))


def test_what_is_not_sure_at_large_is_told_with_what_is_thought_there(sharing) -> None:
    """By its skin, if that is likelier; of what was asked in full only."""
    sharing(0.05, 0.0)
    own, wide = Answer(0.05, by_skin=0.5), Answer(0.1, by_skin=0.3)
    asked = question(Asked(UNLIKELY, own), UNLIKELY, full=wide)
    assert asked.in_full() == replace(own, at_large=0.3)
    assert question(Asked(own, own), None, 1.1).in_full().at_large is None


def test_what_fits_better_mirrored_is_not_believed_at_large(sharing) -> None:
    """Only if it does so clearly: right answers may fit a little better mirrored."""
    sharing(0.05, 0.0)
    own = Answer(0.05, by_skin=0.22)
    mirrored = Answer(0.81, handedness=-0.64)
    assert question(Asked(UNLIKELY, own), mirrored).in_full() == replace(own, at_large=0.81)
    right = Answer(0.98, handedness=-0.21)
    assert question(Asked(UNLIKELY, own), right).in_full() == right


@pytest.mark.parametrize(
    ("glance", "full", "wide"), [(0.3, 0.1, 0.2), (0.1, 0.3, 0.2), (0.1, 0.2, 0.3)]
)
def test_skin_that_is_recognized_in_any_unit_is_told(sharing, glance, full, wide) -> None:
    sharing(0.05, 0.0)
    own = Answer(0.05, recognized=full)
    found = question(
        Asked(replace(UNLIKELY, recognized=glance), own), replace(UNLIKELY, recognized=wide)
    ).in_full()
    assert found == replace(own, recognized=0.3)


def test_what_has_no_chance_is_asked_at_large_at_a_glance_only(sharing) -> None:
    sharing(0.15, 0.0)
    own = Answer(0.05, by_skin=0.05)
    assert question(Asked(UNLIKELY, own), UNLIKELY).in_full() == own


@pytest.mark.parametrize(("own", "whole"), [(SURE, WHOLE), (UNLIKELY, 1.1)])
def test_what_is_sure_or_hardly_smaller_than_the_whole_is_not_asked_at_large(own, whole) -> None:
    assert question(Asked(own, own), None, whole).in_full() == own
