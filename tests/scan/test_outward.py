"""Patches that look inward are found by what can be seen of them, and turned over."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from sherd.mesh.point_cloud import PointCloud
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.scan.outward import seen_from_outside, turned_outward
from sherd.scan.surface_from_points import surface_from_points
from sherd.shapes.creature import creature

SPHERE = trimesh.creation.icosphere(4)


def test_a_ball_is_seen_from_in_front_and_what_lies_in_it_is_not_seen():
    points = np.concatenate([SPHERE.vertices, 0.5 * SPHERE.vertices])
    normals = np.concatenate([SPHERE.vertices, -SPHERE.vertices])
    outside = seen_from_outside(points, normals)
    count = len(SPHERE.vertices)
    assert np.quantile(outside[:count], 0.05) > 0.8  # a few points are not looked at
    assert np.median(outside[:count]) == pytest.approx(1.0, abs=0.1)
    assert np.quantile(np.abs(outside[count:]), 0.99) < 0.1
    np.testing.assert_allclose(seen_from_outside(points, -normals), -outside)


@pytest.mark.parametrize("scene", ["half turned over", "all turned over", "right"])
def test_faces_of_an_animal_look_outward_again(scene):
    animal = creature(5000)
    middle = animal.vertices[animal.faces].mean(axis=1)
    inward = {"right": middle[:, 0] > np.inf, "all turned over": middle[:, 0] < np.inf}.get(
        scene, middle[:, 0] > np.median(middle[:, 0])
    )
    faces = np.where(inward[:, None], animal.faces[:, ::-1], animal.faces)
    mixed = TriangleMesh(animal.vertices, faces)
    outside = seen_from_outside(mixed.vertices, mixed.vertex_normals)
    result = TriangleMesh(mixed.vertices, turned_outward(mixed.vertices, faces, outside))
    agree = (result.face_normals * animal.vertex_normals[result.faces[:, 0]]).sum(axis=1) > 0
    assert result.face_areas[agree].sum() > 0.98 * animal.area
    assert result.face_areas[~agree].sum() < 0.01 * animal.area


def test_points_without_normals_become_a_surface_that_looks_outward():
    animal = creature(5000, pose="sit")
    mesh = surface_from_points(PointCloud(animal.vertices))
    assert (mesh.vertex_normals * animal.vertex_normals).sum(axis=1).mean() > 0.97
    # coordinates whose products overflow
    far = surface_from_points(PointCloud(2.0**200 * animal.vertices))
    np.testing.assert_array_equal(far.faces, mesh.faces)


def test_points_in_a_plane_are_seen_from_both_sides_alike():
    rows, columns = np.divmod(np.arange(100), 10)
    flat = np.column_stack([rows, columns, np.zeros(100)]).astype(float)
    outside = seen_from_outside(flat, np.tile([0.0, 0.0, 1.0], (100, 1)))
    assert np.abs(outside).max() < 0.05  # a ball's are 1
