"""Whether a surface was seen from one side, and from where."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.shapes import creature, cut_by_ball, whole
from sherd.shapes.camera_view import seen_by_camera
from sherd.surface.viewing import viewing_direction


@pytest.fixture(scope="module")
def body():
    full = creature(5000)
    return whole(creature(5000, pose="walk"), full)


@pytest.mark.parametrize("seed", range(4))
def test_the_viewer_of_a_camera_view_is_found(body, seed):
    frame = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    mesh = seen_by_camera(body, frame).mesh
    found = viewing_direction(mesh.vertex_normals, mesh.vertex_areas)
    assert found is not None
    assert np.degrees(np.arccos(found @ frame[:, 2])) < 15


def test_noisy_normals_of_a_view_do_not_matter(body):
    frame = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    mesh = seen_by_camera(body, frame).mesh
    normals = mesh.vertex_normals.copy()
    normals[::50] *= -1.0
    found = viewing_direction(normals, mesh.vertex_areas)
    assert found is not None
    assert np.degrees(np.arccos(found @ frame[:, 2])) < 25


def test_what_goes_around_a_limb_has_no_viewer(body):
    half = cut_by_ball(body, 0, 0.5).mesh
    for mesh in (body.mesh, half):
        assert viewing_direction(mesh.vertex_normals, mesh.vertex_areas) is None


def test_vertices_without_faces_are_not_asked():
    normals = np.array([[0.0, 0.0, 1.0], [0.0, 0.6, 0.8], [np.nan] * 3])
    found = viewing_direction(normals, np.array([1.0, 1.0, 0.0]))
    assert found is not None
    assert found[2] > 0.8


def test_a_closed_symmetric_surface_has_no_viewer():
    normals = np.concatenate([np.eye(3), -np.eye(3)])
    assert viewing_direction(normals, np.ones(6)) is None
