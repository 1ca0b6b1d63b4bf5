"""Relief patches: drawn on the skin, compared as far as both are seen, in all rotations."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.arrays import Floats, Ints
from sherd.descriptors.polar_kernel import polar_means
from sherd.descriptors.relief_patches import (
    RINGS,
    SHIFTS,
    ReliefPatches,
    patch_similarity,
    patch_similarity_in_pairs,
    relief_patches,
    relief_pictures,
    similarity_anywhere,
)
from sherd.descriptors.tangent_frames import smoothed_normals, tangent_axes
from sherd.mesh.topology import adjacency
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes import creature

# Rings of the drawings below.
WIDTH = 0.02
TURN = 2.0 * np.pi / SHIFTS
INSIDE = 9.0  # farther from a cut than any patch reaches


def sheet(count: int, radius: float) -> tuple[TriangleMesh, Floats]:
    """A rhombus of side 0.5, rolled up to a cylinder, and the places (n, 2) on the rhombus.

    Of even triangles.
    """
    line = np.linspace(-0.25, 0.25, count)
    along, across = np.stack(np.meshgrid(line, line, indexing="ij"), axis=-1).reshape(-1, 2).T
    plane = np.stack([along - 0.5 * across, np.sqrt(0.75) * across], axis=1)
    x, y = plane.T
    rolled = np.stack([radius * np.sin(x / radius), y, radius * np.cos(x / radius)], axis=1)
    corner = np.arange(count * count).reshape(count, count)
    a, b, c, d = corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]
    faces = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    return TriangleMesh(rolled, faces), plane


def drawn(mesh: TriangleMesh, pictures: Floats, source: int) -> tuple[Floats, Floats]:
    """Means (c, r, t) of pictures around a vertex, from the direction of the first axis on."""
    graph = adjacency(mesh.faces, mesh.vertex_count)
    means = np.zeros((1, len(pictures), RINGS, SHIFTS))
    seen = np.zeros((1, RINGS, SHIFTS))
    normals = mesh.vertex_normals
    axes = tangent_axes(normals[[source]], np.array([[1.0, 0.0, 0.0]]))
    polar_means(
        (0, 1), graph.indptr.astype(np.int64), graph.indices.astype(np.int64), mesh.vertices,
        normals, np.array([source]), axes, normals[[source]], WIDTH, pictures,
        mesh.vertex_areas, means, seen,
    )  # fmt: skip
    return means[0], seen[0]


@pytest.mark.parametrize("radius", [100.0, 0.08])
def test_a_drawing_is_that_of_the_plane_however_the_skin_is_rolled(radius: float) -> None:
    mesh, plane = sheet(201, radius)
    middle = 100 * 201 + 100
    means, seen = drawn(mesh, np.ascontiguousarray(plane.T), middle)
    away = (np.arange(RINGS) + 0.5)[:, None] * WIDTH
    angles = np.arange(SHIFTS) * TURN
    # the innermost cells hold a handful of vertices
    np.testing.assert_allclose(means[0][1:], (away * np.cos(angles))[1:], atol=0.1 * WIDTH)
    np.testing.assert_allclose(means[1][1:], (away * np.sin(angles))[1:], atol=0.1 * WIDTH)
    flat = np.pi * WIDTH**2 * (2 * np.arange(RINGS) + 1)[:, None] / SHIFTS
    np.testing.assert_allclose(seen[1:], np.tile(flat[1:], SHIFTS), rtol=0.15)


@pytest.fixture(scope="module")
def standing() -> TriangleMesh:
    mesh = creature(5000)
    return mesh.with_vertices(mesh.vertices / mesh.length)


@pytest.fixture(scope="module")
def walking() -> TriangleMesh:
    mesh = creature(5000, pose="walk")
    return mesh.with_vertices(mesh.vertices / mesh.length)


def axes_of(mesh: TriangleMesh, normals: Floats, queries: Ints) -> Floats:
    return tangent_axes(normals[queries], np.tile([1.0, 0.3, 0.2], (len(queries), 1)))


def patches_of(
    mesh: TriangleMesh, queries: Ints, *, turned: int = 0, cut_distance: Floats | None = None
) -> ReliefPatches:
    """Patches, each with its axis turned by so many sectors."""
    normals = smoothed_normals(mesh, 0.012)
    axes = axes_of(mesh, normals, queries)
    side = np.cross(normals[queries], axes)
    axes = np.cos(turned * TURN) * axes + np.sin(turned * TURN) * side
    depth = np.full(mesh.vertex_count, INSIDE) if cut_distance is None else cut_distance
    return relief_patches(mesh, normals, depth, queries, x_axes=axes)


QUERIES = np.arange(0, 5000, 50)
CELLS = np.arange(len(QUERIES))


def test_a_patch_is_alike_itself_at_no_rotation(standing: TriangleMesh) -> None:
    patches = patches_of(standing, QUERIES)
    alike = patch_similarity(patches, patches, CELLS, len(CELLS))
    rings = (2 * np.arange(RINGS) + 1) / RINGS**2
    common = ((patches.seen**2).mean(axis=2) * rings).sum(axis=1)
    assert alike.max() < 1.0 + 1e-5
    assert (alike[CELLS, CELLS].argmax(axis=1) == 0).all()
    assert (alike.max(axis=2).argmax(axis=1) == CELLS).all()
    # at a tip there is less skin than in a plane, which proves less
    np.testing.assert_allclose(alike[CELLS, CELLS, 0], common**0.25, atol=1e-3)


def test_a_turned_axis_turns_the_rotation_where_patches_are_alike(standing: TriangleMesh) -> None:
    # the angle of a direction in the frame of the part minus that in the frame of the full shape
    full, part = patches_of(standing, QUERIES), patches_of(standing, QUERIES, turned=-3)
    alike = patch_similarity(full, part, CELLS, len(CELLS))
    assert (alike[CELLS, CELLS].argmax(axis=1) == 3).mean() > 0.95


def test_a_mirrored_patch_is_another_one(standing: TriangleMesh) -> None:
    patches = patches_of(standing, QUERIES)
    straight = patch_similarity(patches, patches, CELLS, len(CELLS)).max(axis=2)
    mirrored = patch_similarity(patches, patches.mirrored(), CELLS, len(CELLS)).max(axis=2)
    assert (straight[CELLS, CELLS] > mirrored[CELLS, CELLS] + 0.05).mean() > 0.9


def test_skin_is_found_again_in_another_pose(standing: TriangleMesh, walking: TriangleMesh) -> None:
    full, part = patches_of(standing, QUERIES), patches_of(walking, QUERIES)
    alike = patch_similarity(full, part, CELLS, len(CELLS)).max(axis=2)
    first = (alike.argmax(axis=1) == CELLS).mean()
    assert first > 0.5  # a hundredth by chance


def test_patches_are_compared_where_both_are_seen(standing: TriangleMesh) -> None:
    # one sees all around, the other one what is above a plane
    height = standing.vertices[:, 2] - np.median(standing.vertices[QUERIES, 2])
    cut = np.clip(height, 0.0, None)
    queries = QUERIES[(height[QUERIES] > 0.0) & (height[QUERIES] < 0.05)]
    cells = np.arange(len(queries))
    whole, part = patches_of(standing, queries), patches_of(standing, queries, cut_distance=cut)
    assert part.seen.mean() < 0.9 * whole.seen.mean()
    alike = patch_similarity(whole, part, cells, len(cells))
    seen = part.seen.mean(axis=(1, 2)) > 0.3
    assert (alike.max(axis=2).argmax(axis=1) == cells)[seen].mean() > 0.9


def test_too_little_in_common_says_nothing(standing: TriangleMesh) -> None:
    patches = patches_of(standing, QUERIES[:4])
    hidden = ReliefPatches(patches.means, np.zeros_like(patches.seen))
    assert not patch_similarity(patches, hidden, CELLS[:4], 4).any()


def test_anywhere_is_the_best_of_all_and_reversed_the_best_with_hollows_for_bumps(
    standing: TriangleMesh, walking: TriangleMesh
) -> None:
    full, part = patches_of(standing, QUERIES), patches_of(walking, QUERIES[::2])
    one = np.zeros(len(full), dtype=np.int64)
    best, reverse = similarity_anywhere(full, part)
    hollow = ReliefPatches(-part.means, part.seen)
    assert np.array_equal(best, patch_similarity(full, part, one, 1).max(axis=(1, 2)))
    np.testing.assert_allclose(
        reverse, patch_similarity(full, hollow, one, 1).max(axis=(1, 2)), atol=1e-6
    )


def test_pairs_are_as_alike_as_when_all_are_compared(
    standing: TriangleMesh, walking: TriangleMesh
) -> None:
    full, part = patches_of(standing, QUERIES), patches_of(walking, QUERIES)
    own, other = np.array([0, 0, 3, 7]), np.array([0, 5, 3, 2])
    pairs = patch_similarity_in_pairs(full[other], part[own])
    alike = patch_similarity(full, part, CELLS, len(CELLS)).max(axis=2)
    np.testing.assert_allclose(pairs, alike[own, other], atol=1e-5)


def test_cells_without_a_patch_have_no_similarity(standing: TriangleMesh) -> None:
    patches = patches_of(standing, QUERIES[:3])
    alike = patch_similarity(patches, patches, np.array([2, 0, 2]), 4).max(axis=2)
    assert not alike[:, [1, 3]].any()
    assert alike[1, 0] > alike[1, 2]
    assert alike[2, 2] > alike[2, 0]


def test_pictures_are_ranks(standing: TriangleMesh) -> None:
    pictures = relief_pictures(standing)
    assert pictures.shape == (4, standing.vertex_count)
    assert np.abs(pictures.mean(axis=1)).max() < 0.01
    assert pictures.min() >= -0.5
    assert pictures.max() <= 0.5
