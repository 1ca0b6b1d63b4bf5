"""PointMap: one answer per vertex, checked at the door."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.correspondence.confidence import COEFFICIENTS, FEATURES, confidences
from sherd.correspondence.point_map import PointMap
from sherd.errors import InvalidMeshError

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
    calm = np.zeros((1, len(FEATURES)))
    calm[0, 0] = 1.0
    for column in range(1, len(FEATURES)):
        worse = calm.copy()
        worse[0, column] = 0.2
        assert confidences(worse)[0] <= confidences(calm)[0]
