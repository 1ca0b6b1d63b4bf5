"""The elastic surface: rigid motion is free, rotations are closest, answers lie on triangles."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from sherd.correspondence.elastic_kernel import fit_rotations, relax_positions, strains
from sherd.mesh.surface_finder import SurfaceFinder
from sherd.mesh.surface_points import closest_points
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes.truth import true_region
from sherd.spectral.operators import stiffness
from sherd.surface.elastic_surface import ElasticSurface


@pytest.fixture(scope="module")
def ball() -> TriangleMesh:
    return ball_of(3)


def ball_of(subdivisions: int) -> TriangleMesh:
    mesh = trimesh.creation.icosphere(subdivisions=subdivisions)
    x, y, z = mesh.vertices.T
    shape = TriangleMesh(mesh.vertices * (1 + 0.2 * x * y + 0.1 * z)[:, None], mesh.faces)
    return shape.with_vertices(shape.vertices / shape.length)


def springs(mesh: TriangleMesh) -> ElasticSurface:
    weak = stiffness(mesh.vertices, mesh.faces).tocsr()
    weak.setdiag(0.0)
    weak.eliminate_zeros()
    weights = np.maximum(-weak.data, 0.01)
    pointers, neighbors = weak.indptr.astype(np.int64), weak.indices.astype(np.int64)
    return ElasticSurface(pointers, neighbors, weights, mesh.vertices)


@pytest.mark.parametrize("degrees", [0.0, 33.0, 90.0, 179.9, 180.0])
def test_a_rigid_motion_is_found_at_every_angle_and_strains_nothing(
    ball: TriangleMesh, degrees: float
) -> None:
    turn = Rotation.from_rotvec(np.radians(degrees) * np.array([0.48, 0.6, 0.64])).as_matrix()
    moved = np.ascontiguousarray(ball.vertices @ turn.T + 2.0)
    rotations = fit_rotations(springs(ball), moved)
    assert np.abs(rotations - turn).max() < 1e-6
    assert strains(springs(ball), moved, rotations).max() < 1e-6


def test_stretch_is_reported_as_strain(ball: TriangleMesh) -> None:
    moved = 1.1 * ball.vertices
    rotations = fit_rotations(springs(ball), moved)
    assert np.allclose(strains(springs(ball), moved, rotations), 0.1, atol=1e-6)


def test_relaxing_solves_the_normal_equations(ball: TriangleMesh) -> None:
    rng = np.random.default_rng(0)
    count = ball.vertex_count
    elastic = springs(ball)
    pointers, neighbors, weights, rest = elastic
    rotations = np.tile(np.eye(3), (count, 1, 1))
    data = np.tile(0.3 * np.eye(3), (count, 1, 1))
    targets = ball.vertices + 0.02 * rng.normal(size=(count, 3))
    found = relax_positions(elastic, rotations, data, 0.3 * targets, targets, 1e-10, 2000)
    degree = np.add.reduceat(weights, pointers[:-1])

    def laplacian(x: np.ndarray) -> np.ndarray:
        return degree[:, None] * x - np.add.reduceat(weights[:, None] * x[neighbors], pointers[:-1])

    residual = laplacian(found - rest) + 0.3 * (found - targets)
    assert np.abs(residual).max() < 1e-8


def test_closest_points_agree_with_the_search_without_normals(ball: TriangleMesh) -> None:
    rng = np.random.default_rng(1)
    near = ball.vertices * (1 + 0.02 * rng.normal(size=(ball.vertex_count, 1)))
    found = SurfaceFinder(ball).closest(near, ball.vertex_normals).positions(ball)
    other = closest_points(ball, near).positions(ball)
    assert np.allclose(found, other, atol=1e-9)


def test_positions_that_move_are_followed(ball: TriangleMesh) -> None:
    """Some by a little, some by much, once and again."""
    rng = np.random.default_rng(3)
    finder = SurfaceFinder(ball)
    follower = finder.follower()
    here = ball.vertices.copy()
    for step in (0.0, 1e-3, 2e-3, 1e-3, 0.1, 1e-3):
        moving = rng.random(ball.vertex_count) < 0.7
        here[moving] += step * rng.normal(size=(int(moving.sum()), 3))
        up = here / np.linalg.norm(here, axis=1, keepdims=True)
        followed, found = follower.closest(here, up), finder.closest(here, up)
        off = followed.positions(ball) - found.positions(ball)
        assert np.abs(off).max() < 1e-12


def test_of_two_sheets_the_one_that_faces_the_right_way_is_taken() -> None:
    sheet = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    mesh = TriangleMesh(
        np.concatenate([sheet, sheet + np.array([0, 0, 0.01])]), [[0, 1, 2], [3, 5, 4]]
    )
    point, up = np.array([[0.2, 0.2, 0.004]]), np.array([[0.0, 0.0, 1.0]])
    assert SurfaceFinder(mesh).closest(point, up).faces[0] == 0
    assert SurfaceFinder(mesh).closest(point, -up).faces[0] == 1


@pytest.mark.parametrize("subdivisions", [2, 3, 4, 5])
def test_a_surface_of_any_fineness_covers_all_it_lies_on(subdivisions: int) -> None:
    """Each vertex by its own area, of a mesh that it is coarser or finer than."""
    mesh, other = ball_of(4), ball_of(subdivisions)
    areas = SurfaceFinder(mesh).covered_areas(other.vertices, other.faces)
    assert areas.sum() == pytest.approx(other.area)
    off = areas / mesh.vertex_areas - 1
    assert np.quantile(np.abs(off), 0.95) < 0.35


def test_a_cap_covers_its_own_vertices(ball: TriangleMesh) -> None:
    cap, kept = ball.submesh((ball.vertices[ball.faces, 2] > 0.05).all(axis=1))
    mask = SurfaceFinder(ball).covered_vertices(cap.vertices, cap.faces)
    truth = closest_points(ball, cap.vertices)
    assert (mask == true_region(ball, cap, truth)).mean() > 0.99
    assert mask[np.setdiff1d(kept, kept[cap.boundary_vertices])].all()
