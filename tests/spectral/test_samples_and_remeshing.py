"""Samples spread evenly, and coarser meshes lie on the surface where they say."""

import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pyfqmr
import pytest
from scipy.sparse import csgraph

from sherd.errors import OptionError
from sherd.mesh import topology
from sherd.mesh.geometry import edge_lengths
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral import sampling
from sherd.spectral.evening import flipped_to_delaunay
from sherd.spectral.geodesics import Geodesics
from sherd.spectral.operators import corner_cotangents
from sherd.spectral.sampling import (
    decimate,
    farthest_point_sample,
    farthest_point_sample_euclidean,
    remesh,
)
from sherd.spectral.subdivision import split_long_edges


def cap(mesh, height):
    """The faces of a mesh above a height."""
    return mesh.submesh(mesh.vertices[mesh.faces][:, :, 2].min(axis=1) > height)[0]


def test_each_sample_is_the_farthest_from_those_before(sphere):
    mesh = sphere(4)
    geodesics = Geodesics(mesh)
    indices, distances = farthest_point_sample(geodesics, 20, start=9)
    assert indices[0] == 9
    along = csgraph.dijkstra(geodesics.paths, directed=False, indices=indices)
    for step in range(1, 20):
        nearest = along[:step].min(axis=0)
        assert nearest[indices[step]] == pytest.approx(nearest.max(), rel=1e-12)
    gaps = along[:, indices] + 10 * np.eye(20)
    # greedy sampling is a packing: no two samples closer than any point is from the sample
    assert gaps.min() >= (1 - 1e-12) * along.min(axis=0).max()
    # paths are no shorter than geodesics, and hardly longer
    ratio = (
        np.delete(along[0], 9) / np.arccos(mesh.vertices @ mesh.vertices[9])[np.arange(1026) != 9]
    )
    assert 0.99 < ratio.min()
    assert ratio.max() < 1.09
    np.testing.assert_array_equal(distances, geodesics.distances_from(indices))


def test_components_share_the_samples_by_area(sphere):
    mesh = sphere(3)
    count = mesh.vertex_count
    vertices = np.concatenate([mesh.vertices, [[7, 7, 7]], 2 * mesh.vertices + 9])
    pair = TriangleMesh(vertices, np.concatenate([mesh.faces, mesh.faces + count + 1]))
    indices, distances = farthest_point_sample(Geodesics(pair), 50, start=0)
    assert indices[1] > count  # the other component was infinitely far
    large = (indices > count).sum()
    assert large == pytest.approx(40, abs=4)  # four fifths of the area
    assert count not in indices  # a vertex without a face
    assert np.isinf(distances[0, count + 1 :]).all()


def test_every_vertex_can_be_taken_once():
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [1, 1, 0]]
    mesh = TriangleMesh(vertices, [[0, 1, 2], [1, 3, 2], [1, 4, 2]])  # two coincident vertices
    indices, _ = farthest_point_sample(Geodesics(mesh), 5, start=0)
    assert sorted(indices) == [0, 1, 2, 3, 4]


def test_euclidean_samples_equal_the_plain_algorithm():
    points = np.random.default_rng(3).normal(size=(500, 3))
    found = farthest_point_sample_euclidean(points, 40, start=7)
    chosen = [7]
    for _ in range(39):
        gap = np.linalg.norm(points[:, None] - points[chosen], axis=2).min(axis=1)
        chosen.append(int(gap.argmax()))
    assert found.tolist() == chosen


@pytest.mark.parametrize(("count", "start"), [(0, 0), (6, 0), (2, 5), (2, -1)])
def test_impossible_samples_are_refused(count, start):
    points = np.eye(5, 3)
    with pytest.raises(OptionError, match=r"count is|start is"):
        farthest_point_sample_euclidean(points, count, start=start)


def test_decimation_meets_the_count_keeps_the_border_and_knows_its_place(sphere):
    mesh = cap(sphere(5), -0.3)
    mesh = mesh.with_fields(height=mesh.vertices[:, 2])
    small, points = decimate(mesh, 600)
    assert small.vertex_count == pytest.approx(600, rel=0.011)
    assert np.array_equal(points.positions(mesh), small.vertices)
    np.testing.assert_allclose(small.fields["height"], small.vertices[:, 2], atol=1e-12)
    border = {tuple(p) for p in small.vertices[small.boundary_vertices].round(9)}
    assert border == {tuple(p) for p in mesh.vertices[mesh.boundary_vertices].round(9)}
    assert small.area == pytest.approx(mesh.area, rel=0.01)
    with pytest.raises(OptionError, match="on its border"):
        decimate(mesh, len(border))


@pytest.mark.parametrize("factor", [0.7, 1.0, 2.5])
def test_remeshing_meets_the_edge_length_with_even_triangles(sphere, factor):
    mesh = cap(sphere(4), -0.5)
    wanted = factor * mesh.mean_edge_length
    new, points = remesh(mesh, wanted)
    assert np.array_equal(points.positions(mesh), new.vertices)
    assert new.mean_edge_length == pytest.approx(wanted, rel=0.2)
    squares = (edge_lengths(new.vertices, new.faces) ** 2).sum(axis=1)
    quality = 4 * np.sqrt(3) * new.face_areas / squares  # 1 for equilateral triangles
    assert np.median(quality) > 0.9
    # still one disk, no fold, and no face of the old mesh lived on by accident
    assert new.component_count == 1
    assert new.vertex_count - len(new.edges) + new.face_count == 1
    assert (np.einsum("mc,mc->m", new.face_normals, new.vertices[new.faces].mean(axis=1)) > 0).all()
    assert new.area == pytest.approx(mesh.area, rel=0.03)


