"""Stiffness, areas, gradient: identities that hold to rounding, on an ugly mesh."""

import numpy as np
import pytest
from scipy import sparse

from sherd.mesh.geometry import face_areas
from sherd.spectral.operators import gradient, stiffness, voronoi_vertex_areas


@pytest.fixture(name="ugly")
def _ugly():
    """Random triangles: obtuse, slim, non-manifold."""
    rng = np.random.default_rng(5)
    vertices = rng.normal(size=(40, 3))
    faces = np.array([rng.choice(40, 3, replace=False) for _ in range(90)])
    return vertices, faces


def test_stiffness_is_the_squared_gradient(ugly):
    vertices, faces = ugly
    areas = sparse.diags_array(np.repeat(face_areas(vertices, faces), 3))
    slope = gradient(vertices, faces)
    weak = stiffness(vertices, faces)
    difference = abs(slope.T @ areas @ slope - weak).max()
    assert difference <= 1e-12 * abs(weak).max()
    assert abs(weak.sum(axis=1)).max() <= 1e-12 * abs(weak).max()


def test_gradient_of_a_linear_function_is_its_tangential_slope():
    vertices = np.random.default_rng(0).normal(size=(3, 3))
    slope = np.array([1.0, -2.0, 0.5])
    found = gradient(vertices, np.array([[0, 1, 2]])) @ (vertices @ slope)
    normal = np.cross(vertices[1] - vertices[0], vertices[2] - vertices[0])
    normal /= np.linalg.norm(normal)
    np.testing.assert_allclose(found, slope - (slope @ normal) * normal, atol=1e-12)


def test_voronoi_areas_sum_to_the_area_and_match_by_hand(ugly):
    vertices, faces = ugly
    total = face_areas(vertices, faces).sum()
    assert voronoi_vertex_areas(vertices, faces).sum() == pytest.approx(total, rel=1e-12)
    assert voronoi_vertex_areas(vertices, faces).min() >= 0
    # right isosceles triangle: the circumcenter is the middle of the long side
    right = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    found = voronoi_vertex_areas(right, np.array([[0, 1, 2]]))
    np.testing.assert_allclose(found, [0.25, 0.125, 0.125], atol=1e-15)


def test_a_face_without_area_changes_nothing():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0]])
    alone = stiffness(vertices, np.array([[0, 1, 2]]))
    both = stiffness(vertices, np.array([[0, 1, 2], [0, 1, 3]]))
    assert abs(alone - both).max() == 0
    assert np.isfinite(gradient(vertices, np.array([[0, 1, 3]])).toarray()).all()
