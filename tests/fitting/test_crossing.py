"""Limbs that went through each other are pushed apart; a rigid motion crosses nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sherd.correspondence.elastic_kernel import closest_rotations
from sherd.fitting import fitted as fitted_module
from sherd.fitting.as_rigid_as_possible import Elasticity
from sherd.fitting.deformation import Deformation, with_rings
from sherd.fitting.fitted import fitted_shape
from sherd.fitting.mending import turned_faces as turned_faces_module
from sherd.fitting.mending.crossing import without_new_crossings
from sherd.fitting.mending.self_intersection import intersecting_faces
from sherd.fitting.mending.turned_faces import still_turned, turned_faces, without_turned_faces
from sherd.fitting.targets import Targets
from sherd.mesh.triangle_mesh import TriangleMesh


@pytest.fixture(scope="module")
def fork() -> tuple[Elasticity, np.ndarray]:
    """An open tube bent to a U, and which vertices are its base; both ends are limbs."""
    along, around, radius = 60, 12, 0.7
    length = np.linspace(-3.0, 3.0, along)
    angle = np.clip(length / radius, -np.pi / 2, np.pi / 2)
    rise = np.abs(length - radius * angle)
    outward = np.stack([np.sin(angle), 0 * angle, -np.cos(angle)], axis=1)
    center = radius * outward + rise[:, None] * [0.0, 0.0, 1.0]
    turn = 2 * np.pi * np.arange(around) / around
    ring = np.cos(turn)[None, :, None] * outward[:, None]
    ring = ring + np.sin(turn)[None, :, None] * np.array([0.0, 1.0, 0.0])
    vertices = (center[:, None] + 0.3 * ring).reshape(-1, 3)
    k, j = np.meshgrid(np.arange(along - 1), np.arange(around), indexing="ij")
    a, b = around * k + j, around * k + (j + 1) % around
    c, d = a + around, b + around
    faces = np.concatenate([np.stack([a, b, d], -1), np.stack([a, d, c], -1)]).reshape(-1, 3)
    mesh = TriangleMesh(vertices, faces)
    middle = np.repeat(center, around, axis=0)
    if (mesh.vertex_normals * (vertices - middle)).sum() < 0:
        mesh = TriangleMesh(vertices, faces[:, ::-1])
    mesh = mesh.with_vertices(mesh.vertices / mesh.length)
    return Elasticity(mesh), np.repeat(np.abs(angle) < 1.2, around)


def identity(elasticity: Elasticity, positions: np.ndarray) -> Deformation:
    count = len(positions)
    return Deformation(positions, elasticity.fitted_rotations(positions), np.ones(count))


def test_crossed_limbs_are_pushed_apart(fork) -> None:
    elasticity, seen = fork
    rest, faces = elasticity.rest, elasticity.mesh.faces
    assert not intersecting_faces(rest, faces).any()
    reach = np.clip(rest[:, 2] - rest[seen, 2].max(), 0, None) / np.ptp(rest[:, 2])
    crossed = rest.copy()
    crossed[:, 0] -= np.sign(rest[:, 0]) * 0.35 * reach
    before = int(intersecting_faces(crossed, faces).sum())
    assert before > 0
    answer = without_new_crossings(elasticity, identity(elasticity, crossed), seen)
    assert intersecting_faces(answer.positions, faces).sum() < before
    assert np.abs(answer.positions[seen] - crossed[seen]).max() < 0.01


def test_what_the_map_mixes_up_is_let_go(fork) -> None:
    """All was seen, but a patch of one limb was mapped into the other one."""
    elasticity, seen = fork
    rest, faces = elasticity.rest, elasticity.mesh.faces
    left, right = (~seen & (rest[:, 0] < 0)), (~seen & (rest[:, 0] > 0))
    inmost = np.flatnonzero(left)[rest[left, 0].argmax()]
    gap = rest[right, 0].min() - rest[inmost, 0]
    patch = np.linalg.norm(rest - rest[inmost], axis=1) < 0.1
    mixed = rest.copy()
    mixed[patch, 0] += 1.3 * gap
    assert intersecting_faces(mixed, faces).any()
    everything = np.ones(len(rest), dtype=bool)
    answer = without_new_crossings(elasticity, identity(elasticity, mixed), everything)
    assert not intersecting_faces(answer.positions, faces).any()
    assert np.abs(answer.positions[right] - rest[right]).max() < 0.1
    assert np.abs(answer.positions[seen] - rest[seen]).max() < 0.005


def test_bent_limbs_that_were_seen_give_way_to_each_other(fork) -> None:
    """Both were seen bent until their ends crossed; let go they stay bent, so they are pushed."""
    elasticity, seen = fork
    rest, faces = elasticity.rest, elasticity.mesh.faces
    base = rest[seen, 2].max()
    height = np.clip(rest[:, 2] - base, 0, None)
    ends = height > 0.8 * height.max()
    gap = np.abs(rest[ends, 0]).min()
    bent = np.arctan2(1.2 * gap, 0.9 * height.max()) * np.minimum(height / 0.1, 1.0)
    met = rest.copy()
    met[:, 0] -= np.sign(rest[:, 0]) * height * np.sin(bent)
    met[:, 2] -= height * (1 - np.cos(bent))
    crossing = intersecting_faces(met, faces)
    assert 0 < crossing.sum() < 100
    everything = np.ones(len(rest), dtype=bool)
    answer = without_new_crossings(elasticity, identity(elasticity, met), everything)
    assert not intersecting_faces(answer.positions, faces).any()
    assert np.linalg.norm(answer.positions - met, axis=1).max() < 0.1


def test_where_pushing_is_enough_all_else_stays(fork) -> None:
    """A dent in a hidden limb that reaches through the other one: the limb is not turned back."""
    elasticity, seen = fork
    rest, faces = elasticity.rest, elasticity.mesh.faces
    limb = np.flatnonzero(~seen & (rest[:, 0] > 0))
    height = np.median(rest[limb, 2])
    dented = rest.copy()
    near = (rest[:, 0] > 0) & (np.abs(rest[:, 2] - height) < 0.02 * np.ptp(rest[:, 2]))
    inner = near & (rest[:, 0] < np.median(rest[near, 0]))
    dented[inner, 0] -= 2.1 * rest[near, 0].min()
    crossing = intersecting_faces(dented, faces)
    assert crossing.any()
    answer = without_new_crossings(elasticity, identity(elasticity, dented), seen)
    assert not intersecting_faces(answer.positions, faces).any()
    far = ~with_rings(elasticity, np.isin(np.arange(len(rest)), faces[crossing]), 9)
    assert (far & ~seen).any()
    assert (answer.positions[far] == dented[far]).all()


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
    bad[vertex] += 3.0 * (bad[ring[ring != vertex][0]] - bad[vertex])  # beyond a neighbor
    found = identity(elasticity, bad)
    assert turned_faces(elasticity.rest, bad, found.rotations, faces).any()
    start = Deformation(bad, np.tile(np.eye(3), (len(bad), 1, 1)), np.ones(len(bad)))
    mended = without_turned_faces(elasticity, start)
    rotations = elasticity.fitted_rotations(mended.positions)
    assert not turned_faces(elasticity.rest, mended.positions, rotations, faces).any()


def test_what_is_turned_back_hardly_moves(fork) -> None:
    """Two vertices beyond a neighbor: only what is within two edges of them moves."""
    elasticity, seen = fork
    rest, faces = elasticity.rest, elasticity.mesh.faces
    bad, folded = rest.copy(), []
    for side in (rest[:, 0] < 0, rest[:, 0] > 0):
        limb = np.flatnonzero(~seen & side)
        vertex = limb[np.argmin(np.abs(rest[limb, 2] - np.median(rest[limb, 2])))]
        ring = np.unique(faces[(faces == vertex).any(axis=1)])
        bad[vertex] += 3.0 * (bad[ring[ring != vertex][0]] - bad[vertex])
        folded.append(int(vertex))
    found = identity(elasticity, bad)
    assert still_turned(elasticity, found)
    mended = without_turned_faces(elasticity, found)
    assert still_turned(elasticity, mended) == 0
    moved = np.linalg.norm(mended.positions - bad, axis=1) > 0
    near = with_rings(elasticity, np.isin(np.arange(len(rest)), folded), 2)
    assert moved.any()
    assert not (moved & ~near).any()


def test_what_finds_no_room_is_let_go_in_wider_surroundings(fork, monkeypatch) -> None:
    """Of two places with turned faces only the one that stays turned is let go more widely."""
    elasticity, seen = fork
    rest, faces = elasticity.rest, elasticity.mesh.faces
    asked = []

    def mends_the_left(elasticity: Elasticity, found: Deformation, released: np.ndarray):
        asked.append(released.copy())
        mended = np.where(rest[:, :1] < 0, rest, found.positions)
        return replace(found, positions=mended)

    bad = rest.copy()
    for side in (rest[:, 0] < 0, rest[:, 0] > 0):
        limb = np.flatnonzero(~seen & side)
        vertex = limb[np.argmin(np.abs(rest[limb, 2] - np.median(rest[limb, 2])))]
        ring = np.unique(faces[(faces == vertex).any(axis=1)])
        bad[vertex] += 3.0 * (bad[ring[ring != vertex][0]] - bad[vertex])
    monkeypatch.setattr(turned_faces_module, "SWEEPS", 0)
    monkeypatch.setattr(turned_faces_module, "without_data", mends_the_left)
    without_turned_faces(elasticity, identity(elasticity, bad))
    left = rest[:, 0] < 0
    counts = np.array([[released[left].sum(), released[~left].sum()] for released in asked[:4]])
    assert (counts[:, 0] == counts[0, 0]).all()
    assert (np.diff(counts[:, 1]) > 0).all()


def test_closest_rotations_are_proper_and_undo_stretching() -> None:
    rng = np.random.default_rng(0)
    turns = closest_rotations(rng.normal(size=(50, 3, 3)))
    assert np.allclose(turns @ turns.transpose(0, 2, 1), np.eye(3))
    assert np.allclose(np.linalg.det(turns), 1)
    stretched = turns @ np.diag([1.0, 2.0, 3.0])
    assert np.allclose(closest_rotations(stretched), turns)


def test_a_smooth_start_is_tried_where_a_face_stays_turned(fork, monkeypatch) -> None:
    elasticity, seen = fork
    faces, rest = elasticity.mesh.faces, elasticity.rest
    folded = rest.copy()
    across = np.setdiff1d(faces[(faces == faces[0, 0]).any(axis=1)], faces[0])
    folded[faces[0, 0]] = 2 * folded[across].mean(axis=0) - folded[faces[0, 0]] + [0.2, 0.2, 0.2]
    starts = [identity(elasticity, folded), identity(elasticity, rest)]
    assert still_turned(elasticity, starts[0])
    monkeypatch.setattr(fitted_module, "_starts", lambda *_, **__: iter(starts))
    monkeypatch.setattr(fitted_module, "fine_deformation", lambda _, start, *__: start)
    monkeypatch.setattr(fitted_module, "without_turned_faces", lambda _, found: found)
    monkeypatch.setattr(fitted_module, "without_new_crossings", lambda _, found, __: found)
    monkeypatch.setattr(fitted_module, "new_crossings", lambda *_: 0)
    targets = Targets(rest, seen.astype(float))
    answer = fitted_shape(elasticity.mesh, targets, elasticity.mesh, sizing="none")
    assert still_turned(elasticity, answer) == 0
