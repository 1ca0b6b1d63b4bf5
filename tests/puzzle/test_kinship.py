"""Kinship: skin with bumps of its own, as on the pieces of one animal, in any poses."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.puzzle.growing.kinship import KIN, Kinship
from sherd.shapes import creature, puzzle_pieces
from sherd.surface.prepared import described_part

COUNT = 3


def rough(mesh: TriangleMesh, seed: int) -> np.ndarray:
    """Heights (n,) of bumps and hollows of the standing animal, some two edges wide."""
    rng = np.random.default_rng(seed)
    at = rng.choice(mesh.vertex_count, 400, replace=False)
    heights = 0.012 * mesh.length * rng.normal(size=len(at))
    width = 0.03 * mesh.length
    away = np.linalg.norm(mesh.vertices[:, None] - mesh.vertices[at], axis=2)
    return np.exp(-0.5 * (away / width) ** 2) @ heights


def cut(skin: Callable[[TriangleMesh], np.ndarray] | None) -> tuple[list[TriangleMesh], float]:
    """Pieces of the animal, each in another pose, and sqrt(area) of it."""
    full = creature(5000)
    height = np.zeros(full.vertex_count) if skin is None else skin(full)
    poses = [creature(5000, pose=pose) for pose in ("walk", "stand", "sit")]
    rough_poses = [
        each.with_vertices(each.vertices + height[:, None] * each.vertex_normals) for each in poses
    ]
    pieces = puzzle_pieces(full, rough_poses, overlap=0.3)
    return [piece.mesh for piece in pieces], full.length


def kinship(*puzzles: tuple[list[TriangleMesh], float]) -> Kinship:
    """Of the pieces of all, numbered in a row."""
    pieces = [(mesh, length) for meshes, length in puzzles for mesh in meshes]
    return Kinship(lambda number: described_part(*pieces[number]))


@pytest.fixture(scope="module")
def kin() -> Kinship:
    """Three pieces of one animal, and three of another with other bumps."""
    return kinship(cut(lambda mesh: rough(mesh, 0)), cut(lambda mesh: rough(mesh, 1)))


def test_pieces_with_one_skin_are_kin(kin: Kinship) -> None:
    assert all(kin.of([k], {0, 1, 2} - {k}) >= KIN for k in range(COUNT))
    assert kin.of([0, 1], [2]) >= KIN


def test_bumps_of_another_one_are_nobodys(kin: Kinship) -> None:
    assert all(kin.of([k], range(COUNT)) < KIN for k in range(COUNT, 2 * COUNT))


def test_smooth_skin_tells_nothing() -> None:
    assert kinship(cut(None)).of([0], [1]) == 0.0
