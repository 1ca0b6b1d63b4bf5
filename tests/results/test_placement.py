"""Placement: arrays that belong together, read-only, checked at the door."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from sherd.errors import InvalidMeshError
from sherd.mesh.surface_points import SurfacePoints
from sherd.results.placement import Placement

HALF = np.array([[0.5, 0.5, 0.0], [0.0, 0.0, 1.0]])
TWO = SurfacePoints([3, 4], HALF)
REGION = {"mask": [True, False, False], "membership": [0.9, 0.2, 0.0], "score": 0.5}


def placed(**changes: object) -> Placement:
    given = {"points": TWO, "matched": [True, False], "confidence": [0.9, 0.1]}
    return Placement(**{**REGION, **given, **changes})


def test_arrays_are_kept_read_only() -> None:
    found = placed()
    assert len(found.points) == 2
    assert found.points.barycentric.tolist() == HALF.tolist()
    assert found.matched.tolist() == [True, False]
    for name in ("mask", "membership", "matched", "confidence"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(found, name)[0] = 1
    given = np.array([0.9, 0.1])
    kept = placed(confidence=given)
    given[0] = 0.0
    assert kept.confidence[0] == 0.9


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"matched": [True]}, r"matched has shape \(1,\), but there are 2 points"),
        ({"confidence": [0.5] * 3}, r"confidence has shape \(3,\), but there are 2 points"),
        ({"points": None}, "but there are 0 points"),
        ({"confidence": [0.9, 1.1]}, "confidence must lie in"),
        ({"confidence": [0.9, -0.1]}, "confidence must lie in"),
        ({"confidence": [0.9, np.nan]}, "confidence must lie in"),
        ({"membership": [0.9]}, r"mask has shape \(3,\) and membership \(1,\)"),
        ({"mask": [[True]], "membership": [[1.0]]}, r"but both must be \(n_full,\)"),
    ],
)
def test_wrong_rows_are_named(changes: dict[str, object], message: str) -> None:
    with pytest.raises(InvalidMeshError, match=message):
        placed(**changes)


def test_what_was_not_asked_is_none() -> None:
    region = Placement(**REGION)
    assert (region.points, region.matched, region.confidence) == (None, None, None)
    assert not region.mirrored


def test_names_and_words() -> None:
    assert Placement(**REGION).name == "elsewhere"
    twin = Placement(**REGION, mirrored=True)
    assert twin.name == "mirrored twin"
    assert repr(twin) == "Placement(score 0.500, mirrored, 1 of 3 vertices)"
    assert "mirrored" not in repr(placed())


def test_pickled_it_is_the_same() -> None:
    found = placed(mirrored=True)
    again = pickle.loads(pickle.dumps(found))  # noqa: S301  our own bytes
    for name in ("mask", "membership", "matched", "confidence"):
        one, other = getattr(found, name), getattr(again, name)
        np.testing.assert_array_equal(one, other)
        assert one.dtype == other.dtype
    np.testing.assert_array_equal(again.points.faces, TWO.faces)
    np.testing.assert_array_equal(again.points.barycentric, TWO.barycentric)
    assert (again.score, again.mirrored) == (0.5, True)
