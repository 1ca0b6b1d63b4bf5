"""Distances between surface points where they are known."""

import numpy as np

from sherd.mesh.surface_points import closest_points, points_at_vertices
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.surface_distances import SurfaceDistances


def test_distances_are_great_circles_and_finer_than_vertices(sphere):
    mesh = sphere(5)
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(40, 2, 3))
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    directions[:10, 1] = directions[:10, 0] + 0.02 * directions[:10, 1]
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    first, second = (closest_points(mesh, directions[:, k]) for k in range(2))
    found = SurfaceDistances(mesh).between(first, second) * mesh.length
    angle = np.arccos(np.clip((directions[:, 0] * directions[:, 1]).sum(axis=1), -1, 1))
    assert np.abs(found - angle).max() < 0.05
    assert np.abs(found - angle)[:10].max() < 0.001
    assert (SurfaceDistances(mesh).between(first, first) == 0).all()


def test_another_component_is_as_far_as_the_farthest_point(sphere):
    mesh = sphere(3)
    vertices = np.concatenate([mesh.vertices, mesh.vertices + 4])
    pair = TriangleMesh(vertices, np.concatenate([mesh.faces, mesh.faces + mesh.vertex_count]))
    first = points_at_vertices(pair, [0, 0])
    second = points_at_vertices(pair, [3, mesh.vertex_count])  # the opposite pole; elsewhere
    opposite, elsewhere = SurfaceDistances(pair).between(first, second)
    assert elsewhere == opposite
