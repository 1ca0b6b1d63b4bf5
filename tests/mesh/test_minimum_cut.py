"""The minimum cut has the least energy of all choices, and the scale of costs does not matter."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from sherd.mesh.minimum_cut import minimum_cut


def energy(x, extra, pairs, prices, back) -> float:
    first, second = x[pairs[0]], x[pairs[1]]
    seams = prices[~first & second].sum() + back[first & ~second].sum()
    return float(extra[x].sum() + seams)


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
def test_no_choice_is_cheaper(seed: int, scale: float) -> None:
    rng = np.random.default_rng(seed)
    pairs = tuple(np.triu_indices(7, 1))
    extra = rng.normal(size=7) * scale
    prices, back = rng.random((2, 21)) * (rng.random(21) < 0.5) * scale
    found = energy(minimum_cut(extra, pairs, prices, back), extra, pairs, prices, back)
    choices = np.array(list(product([False, True], repeat=7)))
    least = min(energy(x, extra, pairs, prices, back) for x in choices)
    assert found == pytest.approx(least, abs=1e-7 * scale)


def test_back_is_the_same_price_if_not_given_and_ties_are_ones() -> None:
    pairs = (np.array([0]), np.array([1]))
    extra, price = np.array([-1.0, 0.4]), np.array([0.5])
    assert minimum_cut(extra, pairs, price).tolist() == [True, True]
    assert minimum_cut(extra, pairs, price, np.zeros(1)).tolist() == [True, False]
    assert minimum_cut(np.zeros(2), pairs, price).all()
