"""A picture on a plane that was shifted is shifted back; where nothing is seen nothing moves."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.optical_flow import Sight, flow_field, ranks, slopes

SHIFT = np.array([0.01, -0.006, 0.0])


@pytest.fixture(scope="module")
def plane() -> TriangleMesh:
    count = 41
    x, y = np.meshgrid(np.linspace(0, 1, count), np.linspace(0, 1, count), indexing="ij")
    vertices = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    k, j = np.meshgrid(np.arange(count - 1), np.arange(count - 1), indexing="ij")
    a = (count * k + j).ravel()
    b, c, d = a + 1, a + count, a + count + 1
    return TriangleMesh(
        vertices, np.concatenate([np.stack([a, c, d], -1), np.stack([a, d, b], -1)])
    )


def picture(at: np.ndarray) -> np.ndarray:
    return 0.3 * np.sin(9 * at[:, 0] + 2 * at[:, 1]) + 0.2 * np.cos(11 * at[:, 1])


def test_slopes_are_those_of_a_linear_field(plane) -> None:
    values = plane.vertices @ np.array([2.0, -3.0, 0.0])
    assert slopes(plane, values) == pytest.approx(np.tile([2.0, -3.0, 0.0], (len(values), 1)))


def test_ranks_run_from_low_to_high_among_those_that_count() -> None:
    values = np.array([5.0, 1.0, 3.0, 100.0])
    found = ranks(values, np.array([True, True, True, False]))
    assert (np.argsort(found[:3]) == [1, 2, 0]).all()
    assert np.abs(found).max() <= 0.5


def test_a_shifted_picture_is_shifted_back(plane) -> None:
    shifted = picture(plane.vertices + SHIFT) - picture(plane.vertices)
    sight = Sight(shifted, slopes(plane, picture(plane.vertices)))
    areas, still = plane.vertex_areas, np.zeros(plane.vertex_count)
    up, before = np.tile([0.0, 0.0, 1.0], (plane.vertex_count, 1)), np.zeros_like(plane.vertices)
    field = flow_field(plane, areas, areas, still, [sight], up, before, 0.05)
    assert np.linalg.norm(field - SHIFT, axis=1).mean() < 0.1 * np.linalg.norm(SHIFT)
    assert np.abs(field[:, 2]).max() < 1e-6


def test_what_sees_nothing_stays(plane) -> None:
    """Half of the plane is trusted; far in the other half, which would rather stay, it does."""
    shifted = picture(plane.vertices + SHIFT) - picture(plane.vertices)
    sight = Sight(shifted, slopes(plane, picture(plane.vertices)))
    trusted = plane.vertices[:, 0] < 0.5
    trust, still = plane.vertex_areas * trusted, plane.vertex_areas * ~trusted
    up, before = np.tile([0.0, 0.0, 1.0], (plane.vertex_count, 1)), np.zeros_like(plane.vertices)
    field = flow_field(plane, plane.vertex_areas, trust, still, [sight], up, before, 0.05)
    moved = np.linalg.norm(field, axis=1) / np.linalg.norm(SHIFT)
    assert moved[plane.vertices[:, 0] < 0.4].mean() > 0.8
    assert moved[plane.vertices[:, 0] > 0.8].max() < 0.05


def test_a_picture_without_slopes_moves_nothing(plane) -> None:
    sight = Sight(np.full(plane.vertex_count, 0.2), np.zeros_like(plane.vertices))
    areas, still = plane.vertex_areas, np.zeros(plane.vertex_count)
    up, before = np.tile([0.0, 0.0, 1.0], (plane.vertex_count, 1)), np.zeros_like(plane.vertices)
    field = flow_field(plane, areas, areas, still, [sight], up, before, 0.05)
    assert field == pytest.approx(0)
