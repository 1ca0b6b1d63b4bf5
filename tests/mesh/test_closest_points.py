"""Closest points against a dense sampling of every triangle, and on triangles without area."""

from __future__ import annotations

import numpy as np

from sherd.mesh.surface_points import closest_points
from sherd.mesh.triangle_mesh import TriangleMesh


def sampled_distance(corners, position):
    steps = np.linspace(0, 1, 161)
    v, w = (grid.ravel() for grid in np.meshgrid(steps, steps))
    inside = v + w <= 1 + 1e-12
    weights = np.stack([1 - v - w, v, w], axis=1)[inside]
    return np.linalg.norm(weights @ corners - position, axis=1).min()


def test_every_region_of_a_triangle():
    """Positions around one triangle: over its face, beside its edges, beyond its corners."""
    rng = np.random.default_rng(1)
    for _ in range(5):
        mesh = TriangleMesh(rng.normal(size=(3, 3)), [[0, 1, 2]])
        positions = 2 * rng.normal(size=(40, 3))
        found = closest_points(mesh, positions).positions(mesh)
        distance = np.linalg.norm(found - positions, axis=1)
        sampled = [sampled_distance(mesh.vertices, place) for place in positions]
        assert (distance <= np.array(sampled) + 1e-9).all()
        np.testing.assert_allclose(distance, sampled, atol=0.05)


def test_of_large_and_small_triangles_the_closest_is_found():
    """Though most are ruled out by the balls around them."""
    rng = np.random.default_rng(4)
    corners = rng.normal(size=(30, 1, 3)) + rng.normal(size=(30, 3, 3)) * 10.0 ** rng.uniform(
        -3, 1, size=(30, 1, 1)
    )
    mesh = TriangleMesh(corners.reshape(-1, 3), np.arange(90).reshape(-1, 3))
    positions = 2 * rng.normal(size=(200, 3))
    found = closest_points(mesh, positions, neighbors=30)
    alone = [
        np.linalg.norm(
            closest_points(TriangleMesh(each, [[0, 1, 2]]), positions).positions(
                TriangleMesh(each, [[0, 1, 2]])
            )
            - positions,
            axis=1,
        )
        for each in corners
    ]
    distance = np.linalg.norm(found.positions(mesh) - positions, axis=1)
    np.testing.assert_allclose(distance, np.min(alone, axis=0), rtol=1e-12)


def test_triangles_without_area_have_closest_points_too():
    rng = np.random.default_rng(2)
    line = np.outer(rng.random(3), rng.normal(size=3))
    for corners in (np.zeros((3, 3)), line, line * 1e-8, line[[0, 0, 1]]):
        mesh = TriangleMesh(corners, [[0, 1, 2]])
        positions = rng.normal(size=(50, 3))
        found = closest_points(mesh, positions)
        distance = np.linalg.norm(found.positions(mesh) - positions, axis=1)
        best = [sampled_distance(corners, place) for place in positions]
        np.testing.assert_allclose(distance, best, atol=0.02)


def test_far_positions_are_answered():
    mesh = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    found = closest_points(mesh, [[1e12, 0, 0], [-1e12, -1e12, 1e12]])
    np.testing.assert_allclose(found.barycentric, [[0, 1, 0], [1, 0, 0]], atol=1e-3)
