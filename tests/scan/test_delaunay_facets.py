"""Delaunay facets and their empty balls, against what a library and plain geometry say."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import Delaunay, cKDTree

from sherd.scan.delaunay_facets import delaunay_facets


def all_facets(points):
    return delaunay_facets(points, np.ones(len(points)), np.inf)


def test_facets_are_those_of_the_tetrahedra_each_once():
    points = np.random.default_rng(0).random((60, 3))
    cells = np.sort(Delaunay(points).simplices, axis=1)
    wanted = {tuple(np.delete(cell, k).tolist()) for cell in cells for k in range(4)}
    found = [tuple(row) for row in all_facets(points).corners.tolist()]
    assert set(found) == wanted
    assert len(found) == len(wanted)


def test_balls_through_facets_are_empty_and_cannot_shrink():
    """No ball through three points is smaller than their circle; none we give holds a point."""
    points = np.random.default_rng(1).random((40, 3))
    facets = all_facets(points)
    tree = cKDTree(points)
    for corners, radius in zip(facets.corners, facets.radius, strict=True):
        origin = points[corners[0]]
        a, b = points[corners[1:]] - origin
        across = np.cross(a, b)
        arm = np.cross(b @ b * a - a @ a * b, -across) / (2 * across @ across)
        circle = np.linalg.norm(arm)
        assert radius >= circle * (1 - 1e-5)
        rise = np.sqrt(max(radius**2 - circle**2, 0.0)) * across / np.linalg.norm(across)
        gaps = [tree.query(origin + arm + way * rise)[0] for way in (-1, 1)]
        assert max(gaps) > radius * (1 - 1e-3)


def test_a_regular_tetrahedron_has_four_facets_with_the_radius_of_their_circles():
    points = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=float)
    facets = all_facets(points)
    assert len(facets.corners) == 4
    # side sqrt(8); circle of an equilateral triangle: side / sqrt(3)
    assert facets.radius == pytest.approx(np.sqrt(8 / 3), rel=1e-5)


def test_long_facets_and_slivers_are_left_out():
    points = np.random.default_rng(2).random((80, 3))
    reach = np.full(80, 0.2)
    kept = delaunay_facets(points, reach, 1.5)
    sides = np.linalg.norm(points[kept.corners] - points[np.roll(kept.corners, 1, 1)], axis=2)
    assert sides.max() <= 0.3
    row = np.column_stack([np.arange(5.0), np.zeros(5), np.zeros(5)])
    flat = all_facets(np.concatenate([row, [[2.0, 3.0, 0.0], [2.0, 0.0, 3.0]]]))
    assert not (flat.corners < 5).all(axis=1).any()
