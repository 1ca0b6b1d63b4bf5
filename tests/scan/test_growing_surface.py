"""The surface that grows over Delaunay triangles: whole, two-sided, and not where none is."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from sherd.mesh import gluing
from sherd.mesh.point_cloud import PointCloud
from sherd.scan.surface_from_points import surface_from_points
from sherd.shapes.creature import creature


def euler(mesh):
    return len(np.unique(mesh.faces)) - len(mesh.edges) + mesh.face_count


def fibonacci_ball(count):
    place = np.arange(count) + 0.5
    height, around = 1 - 2 * place / count, np.pi * (1 + np.sqrt(5)) * place
    width = np.sqrt(1 - height**2)
    return np.stack([np.cos(around) * width, np.sin(around) * width, height], axis=1)


def test_a_ball_and_a_ring_are_closed_and_have_two_sides():
    torus = trimesh.creation.torus(1.0, 0.4, major_sections=60, minor_sections=24)
    for points, holes in ((fibonacci_ball(2000), 2), (torus.vertices, 0)):
        mesh = surface_from_points(PointCloud(points))
        assert len(mesh.boundary_vertices) == 0
        assert euler(mesh) == holes
        pairs = gluing.face_pairs(mesh.vertices, mesh.faces)
        assert not gluing.same_direction(mesh.faces, pairs).any()


def test_uneven_and_edged_surfaces_are_covered():
    """A cube of grids, and a ball ten times as dense on one side."""
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 21)] * 3, indexing="ij"), axis=-1)
    cube = grid.reshape(-1, 3)
    cube = cube[((cube == 0) | (cube == 1)).any(axis=1)]
    assert surface_from_points(PointCloud(cube)).area == pytest.approx(6.0, rel=0.01)
    dense, sparse = fibonacci_ball(6000), fibonacci_ball(600)
    points = np.concatenate([dense[dense[:, 0] > 0], sparse[sparse[:, 0] <= 0]])
    mesh = surface_from_points(PointCloud(points))
    assert mesh.area == pytest.approx(4 * np.pi, rel=0.02)
    assert len(np.unique(mesh.faces)) == len(points)


def test_two_sheets_that_nearly_touch_stay_apart():
    """Little farther apart than their points: away from the rim no face joins them."""
    rng = np.random.default_rng(0)
    rows, columns = np.divmod(np.arange(900), 30)
    sheets = []
    for height in (0.0, 1.0):
        shift = rng.uniform(-0.2, 0.2, (900, 2)) + 0.5 * height
        sheets.append(
            np.column_stack([rows + shift[:, 0], columns + shift[:, 1], 0 * rows + 1.5 * height])
        )
    mesh = surface_from_points(PointCloud(np.concatenate(sheets)))
    joined = (mesh.faces < 900).any(axis=1) & (mesh.faces >= 900).any(axis=1)
    inner = (mesh.vertices[mesh.faces[joined]][:, :, :2] > 1).all(axis=(1, 2))
    inner &= (mesh.vertices[mesh.faces[joined]][:, :, :2] < 28).all(axis=(1, 2))
    assert inner.sum() == 0
    assert mesh.face_areas[~joined].sum() == pytest.approx(2 * 29**2, rel=0.03)


@pytest.mark.parametrize("share", [0.01, 0.05])
def test_stray_points_make_no_surface(share):
    whole = creature(5000)
    rng = np.random.default_rng(3)
    low, high = whole.vertices.min(axis=0), whole.vertices.max(axis=0)
    strays = rng.uniform(low, high, (int(share * whole.vertex_count), 3))
    mesh = surface_from_points(PointCloud(np.concatenate([whole.vertices, strays])))
    stray = (mesh.faces >= whole.vertex_count).any(axis=1)
    assert mesh.face_areas[stray].sum() < 2 * share * whole.area
    assert mesh.face_areas[~stray].sum() == pytest.approx(whole.area, rel=0.02)


def test_noise_of_half_the_spacing_leaves_one_sheet():
    """The triangles of smoothed points; the vertices are the noisy ones."""
    whole = creature(12000)
    noise = 0.3 * np.sqrt(whole.area / whole.vertex_count)
    points = whole.vertices + np.random.default_rng(0).normal(size=(len(whole.vertices), 3)) * noise
    mesh = surface_from_points(PointCloud(points))
    np.testing.assert_array_equal(mesh.vertices, points)
    assert mesh.with_vertices(whole.vertices).area == pytest.approx(whole.area, rel=0.06)
    assert len(mesh.boundary_vertices) < 0.02 * mesh.vertex_count


def test_points_at_one_place_count_once():
    ball = fibonacci_ball(800)
    mesh = surface_from_points(PointCloud(np.concatenate([ball, ball[:100]])))
    assert mesh.vertex_count == 900
    assert len(np.unique(mesh.faces)) == 800
    assert euler(mesh) == 2
