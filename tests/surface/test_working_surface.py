"""Working surfaces: long edges are split, dense meshes thinned, and the way back is linear."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from sherd.errors import InvalidMeshError
from sherd.mesh.geometry import edge_lengths
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.surface import working
from sherd.surface.working import (
    LONGEST_EDGE,
    MOST_VERTICES,
    canonical,
    joined,
    working_surface,
)

LINEAR = np.array([[1.0, -2.0], [0.5, 3.0], [2.0, 0.1]])


def at_unit_scale(mesh: TriangleMesh) -> TriangleMesh:
    return mesh.with_vertices(mesh.vertices / mesh.length)


def ball(subdivisions: int) -> TriangleMesh:
    made = trimesh.creation.icosphere(subdivisions=subdivisions)
    return at_unit_scale(TriangleMesh(made.vertices * [1.0, 1.2, 1.5], made.faces))


def even() -> TriangleMesh:
    """A sheet of 60 x 60 squares with edges below the longest that is left alone."""
    row, column = np.mgrid[:61, :61]
    vertices = np.stack([column.ravel(), row.ravel(), 0 * row.ravel()], axis=1) / 60.0
    first = (row[:-1, :-1] * 61 + column[:-1, :-1]).ravel()
    low = np.stack([first, first + 1, first + 62], axis=1)
    high = np.stack([first, first + 62, first + 61], axis=1)
    return TriangleMesh(vertices, np.concatenate([low, high]))


def test_an_even_mesh_is_its_own_working_mesh() -> None:
    mesh = even()
    surface = working_surface(mesh)
    assert surface.mesh is surface.placed is mesh
    assert surface.own_vertices is None
    values = np.arange(mesh.vertex_count)
    assert surface.at_own_vertices(values) is values
    assert surface.working_vertices(values) is values


def test_long_edges_are_split_where_they_are() -> None:
    mesh = ball(2)
    surface = working_surface(mesh)
    assert edge_lengths(mesh.vertices, mesh.faces).max() > 2 * LONGEST_EDGE
    assert edge_lengths(surface.mesh.vertices, surface.mesh.faces).max() <= LONGEST_EDGE
    assert surface.mesh.area == pytest.approx(mesh.area, rel=1e-12)
    # the given vertices come first, and where they were
    np.testing.assert_array_equal(surface.mesh.vertices[: mesh.vertex_count], mesh.vertices)
    assert surface.placed is mesh
    own = surface.working_vertices(np.arange(mesh.vertex_count))
    np.testing.assert_array_equal(own, np.arange(mesh.vertex_count))


def test_values_come_back_to_the_given_vertices() -> None:
    mesh = ball(2)
    surface = working_surface(mesh)
    values = surface.mesh.vertices @ LINEAR
    np.testing.assert_allclose(surface.at_own_vertices(values), mesh.vertices @ LINEAR, atol=1e-9)
    one = surface.at_own_vertices(values[:, 0])
    np.testing.assert_allclose(one, mesh.vertices @ LINEAR[:, 0], atol=1e-9)


def test_a_dense_mesh_is_thinned_and_linear_functions_come_back(monkeypatch) -> None:
    """Up to the height of the given vertices over the thinned mesh, below 0.001."""
    monkeypatch.setattr(working, "MOST_VERTICES", 3000)
    mesh = ball(5)
    surface = working_surface(mesh)
    assert mesh.vertex_count == 10242
    # 3,000 of the dense ones; edges that became too long are split again, up to a quarter more
    assert surface.mesh.vertex_count <= 1.25 * 3000 + 100
    assert surface.placed is mesh
    back = surface.at_own_vertices(surface.mesh.vertices @ LINEAR)
    assert np.abs(back - mesh.vertices @ LINEAR).max() < 0.005
    np.testing.assert_allclose(
        surface.own_vertices.interpolate(surface.mesh, surface.mesh.vertices @ LINEAR), back
    )
    near = surface.working_vertices(np.arange(mesh.vertex_count))
    gap = np.linalg.norm(surface.mesh.vertices[near] - mesh.vertices, axis=1)
    assert gap.max() < 2 * LONGEST_EDGE


def test_flat_dense_meshes_bring_linear_functions_back_exactly(monkeypatch) -> None:
    monkeypatch.setattr(working, "MOST_VERTICES", 2000)
    mesh = even()
    surface = working_surface(mesh)
    assert surface.mesh.vertex_count < 0.7 * mesh.vertex_count
    back = surface.at_own_vertices(surface.mesh.vertices @ LINEAR)
    np.testing.assert_allclose(back, mesh.vertices @ LINEAR, atol=1e-9)


def test_small_pieces_keep_at_least_a_tenth_of_the_vertices() -> None:
    """A hundredth of the area may have as many vertices as a tenth has."""
    mesh = even()
    small = mesh.with_vertices(mesh.vertices / 10)
    assert small.area == pytest.approx(0.01)
    limit = int(0.1 * MOST_VERTICES)
    assert working_surface(small).mesh.vertex_count == pytest.approx(limit, rel=0.05)


def test_sides_that_disagree_are_refused() -> None:
    mesh = even()
    some = np.random.default_rng(0).random(mesh.face_count) < 0.3
    faces = np.where(some[:, None], mesh.faces[:, ::-1], mesh.faces)
    with pytest.raises(InvalidMeshError, match="do not agree on which side is outside"):
        working_surface(TriangleMesh(mesh.vertices, faces))


def test_a_stored_working_mesh_is_joined_to_its_shape_as_when_it_was_made() -> None:
    mesh = ball(2)
    made = working_surface(mesh)
    again = joined(mesh, made.mesh)
    np.testing.assert_array_equal(again.own_vertices.faces, made.own_vertices.faces)
    np.testing.assert_array_equal(again.own_vertices.barycentric, made.own_vertices.barycentric)
    assert joined(mesh, TriangleMesh(mesh.vertices, mesh.faces)).own_vertices is None


def test_motions_and_units_of_the_file_disappear(egg: TriangleMesh) -> None:
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    turn[:, 0] *= np.sign(np.linalg.det(turn))
    moved = egg.with_vertices(7.0 * egg.vertices @ turn.T + 5.0)
    one, other = canonical(egg, egg.length), canonical(moved, moved.length)
    assert one.area == pytest.approx(1.0)
    assert np.abs(one.vertices - other.vertices).max() < 1e-9
    center = one.vertex_areas @ one.vertices
    assert np.abs(center).max() < 1e-12
    moments = one.vertices.T @ (one.vertex_areas[:, None] * one.vertices)
    assert np.abs(moments - np.diag(np.diag(moments))).max() < 1e-12
    mirror = TriangleMesh(egg.vertices * [-1, 1, 1], egg.faces[:, ::-1])
    assert np.abs(canonical(mirror, egg.length).vertices - one.vertices).max() > 0.01
