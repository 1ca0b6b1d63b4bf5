"""The chance of a join: what speaks against it counts, and a mirror image is never sure."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from sherd.correspondence.shared.judgment import MIRROR_CHANCE
from sherd.puzzle.pairwise import join_chance as module
from sherd.puzzle.pairwise.join_chance import ends_with_one, fits_a_twin, join_chance, join_features
from sherd.results.advice import SURE

# One, agreement, worth, rim inside, handedness, strain, leading, relief.
RIGHT = np.array([1.0, 0.72, 0.3, 0.0, 0.57, 0.07, 0.95, 0.4])
# Two thirds of another person, laid on a woman.
ANOTHER = np.array([1.0, 0.93, 0.29, 0.0, 0.19, 0.16, 0.74, 0.46])


def test_what_agrees_and_ends_where_a_piece_ends_is_sure() -> None:
    assert join_chance(RIGHT) > 0.9


@pytest.mark.parametrize(
    ("feature", "value"),
    [(1, 0.0), (2, -1.0), (3, 0.6), (4, -0.4), (5, 0.2), (6, 0.7), (7, 0.2)],
)
def test_each_thing_that_speaks_against_it_counts(feature: int, value: float) -> None:
    worse = RIGHT.copy()
    worse[feature] = value
    assert join_chance(worse) < join_chance(RIGHT)


@pytest.mark.parametrize(("feature", "value"), [(3, 0.9), (5, 0.35), (6, 0.7), (7, 0.15)])
def test_a_rim_inside_both_stretched_skin_other_places_or_another_relief_alone_refuse(
    feature: int, value: float
) -> None:
    worse = RIGHT.copy()
    worse[feature] = value
    assert join_chance(worse) < SURE


def test_another_individual_is_not_nearly_sure() -> None:
    """All but what is seen inside speaks for it as much as for one's own skin in another pose."""
    assert join_chance(ANOTHER) < 0.2
    own = ANOTHER.copy()
    own[6] = RIGHT[6]
    assert join_chance(own) > 0.5


def test_what_is_seen_inside_proves_nothing() -> None:
    """All places lead where a small part of something else lies within one of many."""
    best = RIGHT.copy()
    best[6] = 1.0
    assert join_chance(best) == pytest.approx(join_chance(RIGHT), abs=1e-3)


def test_what_fits_better_mirrored_is_never_sure() -> None:
    turned = RIGHT.copy()
    turned[4] = -0.3
    assert join_chance(turned) <= MIRROR_CHANCE


def test_what_would_be_sure_but_for_its_relief_lies_on_a_twin() -> None:
    turned = RIGHT.copy()
    turned[7] = 0.1
    assert fits_a_twin(turned)
    assert not fits_a_twin(RIGHT)
    foreign = turned.copy()
    foreign[5] = 0.35
    assert not fits_a_twin(foreign)


@pytest.mark.parametrize(
    ("shares", "rim"),
    [((0.99, 0.5), 0.2), ((0.5, 0.99), 0.2), ((0.99, 0.98), 0.0), ((0.6, 0.5), 0.0)],
)
def test_what_lies_within_a_larger_piece_has_no_border_to_tell_by(
    shares: tuple[float, float], rim: float, monkeypatch
) -> None:
    """Of two scans of one place all borders are where the other one has its border."""
    both: Any = shares
    for name, value in (("share_something", True), ("_inside_share", 0.0), ("_handedness", 0.5)):
        monkeypatch.setattr(module, name, lambda *_, value=value: value)
    monkeypatch.setattr(module, "_mean_share", lambda share, _: share)
    monkeypatch.setattr(module, "mean_strain", lambda *_: 0.1)
    monkeypatch.setattr(module, "alike_in_relief", lambda *_: 0.5)
    labelings: Any = SimpleNamespace(agreement=0.7, worth=0.3)
    assert join_features(labelings, both, both, None, 0)[3] == rim


@pytest.mark.parametrize(
    ("first_goes_on", "second_goes_on", "inside"),
    [(False, False, 0.0), (True, True, 0.375), (False, True, 0.25), (True, False, 0.125)],
)
def test_nothing_ends_inside_a_piece_that_does_not_go_on(
    first_goes_on: bool, second_goes_on: bool, inside: float, monkeypatch
) -> None:
    """If all of the second is shared, what is left out of the first within it is a hole."""
    rims = {"first": np.array([1, 1, 0, 0]), "second": np.array([0, 1, 0, 0])}
    going_on = {"first": first_goes_on, "second": second_goes_on}
    monkeypatch.setattr(module, "_goes_on", lambda piece, _: going_on[piece])
    monkeypatch.setattr(module, "_border", lambda *_: 1.0)
    monkeypatch.setattr(module, "_rim_inside", lambda piece, _: rims[piece])
    both: Any = ("second", "first")
    assert (ends_with_one(both, both) < 0.5) == (inside > module.ENDING)
    assert module._inside_share(both, both) == inside
