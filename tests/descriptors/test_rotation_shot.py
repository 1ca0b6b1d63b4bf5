"""Rotation-searched SHOT: what turns, what mirrors, what stays."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from sherd.descriptors import rotation_shot
from sherd.descriptors.rotation_kernel import similarity_of_two
from sherd.descriptors.rotation_shot import (
    mirrored_spectra,
    pooled_similarity,
    rotation_spectra,
    shift_table,
    similarity,
    weighted_spectra,
)
from sherd.descriptors.tangent_frames import Compass, smoothed_normals, tangent_axes
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.geodesics import Geodesics

RADII = (0.25, 0.4)
QUERIES = np.array([5, 77, 300, 611])


@pytest.fixture(scope="module")
def potato() -> TriangleMesh:
    ball = trimesh.creation.icosphere(subdivisions=4)
    x, y, z = ball.vertices.T
    radius = 1 + 0.15 * x * y + 0.1 * np.sin(5 * z + 2 * x) * y + 0.05 * np.cos(6 * x - z)
    return TriangleMesh(ball.vertices * radius[:, None], ball.faces)


def spectra_of(mesh: TriangleMesh, queries: np.ndarray, turn: float = 0.0) -> np.ndarray:
    normals = smoothed_normals(mesh, 0.05)
    z = normals[queries]
    x = tangent_axes(z, np.tile([1.0, 0.3, 0.2], (len(queries), 1)))
    x = np.cos(turn) * x + np.sin(turn) * np.cross(z, x)
    return rotation_spectra(
        mesh.vertices, normals, mesh.vertex_areas, queries, x_axes=x, z_axes=z, radii=RADII
    )


def self_similarity(full: np.ndarray, part: np.ndarray) -> np.ndarray:
    cells = np.arange(full.shape[1])
    return pooled_similarity(
        full, weighted_spectra(part, np.ones((part.shape[1], 2))), cells, len(cells)
    )


def test_a_point_is_most_similar_to_itself_and_reaches_one(potato: TriangleMesh) -> None:
    full = spectra_of(potato, QUERIES)
    best = self_similarity(full, full).max(axis=2)
    assert np.allclose(np.diag(best), 1.0, atol=1e-4)
    assert (best.argmax(axis=1) == np.arange(len(QUERIES))).all()


@pytest.mark.parametrize("shift", [1, 5, 14])
def test_turning_the_tangent_axis_moves_the_peak_by_the_same_angle(
    potato: TriangleMesh, shift: int
) -> None:
    full = spectra_of(potato, QUERIES)
    # the part's x axis turns back, so angles in the part's frame grow
    part = spectra_of(potato, QUERIES, turn=-2 * np.pi * shift / 16)
    peak = self_similarity(full, part)[np.arange(4), np.arange(4)].argmax(axis=1)
    assert (np.abs((peak - shift + 8) % 16 - 8) <= 1).all()


def test_the_mirror_image_of_a_neighborhood_is_another_one(potato: TriangleMesh) -> None:
    flip = np.array([-1.0, 1.0, 1.0])
    mirror = TriangleMesh(potato.vertices * flip, potato.faces[:, ::-1])
    full, image = spectra_of(potato, QUERIES), spectra_of(mirror, QUERIES)
    plain = np.diag(self_similarity(full, image).max(axis=2))
    undone = np.diag(self_similarity(full, mirrored_spectra(image)).max(axis=2))
    assert (undone > plain + 0.002).all()
    assert undone.min() > 0.97


def test_rigid_motion_leaves_similarities_alone(potato: TriangleMesh) -> None:
    frame = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    frame[:, 0] *= np.sign(np.linalg.det(frame))
    moved = potato.with_vertices(potato.vertices @ frame.T + 3.0)
    full, other = spectra_of(potato, QUERIES), spectra_of(moved, QUERIES)
    # the fixed reference gives another tangent axis, so only the best over rotation agrees
    assert np.diag(self_similarity(full, other).max(axis=2)).min() > 0.97


def test_hidden_vertices_change_nothing_but_themselves(potato: TriangleMesh) -> None:
    normals = smoothed_normals(potato, 0.05)
    z = normals[QUERIES]
    x = tangent_axes(z, np.tile([1.0, 0.0, 0.0], (len(QUERIES), 1)))
    far = np.linalg.norm(potato.vertices[:, None] - potato.vertices[QUERIES], axis=2).min(axis=1)
    weights = np.where(far < max(RADII), potato.vertex_areas, 0.0)
    arguments = {"x_axes": x, "z_axes": z, "radii": RADII}
    whole = rotation_spectra(potato.vertices, normals, potato.vertex_areas, QUERIES, **arguments)
    inside = rotation_spectra(potato.vertices, normals, weights, QUERIES, **arguments)
    assert np.array_equal(whole, inside)


def test_similarity_of_candidates_is_the_pooled_one(potato: TriangleMesh) -> None:
    full = spectra_of(potato, QUERIES)
    part = weighted_spectra(full, np.array([[1.0, 0.2]] * 4))
    pooled = pooled_similarity(full, part, np.arange(4), 4).max(axis=2)
    waves = shift_table()
    memory = np.empty(waves.shape[1], dtype=np.float32)
    pairs = [
        [similarity_of_two(full, vertex, part, point, waves, memory) for vertex in range(4)]
        for point in range(4)
    ]
    assert np.allclose(pairs, pooled, atol=1e-5)


def test_what_is_compared_at_a_time_does_not_matter(monkeypatch: pytest.MonkeyPatch) -> None:
    """More points and vertices than a block has, and cells whose vertices lie in several."""
    draw = np.random.default_rng(5).standard_normal
    part, full = (draw((5, count, 24)).astype(np.float32) for count in (7, 40))
    cells = np.arange(40) % 6
    at_once = similarity(full, part), pooled_similarity(full, part, cells, 6)
    monkeypatch.setattr(rotation_shot, "POINTS", 3)
    monkeypatch.setattr(rotation_shot, "VERTICES", 11)
    blocks = similarity(full, part), pooled_similarity(full, part, cells, 6)
    for expected, found in zip(at_once, blocks, strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-5)
    members = at_once[0][:, cells == 2].max(axis=1)
    np.testing.assert_allclose(at_once[1][:, 2].max(axis=1), members, rtol=1e-6)


def test_smoothing_keeps_the_normals_of_a_sphere(potato: TriangleMesh) -> None:
    ball = trimesh.creation.icosphere(subdivisions=4)
    mesh = TriangleMesh(ball.vertices, ball.faces)
    assert np.abs(smoothed_normals(mesh, 0.2) - mesh.vertices).max() < 0.01


def test_geodesics_of_a_plane_leave_in_straight_lines() -> None:
    grid = np.stack(np.meshgrid(np.arange(15.0), np.arange(15.0), indexing="ij"), -1).reshape(-1, 2)
    corner = (np.arange(14)[:, None] * 15 + np.arange(14)).ravel()
    faces = np.concatenate(
        [
            np.stack([corner, corner + 15, corner + 16], axis=1),
            np.stack([corner, corner + 16, corner + 1], axis=1),
        ]
    )
    mesh = TriangleMesh(np.column_stack([grid, np.zeros(len(grid))]), faces)
    samples = np.array([112, 32, 190])
    distances = Geodesics(mesh).distances_from(samples)
    axes = np.tile([1.0, 0.0, 0.0], (3, 1))
    up = np.tile([0.0, 0.0, 1.0], (3, 1))
    compass = Compass(mesh, samples, x_axes=axes, z_axes=up, near=0.5)
    found = compass.toward(samples, distances)
    chords = grid[samples][None] - grid[samples][:, None]
    true = np.arctan2(chords[..., 1], chords[..., 0])
    off = np.abs(np.angle(np.exp(1j * (found - true))))[~np.eye(3, dtype=bool)]
    # heat distances on 15 x 15 vertices; a flipped or turned axis would be off by 90 or more
    assert off.max() < np.radians(9)
