"""Sherds of a thick shell, solid and with faces of fracture, on the whole shell: all is known."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

import sherd
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.puzzle.rigid.rigid_trials import rigid_chance
from sherd.results.puzzle.assemble_options import TOLERANCE
from sherd.results.status import Status


def shell(seed: int) -> tuple[TriangleMesh, np.ndarray]:
    """A bumpy bowl, closed all around, and the middles of its faces: an outer wall and an inner."""
    rng = np.random.default_rng(seed)
    ball = trimesh.creation.icosphere(subdivisions=4)
    bumps = sum(0.02 * np.cos(ball.vertices @ rng.normal(size=3) * 4 + k) for k in range(30))
    outer = ball.vertices * (1 + bumps)[:, None] * [1.0, 0.9, 1.2]
    return TriangleMesh(outer, ball.faces, name="bowl"), ball.vertices[ball.faces].mean(axis=1)


def thick(wall: TriangleMesh) -> TriangleMesh:
    """The wall, another one within it that looks inward, and fractures between their borders."""
    inner = wall.vertices - 0.06 * wall.vertex_normals
    count, faces = wall.vertex_count, wall.faces
    sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    key = np.sort(sides, axis=1)
    _, first, number = np.unique(key, axis=0, return_index=True, return_counts=True)
    start, end = sides[first[number == 1]].T
    fracture = np.concatenate(
        [np.stack([end, start, start + count], 1), np.stack([end, start + count, end + count], 1)]
    )
    return TriangleMesh(
        np.concatenate([wall.vertices, inner]),
        np.concatenate([faces, faces[:, ::-1] + count, fracture]),
        name=wall.name,
    )


def sherds(seed: int) -> tuple[TriangleMesh, list[TriangleMesh], list[np.ndarray]]:
    """The whole, and pieces of it that are turned and shifted, with the matrices that did that."""
    wall, middles = shell(seed)
    rng = np.random.default_rng(seed + 1)
    pieces, motions = [], []
    for direction in ([1.0, 0.2, 0.1], [-0.3, 1.0, -0.4]):
        direction = np.array(direction) / np.linalg.norm(direction)  # noqa: PLW2901
        piece = thick(wall.submesh(middles @ direction > 0.45)[0])
        motion = np.eye(4)
        motion[:3, :3], motion[:3, 3] = (
            Rotation.random(random_state=seed).as_matrix(),
            rng.normal(size=3),
        )
        moved = piece.vertices @ motion[:3, :3].T + motion[:3, 3]
        pieces.append(piece.with_vertices(moved))
        motions.append(motion)
    return thick(wall), pieces, motions


@pytest.fixture(scope="module")
def answer() -> tuple[sherd.Assembly, list[np.ndarray]]:
    """Two own sherds and one of another bowl."""
    full, own, motions = sherds(1)
    _, (other, _), _ = sherds(5)
    return sherd.assemble(full, [*own, other], rigid=True), motions


def test_sherds_come_home_though_fractures_fit_nowhere(answer) -> None:
    found, motions = answer
    assert found.placed == (0, 1)
    for piece, motion in zip(found.pieces[:2], motions, strict=True):
        assert np.abs(piece.transform @ motion - np.eye(4)).max() < 1e-4
        assert piece.match.status is Status.GOOD
        assert "of the piece lie on the full shape" in piece.reason
    assert found.check().passed


def test_fractures_have_no_point_on_the_whole(answer) -> None:
    found, _ = answer
    for piece in found.pieces[:2]:
        part, matched = piece.match.part, piece.match.matched
        walls = part.face_areas @ matched[part.faces].all(axis=1)
        assert 0.75 < walls / part.area < 0.98
        assert piece.match.confidence[~matched].max() < 0.1


def test_a_sherd_of_another_bowl_is_refused(answer) -> None:
    found, _ = answer
    assert not found.pieces[2].placed
    assert found.pieces[2].match.status is Status.FOREIGN


def test_what_fits_all_around_is_refused_with_the_reason() -> None:
    """A piece of a plain tube belongs, but nothing says where."""
    tube = trimesh.creation.cylinder(radius=1.0, height=3.0, sections=60)
    tube = trimesh.Trimesh(*trimesh.remesh.subdivide_to_size(tube.vertices, tube.faces, 0.15))
    middles = tube.vertices[tube.faces].mean(axis=1)
    full = TriangleMesh(tube.vertices, tube.faces)
    piece, _ = full.submesh((middles[:, 0] > 0.2) & (np.abs(middles[:, 2]) < 0.9))
    (answer,) = sherd.assemble(full, [piece], rigid=True).pieces
    assert not answer.placed
    assert "in several places" in answer.reason


def test_a_place_is_sure_if_nothing_else_fits_as_closely() -> None:
    near, far = 0.0002, 0.0015
    assert rigid_chance(near, [far, far], TOLERANCE) > 0.95
    assert rigid_chance(near, [near, far], TOLERANCE) > 0.95  # its twin: the joint choice decides
    assert rigid_chance(near, [near, near, far], TOLERANCE) < 0.05  # a plain vase, all around
    assert rigid_chance(far, [1.1 * far, 1.2 * far], TOLERANCE) < 0.05
    assert rigid_chance(0.5 * TOLERANCE, [], TOLERANCE) < 0.05
