"""TriangleMesh and the door: measures by hand, frozen arrays, messages that name the element."""

from __future__ import annotations

import dataclasses
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sherd.errors import InvalidMeshError
from sherd.mesh import geometry, topology
from sherd.mesh.surface_points import SurfacePoints, closest_points, points_at_vertices
from sherd.mesh.triangle_mesh import TriangleMesh

SQUARE = np.array([[0.0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]])
HALVES = np.array([[0, 1, 2], [0, 2, 3]])


def square(**fields):
    return TriangleMesh(SQUARE, HALVES, fields=fields, name="square")


def test_measures_by_hand():
    mesh = square()
    assert mesh.face_areas.tolist() == [2, 2]
    assert (mesh.area, mesh.length) == (4, 2)
    assert mesh.vertex_areas == pytest.approx([4 / 3, 2 / 3, 4 / 3, 2 / 3])
    assert mesh.face_normals.tolist() == [[0, 0, 1], [0, 0, 1]]
    assert mesh.vertex_normals.tolist() == [[0, 0, 1]] * 4
    assert mesh.edges.tolist() == [[0, 1], [0, 2], [0, 3], [1, 2], [2, 3]]
    assert mesh.mean_edge_length == pytest.approx((4 * 2 + np.sqrt(8)) / 5)
    assert mesh.boundary_vertices.tolist() == [0, 1, 2, 3]
    assert geometry.edge_lengths(SQUARE, HALVES)[0] == pytest.approx([2, np.sqrt(8), 2])
    assert repr(mesh) == "TriangleMesh('square', 4 vertices, 2 faces)"


def test_components_are_numbered_by_size():
    faces = np.vstack([[[0, 1, 2]], HALVES + 3])
    mesh = TriangleMesh(np.vstack([SQUARE[:3], SQUARE + 9, [[5, 5, 5]]]), faces)
    assert mesh.component_labels.tolist() == [1, 1, 1, 0, 0, 0, 0, 2]
    assert mesh.component_count == 3


def test_unique_edges_agree_with_sorting_rows():
    faces = np.random.default_rng(0).integers(0, 30, size=(200, 3))
    edges, uses = topology.unique_edges(faces)
    rows = np.sort(topology.half_edges(faces), axis=1)
    expected, counts = np.unique(rows, axis=0, return_counts=True)
    assert np.array_equal(edges, expected)
    assert np.array_equal(uses, counts)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), exponent=st.integers(-40, 40))
def test_relabeling_motion_and_scale_change_nothing_else(seed, exponent):
    rng = np.random.default_rng(seed)
    vertices, faces = rng.random((12, 3)), rng.integers(12, size=(20, 3))
    mesh = TriangleMesh(vertices, faces)
    order = rng.permutation(12)
    rank = np.argsort(order)
    turn, _ = np.linalg.qr(rng.standard_normal((3, 3)))
    scale = 10.0**exponent
    other = TriangleMesh((vertices[order] @ turn.T) * scale, rank[faces])
    assert other.area == pytest.approx(mesh.area * scale**2)
    assert other.vertex_areas == pytest.approx(mesh.vertex_areas[order] * scale**2)
    assert other.vertex_areas.sum() == pytest.approx(other.area)
    assert np.array_equal(other.boundary_vertices, np.sort(rank[mesh.boundary_vertices]))


def test_arrays_are_frozen_and_private():
    vertices, faces, values = SQUARE.copy(), HALVES.copy(), np.arange(4.0)
    mesh = TriangleMesh(vertices, faces, fields={"a": values})
    vertices[0], faces[0], values[0] = 7, 3, 7
    assert mesh.vertices[0].tolist() == [0, 0, 0]
    assert mesh.faces[0].tolist() == [0, 1, 2]
    assert mesh.fields["a"][0] == 0
    for array in (mesh.vertices, mesh.faces, mesh.fields["a"], mesh.face_areas, mesh.edges):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1
    with pytest.raises(dataclasses.FrozenInstanceError):
        mesh.name = "other"
    with pytest.raises(TypeError):
        mesh.fields["b"] = values


def test_copies_and_processes_keep_everything():
    mesh = square(height=[1, 2, 3, 4])
    for other in (pickle.loads(pickle.dumps(mesh)), mesh.with_vertices(SQUARE)):  # noqa: S301
        assert np.array_equal(other.vertices, mesh.vertices)
        assert np.array_equal(other.faces, mesh.faces)
        assert other.fields["height"].tolist() == [1, 2, 3, 4]
        assert other.name == "square"
    assert set(mesh.with_fields(depth=np.zeros((4, 2))).fields) == {"height", "depth"}


