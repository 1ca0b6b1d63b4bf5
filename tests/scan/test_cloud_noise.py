"""The noise of points is found, and lowered without moving what is clean."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial import Delaunay

from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.scan.cloud_noise import noise_of_points, smoothed_points
from sherd.shapes.creature import creature

SPHERE = trimesh.creation.icosphere(4)
BALL, FACES = SPHERE.vertices, SPHERE.faces


@pytest.mark.parametrize("noise", [0.01, 0.03])
def test_noise_of_a_ball_is_found(noise):
    points = BALL + np.random.default_rng(0).normal(size=BALL.shape) * noise
    assert noise_of_points(points, TriangleMesh(BALL, FACES)) == pytest.approx(noise, rel=0.1)


def test_a_clean_shape_seems_to_have_next_to_none():
    """Less than a hundredth of the spacing, for all its thin legs."""
    whole = creature(5000)
    spacing = np.sqrt(whole.area / whole.vertex_count)
    assert noise_of_points(whole.vertices, whole) < 0.01 * spacing
    assert noise_of_points(BALL[:4], TriangleMesh(BALL[:4], [[0, 1, 2]])) == 0.0


def test_smoothing_brings_points_back_to_the_surface():
    points = BALL + np.random.default_rng(1).normal(size=BALL.shape) * 0.03
    before = np.linalg.norm(points, axis=1) - 1
    after = np.linalg.norm(smoothed_points(points, 0.03), axis=1) - 1
    assert np.sqrt((after**2).mean()) < 0.5 * np.sqrt((before**2).mean())
    assert abs(after.mean()) < 0.005


def test_points_in_a_row_or_at_one_place_stay_finite():
    row = np.column_stack([np.arange(40.0), np.zeros(40), np.zeros(40)])
    for points in (row, np.ones((40, 3))):
        surface = TriangleMesh(points, [[0, 1, 2]])
        assert noise_of_points(points, surface) == pytest.approx(0.0, abs=1e-9)
        assert np.isfinite(smoothed_points(points, 0.1)).all()


def test_the_other_side_of_a_thin_plate_is_no_noise():
    """It holds half of the nearest points. As a piece of its own, or looking the other way."""
    rows, columns = np.divmod(np.arange(900), 30)
    low = np.column_stack([rows, columns, np.zeros(900)]).astype(float)
    points = np.concatenate([low, np.add(low, [0.5, 0.5, 1.0])])
    faces = Delaunay(low[:, :2]).simplices
    sheets = np.concatenate([faces, faces + 900])
    assert noise_of_points(points, TriangleMesh(points, sheets)) == pytest.approx(0.0, abs=1e-9)
    closed = np.concatenate([faces[:, ::-1], faces + 900, [[0, 29, 900]]])
    assert noise_of_points(points, TriangleMesh(points, closed)) == pytest.approx(0.0, abs=1e-9)