def test_remeshing_is_reproducible_and_refuses_nonsense(sphere):
    mesh = sphere(3)
    first, second = remesh(mesh, 0.2)[0], remesh(mesh, 0.2)[0]
    assert np.array_equal(first.vertices, second.vertices)
    assert np.array_equal(first.faces, second.faces)
    for bad in (0.0, -1.0, np.nan, 1e-9):
        with pytest.raises(OptionError, match="edge_length"):
            remesh(mesh, bad)


def test_splitting_keeps_the_surface_and_leaves_no_crack(sphere):
    mesh = sphere(1)
    vertices = mesh.vertices * [5.0, 1.0, 1.0]
    fine, faces = split_long_edges(vertices, mesh.faces, 0.4)
    assert edge_lengths(fine, faces).max() <= 0.4
    new = TriangleMesh(fine, faces)
    assert new.area == pytest.approx(mesh.with_vertices(vertices).area, rel=1e-12)
    assert (topology.unique_edges(faces)[1] == 2).all()


def test_splitting_a_hair_ends_at_the_most_vertices_with_the_longest_edges_halved():
    hair = np.array([[0.0, 0, 0], [1e6, 0, 0], [0, 1e-6, 0], [0, 1e-6, 40]])
    vertices, faces = split_long_edges(hair, np.array([[0, 1, 2], [1, 3, 2]]), 0.01, most=1000)
    assert len(vertices) == 1000
    assert edge_lengths(vertices, faces).max() < 1e6 / 30
    assert (topology.unique_edges(faces)[1] <= 2).all()
    area = TriangleMesh(hair, [[0, 1, 2], [1, 3, 2]]).area
    assert TriangleMesh(vertices, faces).area == pytest.approx(area)


def test_flipping_makes_a_plane_mesh_delaunay():
    rng = np.random.default_rng(2)
    ticks = np.arange(8.0)
    x, y = np.meshgrid(ticks, ticks, indexing="ij")
    flat = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    flat[:, :2] += rng.uniform(-0.3, 0.3, size=(64, 2))
    corner = (np.arange(7)[:, None] * 8 + np.arange(7)).ravel()
    faces = np.concatenate(
        [
            np.stack([corner, corner + 8, corner + 9], 1),
            np.stack([corner, corner + 9, corner + 1], 1),
        ]
    )
    flipped = flipped_to_delaunay(flat, faces)
    sides = np.sort(flipped[:, [1, 2, 2, 0, 0, 1]].reshape(-1, 2), axis=1)
    _, edge, uses = np.unique(sides, axis=0, return_inverse=True, return_counts=True)
    total = np.bincount(edge.ravel(), corner_cotangents(flat, flipped).ravel())
    assert total[uses == 2].min() > -1e-9
    area = TriangleMesh(flat, faces).area
    assert TriangleMesh(flat, flipped).area == pytest.approx(area, rel=1e-12)
    assert TriangleMesh(flat, flipped).face_normals[:, 2].min() > 0


def test_a_dense_border_can_be_thinned_with_the_rest() -> None:
    """A square whose border holds half of the wanted vertices: kept on request, else even."""
    count = 101
    x, y = np.meshgrid(np.linspace(0, 1, count), np.linspace(0, 1, count))
    vertices = np.stack([x.ravel(), y.ravel(), 0.1 * np.sin(3 * x.ravel())], axis=1)
    corner = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    lower = np.stack([corner, corner + 1, corner + count], axis=1)
    upper = np.stack([corner + 1, corner + count + 1, corner + count], axis=1)
    square = TriangleMesh(vertices, np.concatenate([lower, upper]))
    kept, _ = decimate(square, 800)
    even, points = decimate(square, 800, keep_border=False)
    assert len(kept.boundary_vertices) == 4 * (count - 1)
    assert 50 < len(even.boundary_vertices) < 200
    assert even.vertex_count == pytest.approx(800, rel=0.03)
    assert even.area == pytest.approx(square.area, rel=0.02)
    np.testing.assert_array_equal(points.positions(square), even.vertices)


def test_two_threads_that_decimate_at_once_get_their_own_mesh(sphere, monkeypatch) -> None:
    """The library keeps one mesh for all; on a busy machine a match so lost its full shape."""

    class Slow(pyfqmr.Simplify):
        def setMesh(self, vertices, faces) -> None:  # noqa: N802 - the name of the library
            super().setMesh(vertices, faces)
            time.sleep(0.1)

    meshes = [sphere(4), sphere(3)]
    alone = [decimate(mesh, 100)[0] for mesh in meshes]
    monkeypatch.setattr(sampling.pyfqmr, "Simplify", Slow)
    with ThreadPoolExecutor(2) as both:
        beside = list(both.map(lambda mesh: decimate(mesh, 100)[0], meshes))
    for one, other in zip(alone, beside, strict=True):
        assert (one.vertices == other.vertices).all()
