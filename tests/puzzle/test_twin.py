"""The mirror image of a limb that lies on its twin says that the limb belongs where it lies."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from sherd.puzzle.pairwise import twin as module
from sherd.puzzle.pairwise.answer import Meeting
from sherd.puzzle.pairwise.twin import apart_by_distances, beside_their_twins
from sherd.results.advice import SURE

# Of ten vertices of one area each the first four are where a limb is missing, the last four are its
# twin.
HOLE = np.arange(10) < 4
TWIN = np.arange(10) >= 6


@pytest.fixture(autouse=True)
def within(monkeypatch) -> None:
    """What lies on the twin lies within it; all else ends with the hole, as far from the rest."""
    monkeypatch.setattr(module, "lies_within", lambda _, placed: bool(placed[1].shared[-1]))
    monkeypatch.setattr(module, "ends_with_one", lambda *_: 0.99)
    monkeypatch.setattr(module, "_off_by_distances", lambda *_: 0.01)


def met(
    place: np.ndarray, chance: float, by_skin: float, *, twin: bool = False, leads: bool = False
) -> Meeting:
    mesh = SimpleNamespace(vertex_areas=np.ones(len(place)))
    questions: Any = (SimpleNamespace(full=SimpleNamespace(mesh=mesh)), None)
    placements: Any = (None, SimpleNamespace(shared=place))
    queries: Any = None
    return Meeting(
        questions, queries, placements, 1.0, chance, twin, by_skin, fitting=by_skin, leads=leads
    )


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


def test_what_its_skin_makes_likely_is_the_answer_where_nothing_else_is() -> None:
    """All that is seen may leave no chance to either."""
    skin = met(HOLE, 0.01, 0.6, twin=True)
    few = met(TWIN, 0.03, 0.0)
    found = beside_their_twins([few, skin], lambda: met(np.zeros(10, dtype=bool), 0.9, 0.0))
    assert found is skin


def test_who_is_sure_or_cannot_be_is_not_asked_again() -> None:
    sure, unlikely = met(HOLE, 0.9, 0.9), met(HOLE, 0.1, 0.05)
    assert beside_their_twins([sure], never) is sure
    assert beside_their_twins([unlikely], never) is unlikely


def test_that_a_rim_has_few_bumps_is_no_evidence_beside_a_twin() -> None:
    """Its skin but for reliefs counts."""
    limb = replace(met(HOLE, 0.01, 0.0), fitting=0.9)
    assert beside_their_twins([limb], lambda: met(TWIN, 0.9, 0.9)).chance >= SURE


def test_what_saves_most_beside_its_twin_is_as_sure_as_the_twin_is() -> None:
    """What it shares there may be bent beyond recognition."""
    limb = met(HOLE, 0.01, 0.0, leads=True)
    image = met(TWIN, 0.01, 0.94)
    found = beside_their_twins([limb], lambda: image)
    assert found.placements is limb.placements
    assert found.chance == pytest.approx(0.94 * 0.99)


def test_not_where_it_is_farther_from_the_rest_than_its_twin_is(monkeypatch) -> None:
    monkeypatch.setattr(module, "_off_by_distances", lambda *_: 0.06)
    limb = met(HOLE, 0.01, 0.0, leads=True)
    assert beside_their_twins([limb], lambda: met(TWIN, 0.9, 0.94)).chance == 0.01


def test_only_what_leads_and_ends_with_a_piece_is_believed_so(monkeypatch) -> None:
    limb, few = met(HOLE, 0.01, 0.0, leads=True), met(HOLE, 0.01, 0.0)
    assert beside_their_twins([few], never).chance == 0.01
    monkeypatch.setattr(module, "ends_with_one", lambda *_: 0.1)
    assert beside_their_twins([limb], never).chance == 0.01


def test_of_several_it_is_the_one_that_is_as_far_from_the_rest_as_its_twin(monkeypatch) -> None:
    """A limb saves more at another limb's place, which is at another place of the body."""
    wrong, limb = met(HOLE, 0.01, 0.0, leads=True), met(HOLE, 0.01, 0.0, leads=True)
    off = {id(wrong.placements): 0.043, id(limb.placements): 0.011}
    monkeypatch.setattr(module, "_off_by_distances", lambda each, _: off[id(each.placements)])
    found = beside_their_twins([wrong, limb], lambda: met(TWIN, 0.01, 0.94))
    assert found.placements is limb.placements
    assert beside_their_twins([wrong], lambda: met(TWIN, 0.01, 0.94)).chance == 0.01


@pytest.mark.parametrize("off", [0.03, 0.065])
def test_what_fits_is_not_believed_at_another_limbs_place(off, monkeypatch) -> None:
    monkeypatch.setattr(module, "_off_by_distances", lambda *_: off)
    assert beside_their_twins([met(HOLE, 0.01, 0.9)], lambda: met(TWIN, 0.9, 0.9)).chance == 0.01


def test_a_piece_that_reaches_over_the_middle_shares_that_with_its_twin(monkeypatch) -> None:
    """Half of a place in common is beside the other one, three quarters are on it."""
    image = met(np.arange(10) >= 4, 0.9, 0.9)
    # the image lies within as it reaches the last vertex; the others do not
    half, most = (
        met((np.arange(10) > 1) & (np.arange(10) < 6), 0.1, 0.9),
        met((np.arange(10) > 2) & (np.arange(10) < 7), 0.1, 0.9),
    )
    assert beside_their_twins([half], lambda: image).chance >= SURE
    assert beside_their_twins([most], lambda: image).chance == 0.1


@pytest.mark.parametrize(
    "image", [met(TWIN, 0.9, 0.4), met(HOLE, 0.9, 0.9), met(np.zeros(10, dtype=bool), 0.9, 0.0)]
)
def test_nor_where_the_mirror_image_does_not_surely_lie_there(image: Meeting) -> None:
    limb = met(HOLE, 0.01, 0.0, leads=True)
    assert beside_their_twins([limb], lambda: image).chance == 0.01


@pytest.mark.parametrize(("at", "alike"), [(1, True), (3, False)])
def test_both_sides_of_a_line_are_as_far_from_all_between(at: int, alike: bool) -> None:
    """Eleven places in a row; the two at either end do not count."""
    places = np.arange(11.0)
    between = np.abs(places[:, None] - places)
    weights = np.isin(places, (0, 1, 9, 10), invert=True).astype(float)
    found = apart_by_distances(between[[at]], between[[9]], weights)
    assert (found < 0.1) is alike


def test_what_does_not_hang_together_tells_nothing_of_distances() -> None:
    """Two rows of five places each; distances across are infinite, and give no warning."""
    places = np.arange(5.0)
    within, beyond = np.abs(places[:, None] - places), np.full((5, 5), np.inf)
    between = np.block([[within, beyond], [beyond, within]])
    weights = np.isin(np.arange(10), (0, 4, 5, 9), invert=True).astype(float)
    assert apart_by_distances(between[[0]], between[[4]], weights) == 0.0
    assert apart_by_distances(between[[0]], between[[9]], weights) == np.inf
