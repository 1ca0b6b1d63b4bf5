"""Chances of a fit: what lowers them."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.fitting.chance import chances

BEYOND = np.array([0.0, 0.0, 0.1, 0.4, np.inf])
CONFIDENCE = np.array([1.0, 0.5, 0.0, 0.0, 0.0])


def of(*, near: float = 0.02, placed: float = 1.0, grown: float = 0.0) -> np.ndarray:
    return chances(BEYOND, CONFIDENCE, near=near, placed=placed, grown=grown)


def test_chances_fall_with_confidence_and_beyond_the_cut() -> None:
    found = of()
    assert (np.diff(found) < 0).all()
    assert found[0] > 0.95
    assert found[-1] == 0
    assert (of(near=0.05)[:-1] > found[:-1]).all()


def test_nothing_is_surer_than_that_the_piece_belongs_there() -> None:
    assert of(placed=0.3) == pytest.approx(0.3 * of())


def test_another_individual_is_promised_less() -> None:
    assert (of(grown=0.08)[:-1] < of()[:-1]).all()
    assert np.array_equal(of(grown=0.08), of(grown=-0.08))
    assert of(grown=0.08)[0] < 0.7
