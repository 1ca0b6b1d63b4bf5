"""Distortion of maps whose stretch is known."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.mesh.surface_points import SurfacePoints, closest_points
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.distortion import distortion, mean_at_vertices

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
FACES = np.array([[0, 1, 2], [0, 2, 3]])
UP = np.tile([0.0, 0.0, 1.0], (4, 1))


@pytest.fixture
def full() -> TriangleMesh:
    """A large square; parts are squares with a side of 1."""
    return TriangleMesh(10 * SQUARE - [1, 1, 0], FACES)


def laid(full: TriangleMesh, image: np.ndarray) -> SurfacePoints:
    points = closest_points(full, image)
    np.testing.assert_allclose(points.positions(full), image, atol=1e-12)
    return points


def stretch_of(
    part: TriangleMesh, full: TriangleMesh, points: SurfacePoints, scale: float = 1.0
) -> np.ndarray:
    return distortion(part, full, points, outward=UP, scale=scale).stretch


def preserved(
    part: TriangleMesh, full: TriangleMesh, points: SurfacePoints, outward: np.ndarray
) -> np.ndarray:
    return distortion(part, full, points, outward=outward, scale=1.0).preserved


def test_the_logarithm_of_a_known_stretch(full: TriangleMesh) -> None:
    """Half as long again along x, a fifth shorter along y."""
    part = TriangleMesh(SQUARE, FACES)
    points = laid(full, SQUARE * [1.5, 0.8, 1.0])
    stretch = stretch_of(part, full, points, 1.0)
    found = {tuple(edge): value for edge, value in zip(part.edges.tolist(), stretch, strict=True)}
    assert found[0, 1] == pytest.approx(np.log(1.5))
    assert found[2, 3] == pytest.approx(np.log(1.5))
    assert found[0, 3] == pytest.approx(np.log(0.8))
    assert found[0, 2] == pytest.approx(np.log(np.hypot(1.5, 0.8) / np.sqrt(2)))


def test_the_scale_that_was_found_is_no_stretch(full: TriangleMesh) -> None:
    part = TriangleMesh(SQUARE / 3.0, FACES)
    points = laid(full, SQUARE)
    np.testing.assert_allclose(stretch_of(part, full, points, 3.0), 0.0, atol=1e-12)
    np.testing.assert_allclose(stretch_of(part, full, points, 1.0), np.log(3.0))


def test_edges_that_become_a_point_have_a_finite_stretch(full: TriangleMesh) -> None:
    part = TriangleMesh(SQUARE, FACES)
    points = laid(full, np.tile([1.0, 1.0, 0.0], (4, 1)))
    stretch = stretch_of(part, full, points, 1.0)
    assert np.isfinite(stretch).all()
    assert stretch.max() < -10


def test_faces_are_turned_over_by_a_reflection_only(full: TriangleMesh) -> None:
    part = TriangleMesh(SQUARE, FACES)
    shift = np.array([2.0, 2.0, 0.0])
    straight, turned = laid(full, SQUARE + shift), laid(full, SQUARE * [-1, 1, 1] + shift)
    half_turn = laid(full, SQUARE * [-1, -1, 1] + shift)
    assert preserved(part, full, straight, UP).all()
    assert preserved(part, full, half_turn, UP).all()
    assert not preserved(part, full, turned, UP).any()
    assert preserved(part, full, turned, -UP).all()
    # one corner folded over the diagonal
    folded = SQUARE + shift
    folded[3] = folded[1]
    folded[3, 1] += 0.1
    assert preserved(part, full, laid(full, folded), UP).tolist() == [True, False]


def test_means_at_vertices() -> None:
    edges = np.array([[0, 1], [1, 2], [0, 2]])
    found = mean_at_vertices(np.array([1.0, 3.0, 8.0]), edges, 4)
    np.testing.assert_array_equal(found, [4.5, 2.0, 5.5, np.nan])
    faces = np.array([[0, 1, 2], [1, 2, 3]])
    found = mean_at_vertices(np.array([1.0, 5.0]), faces, 4)
    np.testing.assert_array_equal(found, [1.0, 3.0, 3.0, 5.0])
