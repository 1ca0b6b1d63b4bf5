"""The region of a known map meets the area, keeps real holes and closes single vertices."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.energy.cleanup import raised_to_area
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.region import coverage
from sherd.region.coverage import covered_region, smoothed
from sherd.shapes.creature import creature


@pytest.fixture(scope="module")
def animal() -> TriangleMesh:
    mesh = creature(5000)
    return mesh.with_vertices(mesh.vertices / mesh.length)


def test_front_with_a_hole(animal) -> None:
    x = animal.vertices[:, 0]
    covered = x > np.median(x)
    center = animal.vertices[np.argmax(x)]
    hole = np.linalg.norm(animal.vertices - center, axis=1) < 0.08
    covered &= ~hole
    area = float(animal.vertex_areas @ covered)
    flickering = covered.copy()
    inner = np.flatnonzero(covered & (x > np.quantile(x, 0.7)))[::29]
    flickering[inner] = False  # single vertices that sampling missed
    membership, mask = covered_region(animal, flickering, area)
    assert animal.vertex_areas @ membership == pytest.approx(area, rel=1e-6)
    assert animal.vertex_areas @ mask == pytest.approx(area, rel=0.01)
    assert mask[inner].mean() > 0.9
    assert mask[hole].mean() < 0.1
    wrong = animal.vertex_areas @ (mask ^ covered)
    assert wrong < 0.03 * area


def test_away_from_its_border_a_region_is_not_solved(animal, monkeypatch) -> None:
    """Nothing is lost by it."""
    x = animal.vertices[:, 0]
    covered = x > np.median(x)
    near = smoothed(animal, covered)
    monkeypatch.setattr(coverage, "BAND", 1e6)
    everywhere = smoothed(animal, covered)
    np.testing.assert_allclose(near, everywhere, atol=1e-5)
    assert 0.1 < ((near > 0.01) & (near < 0.99)).sum() / (near != covered).sum() < 1.0


@pytest.mark.parametrize("all_of_it", [False, True])
def test_a_region_without_border_stays_what_it_is(animal, all_of_it: bool) -> None:
    covered = np.full(animal.vertex_count, all_of_it)
    np.testing.assert_array_equal(smoothed(animal, covered), covered)


def test_power_meets_the_area() -> None:
    values, areas = np.array([0.0, 0.3, 0.8, 1.0]), np.ones(4)
    for area in (1.2, 2.1, 2.9):
        raised = raised_to_area(values, areas, area)
        assert raised.sum() == pytest.approx(area, abs=1e-6)
        assert (np.diff(raised) >= 0).all()
