"""Confidence: it falls with every sign of trouble, and two pieces on one place are seen."""

from __future__ import annotations

import numpy as np
import trimesh

from sherd.correspondence.confidence import (
    COEFFICIENTS,
    FEATURES,
    LEAST,
    confidences,
    share_laid_double,
)
from sherd.correspondence.registration import Deformation
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.surface.prepared import described_part


def test_confidence_falls_with_every_sign_of_trouble() -> None:
    assert len(COEFFICIENTS) == len(FEATURES)
    usual = np.array([[1.0, 0.2, 0.2, 0.05, 0.1, 0.2]])
    assert LEAST < confidences(usual)[0] < 0.995
    for column in range(1, len(FEATURES)):
        worse = usual.copy()
        worse[0, column] += 0.1
        assert confidences(worse)[0] < confidences(usual)[0], FEATURES[column]
    assert confidences(100 * usual * [0, 1, 1, 1, 1, 1])[0] == LEAST


def test_two_pieces_on_one_place_are_laid_double() -> None:
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.2)
    count = len(ball.vertices)
    pieces = TriangleMesh(
        np.concatenate([ball.vertices, ball.vertices + np.array([1.0, 0.0, 0.0])]),
        np.concatenate([ball.faces, ball.faces + count]),
    )
    part = described_part(pieces, 1.0)
    turns = np.tile(np.eye(3), (part.mesh.vertex_count, 1, 1))
    apart = part.mesh.vertices
    second = part.mesh.component_labels == 1
    together = apart.copy()
    centers = [apart[second == which].mean(axis=0) for which in (False, True)]
    together[second] += centers[0] - centers[1]
    assert share_laid_double(part, Deformation(apart, turns)) == 0.0
    assert share_laid_double(part, Deformation(together, turns)) == 1.0


def test_a_gap_that_a_camera_left_is_not_laid_double() -> None:
    """Paths around it are long, but both sides lie as near to each other as on the full shape."""
    wide, high, step = 22, 28, 0.015
    grid = np.array([(i * step, j * step, 0.0) for j in range(high) for i in range(wide)])
    cells = [
        (j * wide + i)
        for j in range(high - 1)
        for i in range(wide - 1)
        if i != wide // 2 or j == 0  # a slit, but for its lower end
    ]
    faces = [
        face for c in cells for face in ((c, c + 1, c + wide), (c + 1, c + wide + 1, c + wide))
    ]
    part = described_part(TriangleMesh(grid, faces), 1.0)
    turns = np.tile(np.eye(3), (part.mesh.vertex_count, 1, 1))
    assert share_laid_double(part, Deformation(part.mesh.vertices, turns)) == 0.0


def test_layers_of_a_bone_are_not_laid_double() -> None:
    """Two shells a little apart, that look the same way and have no path from one to the other."""
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.3)
    vertices, count = np.asarray(ball.vertices), len(ball.vertices)
    shells = np.concatenate([vertices, 0.94 * vertices])  # 0.018 apart
    part = described_part(TriangleMesh(shells, np.concatenate([ball.faces, ball.faces + count])), 1)
    turns = np.tile(np.eye(3), (part.mesh.vertex_count, 1, 1))
    assert share_laid_double(part, Deformation(part.mesh.vertices, turns)) == 0.0