def test_submesh_keeps_numbers_and_fields():
    part, kept = square(height=[1, 2, 3, 4]).submesh([False, True])
    assert kept.tolist() == [0, 2, 3]
    assert part.faces.tolist() == [[0, 1, 2]]
    assert part.fields["height"].tolist() == [1, 3, 4]
    with pytest.raises(InvalidMeshError, match=r"face_mask has shape \(3,\), but \(2,\)"):
        square().submesh([True] * 3)
    with pytest.raises(InvalidMeshError, match="no faces"):
        square().submesh([False, False])


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (SQUARE[:, :2], HALVES, r"vertices has shape \(4, 2\), but \(n, 3\)"),
        (np.where(SQUARE == 2, np.nan, SQUARE), HALVES, r"vertices\[1, 0\] = nan.*3 of 4"),
        (np.where(SQUARE == 2, np.inf, SQUARE), HALVES, r"vertices\[1, 0\] = inf"),
        (SQUARE * 1e71, HALVES, r"vertices\[1, 0\] = 2e\+71"),
        ([["a", "b", "c"]], HALVES, "vertices cannot be read as numbers"),
        ([[0, 0, 0], [1, 1]], HALVES, "vertices cannot be read as numbers"),
        (SQUARE, [[0, 1, 4]], r"faces\[0, 2\] = 4, but there are 4 vertices \(0\.\.3\)"),
        (SQUARE, [[0, -1, 2]], r"faces\[0, 1\] = -1"),
        (SQUARE, [[0, 1.5, 2]], "faces holds fractions"),
        (SQUARE, [[0, np.nan, 2]], "faces holds fractions"),
        (SQUARE, [[0, 1, 2, 3]], r"faces has shape \(1, 4\), but \(m, 3\)"),
        (SQUARE, [], r"no faces, only points.* sherd\.surface_from_points\(sherd\.PointCloud\("),
        (SQUARE, np.zeros((0, 3), int), "there are no faces, only points"),
    ],
)
def test_the_door_names_the_element(vertices, faces, message):
    with pytest.raises(InvalidMeshError, match=message):
        TriangleMesh(vertices, faces)


@pytest.mark.parametrize("values", [np.zeros(3), np.zeros((4, 2, 2)), 7, [["a"]] * 4])
def test_fields_of_another_shape_are_refused(values):
    with pytest.raises(InvalidMeshError, match="field 'height'"):
        square(height=values)


def test_the_largest_coordinates_still_have_an_area():
    big = TriangleMesh(SQUARE * 1e69, HALVES)
    assert big.area == pytest.approx(4e138)
    assert np.isfinite(big.vertex_normals).all()


def test_numbers_too_small_for_areas_are_refused_by_name():
    small = TriangleMesh(SQUARE * 1e-60, HALVES)
    assert small.area == pytest.approx(4e-120, rel=1e-12)
    with pytest.raises(InvalidMeshError, match="all 4 vertices lie within 2e-61 of each other"):
        TriangleMesh(SQUARE * 1e-61, HALVES)


def test_surface_points_interpolate_linearly():
    points = SurfacePoints([0, 1], [[0.5, 0.5, 0], [0.25, 0.25, 0.5]])
    assert points.positions(square()).tolist() == [[1, 0, 0], [0.5, 1.5, 0]]
    assert points.interpolate(square(), [0, 1, 2, 3]).tolist() == [0.5, 2]
    assert points.nearest_vertices(square()).tolist() == [0, 3]
    assert len(points[[True, False]]) == 1


@pytest.mark.parametrize(
    ("faces", "weights", "message"),
    [
        ([0], [[0.5, 0.4, 0]], r"barycentric\[0\] = .*sum to 1"),
        ([0, 0], [[1, 0, 0], [1.5, -0.5, 0]], r"barycentric\[1\]"),
        ([0], [[np.nan, 0, 1]], r"barycentric\[0\]"),
        ([0, 1], [[1, 0, 0]], r"faces has shape \(2,\)"),
    ],
)
def test_impossible_weights_are_refused(faces, weights, message):
    with pytest.raises(InvalidMeshError, match=message):
        SurfacePoints(faces, weights)


def test_points_at_vertices_are_the_vertices():
    mesh = square()
    points = points_at_vertices(mesh, [3, 1, 0, 2])
    assert np.array_equal(points.positions(mesh), SQUARE[[3, 1, 0, 2]])
    with pytest.raises(InvalidMeshError, match=r"vertices\[1\] = 4"):
        points_at_vertices(mesh, [0, 4])
    lonely = TriangleMesh(np.vstack([SQUARE, [[9, 9, 9]]]), HALVES)
    with pytest.raises(InvalidMeshError, match="vertex 4 of mesh belongs to no face"):
        points_at_vertices(lonely, [4])


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_closest_points_are_no_farther_than_a_dense_sample(seed):
    rng = np.random.default_rng(seed)
    mesh = TriangleMesh(rng.random((6, 3)), [[0, 1, 2], [3, 4, 5]])
    queries = rng.standard_normal((5, 3))
    found = closest_points(mesh, queries).positions(mesh)
    weights = rng.dirichlet(np.ones(3) / 2, size=400)
    sample = np.einsum("pk,mkc->mpc", weights, mesh.vertices[mesh.faces]).reshape(-1, 3)
    best = np.linalg.norm(queries[:, None] - sample, axis=2).min(axis=1)
    assert (np.linalg.norm(queries - found, axis=1) <= best + 1e-9).all()


def test_vertices_that_no_face_names_get_no_number() -> None:
    faces = np.array([[5, 2, 9], [2, 5, 7]])
    used, renamed = topology.renumbered(faces)
    assert used.tolist() == [2, 5, 7, 9]
    np.testing.assert_array_equal(used[renamed], faces)
    nothing = topology.renumbered(faces[:0])
    assert [each.shape for each in nothing] == [(0,), (0, 3)]
