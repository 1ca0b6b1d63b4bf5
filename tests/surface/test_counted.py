"""Whole multiples of a step: near, and exact the second time."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sherd.surface.counted import counts_of, numbers_of, round_to_counts


@given(st.lists(st.floats(-40.0, 40.0, width=32), min_size=1), st.booleans())
def test_numbers_come_back_within_half_a_step_and_then_exactly(numbers, with_infinite) -> None:
    values = np.array([*numbers, np.inf] if with_infinite else numbers, dtype=np.float32)
    once = values.copy()
    round_to_counts(once)
    _, step = counts_of(values)
    finite = np.isfinite(values)
    np.testing.assert_array_equal(np.isfinite(once), finite)
    assert np.abs(once[finite] - values[finite]).max() <= step / 2
    np.testing.assert_array_equal(numbers_of(*counts_of(once)), once)


def test_a_step_is_far_below_what_distances_are_known_to() -> None:
    _, step = counts_of(np.linspace(0.0, 3.0, 50, dtype=np.float32))
    assert step < 2e-4


@pytest.mark.parametrize("value", [0.0, np.inf])
def test_nothing_to_measure_by_is_no_trouble(value: float) -> None:
    values = np.full(3, value, dtype=np.float32)
    once = values.copy()
    round_to_counts(once)
    np.testing.assert_array_equal(once, values)
