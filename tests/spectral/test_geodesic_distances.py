"""Geodesic distances on surfaces where they are known, and on damaged ones."""

import numpy as np
import pytest

from sherd.errors import InvalidMeshError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.geodesics import Geodesics

TWO_TRIANGLES = [[0, 1, 2], [3, 4, 5]]


def test_sphere_distances_are_angles(sphere):
    mesh = sphere(5)
    distance = Geodesics(mesh).distances_from([0, 77])
    for row, source in enumerate((0, 77)):
        angle = np.arccos(np.clip(mesh.vertices @ mesh.vertices[source], -1, 1))
        # the heat method is about 1 % short of the mean distance, pi / 2
        assert np.abs(distance[row] - angle).mean() < 0.02
        assert distance[row, source] == 0


def test_distance_scales_and_a_set_is_the_nearest_of_its_members(sphere):
    mesh = sphere(4)
    geodesics = Geodesics(mesh)
    single = geodesics.distances_from([3, 50])
    large = Geodesics(mesh.with_vertices(1000 * mesh.vertices)).distances_from([3, 50])
    np.testing.assert_allclose(large, 1000 * single, rtol=1e-6, atol=1e-3)
    both = geodesics.distances_to_set([3, 50])
    assert np.abs(both - single.min(axis=0)).mean() < 0.03
    assert np.isinf(geodesics.distances_to_set([])).all()


def test_other_components_and_lone_vertices_are_infinitely_far(sphere):
    mesh = sphere(3)
    count = mesh.vertex_count
    vertices = np.concatenate([mesh.vertices, mesh.vertices + 4, [[9.0, 9, 9]]])
    pair = TriangleMesh(vertices, np.concatenate([mesh.faces, mesh.faces + count]))
    geodesics = Geodesics(pair)
    distance = geodesics.distances_from(5)[0]
    assert np.isfinite(distance[:count]).all()
    assert np.isinf(distance[count:]).all()
    alone = geodesics.distances_from(2 * count)[0]
    assert alone[2 * count] == 0
    assert np.isinf(alone[: 2 * count]).all()
    assert len(geodesics.used_vertices) == 2 * count


def test_non_manifold_vertices_and_edges_do_not_fail(sphere):
    mesh = sphere(3)
    count = mesh.vertex_count
    # two spheres that share vertex 0, and a fin on an edge
    faces = np.concatenate([mesh.faces, np.where(mesh.faces == 0, 0, mesh.faces + count)])
    vertices = np.concatenate([mesh.vertices, mesh.vertices * [-1, 1, -1] + [2, 0, 0], [[0, 0, 3]]])
    a, b, _ = faces[0]
    touching = TriangleMesh(vertices, np.concatenate([faces, [[a, b, 2 * count]]]))
    distance = Geodesics(touching).distances_from(3)[0]
    reached = np.unique(touching.faces)
    assert np.isfinite(distance[reached]).all()
    far = count + np.flatnonzero(mesh.vertices[:, 0] < -0.999)
    assert distance[far] == pytest.approx(2 * np.pi, rel=0.1)


def test_degenerate_faces_do_not_fail(sphere):
    mesh = sphere(3)
    flat = TriangleMesh(mesh.vertices, np.concatenate([mesh.faces, [[0, 0, 1], [4, 4, 4]]]))
    angle = np.arccos(np.clip(mesh.vertices @ mesh.vertices[7], -1, 1))
    distance = Geodesics(flat).distances_from(7)[0]
    assert np.abs(distance - angle).mean() < 0.1


def test_a_source_outside_is_refused():
    mesh = TriangleMesh(np.eye(6, 3), TWO_TRIANGLES)
    with pytest.raises(InvalidMeshError, match="source vertex 6"):
        Geodesics(mesh).distances_from(6)
