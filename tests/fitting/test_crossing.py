"""Limbs that went through each other are pushed apart; a rigid motion crosses nothing."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from sherd.fitting.as_rigid_as_possible import Elasticity, closest_rotations
from sherd.fitting.crossing import without_new_crossings
from sherd.fitting.deformation import Deformation
from sherd.fitting.self_intersection import intersecting_faces
from sherd.fitting.turned_faces import turned_faces, without_turned_faces
from sherd.mesh.triangle_mesh import TriangleMesh


@pytest.fixture(scope="module")
def fork() -> tuple[Elasticity, np.ndarray]:
    """A long tube bent to a U, and which vertices are its base; both ends are limbs."""
    tube = trimesh.creation.capsule(height=4.0, radius=0.25, count=[16, 16])
    vertices, faces = trimesh.remesh.subdivide(tube.vertices, tube.faces)
    z = vertices[:, 2] - 2.0
    angle = np.clip(z / 0.8, -np.pi / 2, np.pi / 2)
    straight = z - 0.8 * angle
    bent = np.stack(
        [
            (0.8 + vertices[:, 0]) * np.sin(angle) + 0 * straight,
            vertices[:, 1],
            -(0.8 + vertices[:, 0]) * np.cos(angle) + np.abs(straight),
        ],
        axis=1,
    )
    mesh = TriangleMesh(bent, faces)
    mesh = mesh.with_vertices(mesh.vertices / mesh.length)
    return Elasticity(mesh), np.abs(angle) < 0.6


def identity(elasticity: Elasticity, positions: np.ndarray) -> Deformation:
    count = len(positions)
    return Deformation(positions, elasticity.fitted_rotations(positions), np.ones(count))


def test_crossed_limbs_are_pushed_apart(fork) -> None:
    elasticity, seen = fork
    rest, faces = elasticity.rest, elasticity.mesh.faces
    assert not intersecting_faces(rest, faces).any()
    reach = np.clip(rest[:, 2] - np.quantile(rest[:, 2], 0.3), 0, None)
    crossed = rest.copy()
    crossed[:, 0] -= np.sign(rest[:, 0]) * 0.62 * reach * (~seen)
    before = int(intersecting_faces(crossed, faces).sum())
    assert before > 0
    answer = without_new_crossings(elasticity, identity(elasticity, crossed), seen)
    assert intersecting_faces(answer.positions, faces).sum() < before
    assert np.abs(answer.positions[seen] - crossed[seen]).max() < 0.01


def test_what_crosses_nothing_is_left_alone(fork) -> None:
    elasticity, seen = fork
    found = identity(elasticity, elasticity.rest + 1.0)
    assert without_new_crossings(elasticity, found, seen) is found


def test_a_turned_face_is_turned_back(fork) -> None:
    elasticity, _ = fork
    faces = elasticity.mesh.faces
    bad = elasticity.rest.copy()
    vertex = int(faces[200, 0])
    ring = np.unique(faces[(faces == vertex).any(axis=1)])
    bad[vertex] += 3.0 * (bad[ring].mean(axis=0) - bad[vertex]) + 2.0 * (bad[ring[0]] - bad[vertex])
    found = identity(elasticity, bad)
    assert turned_faces(elasticity.rest, bad, found.rotations, faces).any()
    start = Deformation(bad, np.tile(np.eye(3), (len(bad), 1, 1)), np.ones(len(bad)))
    mended = without_turned_faces(elasticity, start)
    rotations = elasticity.fitted_rotations(mended.positions)
    assert not turned_faces(elasticity.rest, mended.positions, rotations, faces).any()


def test_closest_rotations_are_proper_and_undo_stretching() -> None:
    rng = np.random.default_rng(0)
    turns = closest_rotations(rng.normal(size=(50, 3, 3)))
    assert np.allclose(turns @ turns.transpose(0, 2, 1), np.eye(3))
    assert np.allclose(np.linalg.det(turns), 1)
    stretched = turns @ np.diag([1.0, 2.0, 3.0])
    assert np.allclose(closest_rotations(stretched), turns)
