"""Where a node is most like a label, against numpy on all of the table."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.arrays import Bools, Singles
from sherd.correspondence.labels.peak_kernel import most_alike, rotation_peaks

NODES, LABELS, SHIFTS = 20, 50, 16


@pytest.fixture
def similarity() -> Singles:
    values = np.random.default_rng(3).random((NODES, LABELS, SHIFTS)).astype(np.float32)
    values[4] = 0.5  # all alike
    return values


@pytest.fixture
def forbidden() -> Bools:
    found: Bools = np.random.default_rng(4).random((NODES, LABELS)) < 0.1
    found[7] = True
    found[7, :3] = False
    return found


def test_the_peak_is_the_largest_value(similarity: Singles) -> None:
    peaks, _ = rotation_peaks(similarity)
    np.testing.assert_array_equal(peaks, similarity.max(axis=2))


def test_the_rotation_lies_within_half_a_shift_of_the_peak(similarity: Singles) -> None:
    _, turns = rotation_peaks(similarity)
    shift = turns * SHIFTS / (2 * np.pi)
    assert np.abs(shift - similarity.argmax(axis=2)).max() <= 0.5 + 1e-6


def test_the_rotation_of_a_wave_is_found_between_shifts() -> None:
    at = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    shifts = 2 * np.pi * np.arange(SHIFTS) / SHIFTS
    wave = np.cos(shifts - at[:, None]).astype(np.float32)[None]
    _, turns = rotation_peaks(wave)
    off = np.angle(np.exp(1j * (turns[0] - at)))
    assert np.abs(off).max() < 0.01 * 2 * np.pi


@pytest.mark.parametrize("count", [1, 12, LABELS, 2 * LABELS])
def test_leaders_are_those_of_a_stable_sort(
    similarity: Singles, forbidden: Bools, count: int
) -> None:
    peaks, _ = rotation_peaks(similarity)
    order = np.where(forbidden, 2.0, -peaks).argsort(axis=1, kind="stable")
    np.testing.assert_array_equal(most_alike(peaks, forbidden, count), order[:, :count])
