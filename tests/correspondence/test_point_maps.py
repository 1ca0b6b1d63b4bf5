"""PointMap: one answer per vertex, checked at the door."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from sherd.correspondence.confidence import (
    COEFFICIENTS,
    FEATURES,
    LEAST,
    MOST,
    confidences,
    laid_double,
)
from sherd.correspondence.part_data import part_data
from sherd.correspondence.point_map import PointMap
from sherd.correspondence.registration import Placement
from sherd.errors import InvalidMeshError
from sherd.mesh.triangle_mesh import TriangleMesh

HALF = np.array([[0.5, 0.5, 0.0], [0.0, 0.0, 1.0]])


def test_arrays_are_kept_read_only() -> None:
    found = PointMap([3, 4], HALF, [True, False], [0.9, 0.1])
    assert len(found) == 2
    assert found.points.barycentric.tolist() == HALF.tolist()
    with pytest.raises(ValueError, match="read-only"):
        found.confidence[0] = 1.0


@pytest.mark.parametrize(
    ("matched", "confidence", "message"),
    [
        ([True], [0.9, 0.1], "there are 2 points"),
        ([True, True], [0.9, 1.1], "confidence must lie in"),
        ([True, True], [0.9, np.nan], "confidence must lie in"),
    ],
)
def test_wrong_rows_are_named(matched: list[bool], confidence: list[float], message: str) -> None:
    with pytest.raises(InvalidMeshError, match=message):
        PointMap([3, 4], HALF, matched, confidence)


def test_confidence_falls_with_every_sign_of_trouble() -> None:
    assert len(COEFFICIENTS) == len(FEATURES)
    calm = np.eye(1, len(FEATURES))
    assert confidences(calm)[0] == MOST
    # a bit of everything, so that neither end is reached and each sign tells
    doubtful = np.full((1, len(FEATURES)), 0.1)
    doubtful[0, 0] = 1.0
    for column in range(1, len(FEATURES)):
        worse = doubtful.copy()
        worse[0, column] += 0.05
        assert LEAST < confidences(worse)[0] < confidences(doubtful)[0] < MOST
    assert confidences(np.ones((1, len(FEATURES))))[0] == LEAST


def test_two_pieces_on_one_place_are_laid_double() -> None:
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.2)
    count = len(ball.vertices)
    pieces = TriangleMesh(
        np.concatenate([ball.vertices, ball.vertices + np.array([1.0, 0.0, 0.0])]),
        np.concatenate([ball.faces, ball.faces + count]),
    )
    part = part_data(pieces, 1.0)
    turns = np.tile(np.eye(3), (part.mesh.vertex_count, 1, 1))
    apart = part.mesh.vertices
    second = part.mesh.component_labels == 1
    together = apart.copy()
    centers = [apart[second == which].mean(axis=0) for which in (False, True)]
    together[second] += centers[0] - centers[1]
    assert laid_double(part, Placement(apart, turns)) == 0.0
    assert laid_double(part, Placement(together, turns)) == 1.0
