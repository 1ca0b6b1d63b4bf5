"""Thresholds that meet the area, crumbs and pinholes, growth."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from sherd.energy.cleanup import clean_region, grow_region, pieces, threshold_to_area


def chain(count: int) -> sparse.csr_array:
    ones = np.ones(count - 1)
    return sparse.csr_array(sparse.diags_array([ones, ones], offsets=[-1, 1]))


def test_threshold_meets_the_area_and_breaks_ties_by_index() -> None:
    scores = np.array([0.5, 0.9, 0.5, 0.1])
    areas = np.array([1.0, 1.0, 1.0, 1.0])
    assert threshold_to_area(scores, areas, 2.0).tolist() == [True, True, False, False]
    assert threshold_to_area(scores, areas, 2.6).tolist() == [True, True, True, False]
    assert threshold_to_area(scores, areas, 0.01).sum() == 1
    assert threshold_to_area(scores, areas, 99.0).all()


def test_pieces() -> None:
    mask = np.array([True, True, False, True, False])
    labels = pieces(mask, chain(5))
    assert labels[0] == labels[1] != labels[3]
    assert labels[[2, 4]].tolist() == [-1, -1]
    assert pieces(np.zeros(5, dtype=bool), chain(5)).max() == -1


def test_crumbs_go_and_pinholes_close_at_the_same_area() -> None:
    count = 400
    scores = np.where(np.arange(count) < 100, 1.0, 0.1) + np.linspace(0.05, 0, count)
    scores[300] = 2.0  # a crumb of area 1, below 2 % of 100
    scores[50] = 0.0  # a pinhole
    mask = clean_region(scores, np.ones(count), 100.0, adjacency=chain(count))
    assert mask[:100].all()
    assert not mask[100:].any()


def test_two_large_pieces_stay() -> None:
    scores = np.zeros(100)
    scores[:20] = scores[60:80] = 1.0
    mask = clean_region(scores, np.ones(100), 40.0, adjacency=chain(100))
    np.testing.assert_array_equal(mask, scores > 0)


def test_a_region_of_crumbs_is_left_alone() -> None:
    scores = np.where(np.arange(300) % 3 == 0, 1.0, 0.0)
    mask = clean_region(scores, np.ones(300), 100.0, adjacency=chain(300))
    np.testing.assert_array_equal(mask, scores > 0)


def test_growth_takes_the_nearest_first() -> None:
    core = np.zeros(10, dtype=bool)
    core[4] = True
    distances = np.abs(np.arange(10) - 4).astype(float)
    distances[9] = np.inf
    grown = grow_region(core, distances, np.ones(10), 3.0)
    assert np.flatnonzero(grown).tolist() == [3, 4, 5]
    assert grow_region(core, distances, np.ones(10), 100.0).sum() == pytest.approx(10)
