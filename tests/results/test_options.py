"""Options say what they take: masks are masks, vertices are whole numbers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sherd.correspondence.hints import check_hints
from sherd.errors import OptionError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.match_options import MatchOptions
from sherd.scan.intake import mesh_intake

SQUARE = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], [[0, 1, 2], [1, 3, 2]])


@pytest.mark.parametrize(
    "mask",
    [np.array([False, True, False, True]), [False, True, np.bool_(False), True]],
)
def test_a_mask_names_the_vertices_where_it_is_true(mask) -> None:
    options = MatchOptions(ignore=mask)
    assert options.ignore == (1, 3)
    assert all(type(vertex) is int for vertex in options.ignore)


def test_a_mask_of_another_mesh_is_refused_even_through_a_copy() -> None:
    intake = mesh_intake(SQUARE)
    check_hints(intake, intake, MatchOptions(ignore=np.array([True, False, False, False])))
    short = MatchOptions(ignore=np.array([True, False, False]))
    for options in (short, replace(short, seed=1)):
        with pytest.raises(OptionError, match="mask of 3 values, but the part has 4"):
            check_hints(intake, intake, options)


@pytest.mark.parametrize(
    "given",
    [np.array([5, 3]), np.array([5, 3], dtype=np.uint8), [3, np.int32(5)], {5, 3}, range(3, 6, 2)],
)
def test_whole_numbers_of_any_kind_are_vertices(given) -> None:
    assert MatchOptions(ignore=given).ignore == (3, 5)
    assert MatchOptions(landmarks=[list(given)]).landmarks[0] == tuple(given)


@pytest.mark.parametrize(
    "given",
    [[5.0], [np.float64(5)], ["5"], "5", 5, None, [True, 5], [[1, 2]], np.zeros(3), np.array(2),
     [-1]],
)  # fmt: skip
def test_nothing_else_is_ignored(given) -> None:
    with pytest.raises(OptionError, match="ignore"):
        MatchOptions(ignore=given)


@pytest.mark.parametrize(
    "given",
    [[[5.7, 7]], [(5, 7, 9)], [5, 7], [(5, "7")], "57", {5: 7}, [(True, False)], [(5, -7)],
     np.array([[5.0, 7.0]]), None],
)  # fmt: skip
def test_landmarks_are_pairs_of_whole_numbers(given) -> None:
    with pytest.raises(OptionError, match="landmarks"):
        MatchOptions(landmarks=given)


def test_landmarks_may_be_an_array_and_are_stored_as_pairs() -> None:
    assert MatchOptions(landmarks=np.array([[5, 7], [6, 8]])).landmarks == ((5, 7), (6, 8))


@pytest.mark.parametrize("seed", [1.5, "1", None, True, -1])
def test_a_seed_is_a_whole_number(seed) -> None:
    with pytest.raises(OptionError, match="seed"):
        MatchOptions(seed=seed)


@pytest.mark.parametrize(
    "scale", [0, -1, float("nan"), float("inf"), True, "3", "large", None, [2.0]]
)
def test_a_scale_is_a_word_or_a_positive_number(scale) -> None:
    with pytest.raises(OptionError, match='"same", "unknown" or a positive number'):
        MatchOptions(scale=scale)


@pytest.mark.parametrize(
    ("given", "factor"),
    [
        ({}, 1.0),
        ({"scale": 3}, 3.0),
        ({"scale": np.float32(0.5)}, 0.5),
        ({"part_unit": "mm", "full_unit": "m"}, 0.001),
        ({"part_unit": "ft", "full_unit": "in"}, 12.0),
        ({"part_unit": "in", "full_unit": "in", "scale": "unknown"}, 1.0),
    ],
)
def test_units_and_numbers_become_a_factor(given, factor) -> None:
    assert MatchOptions(**given).factor == pytest.approx(factor, rel=1e-12)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"part_unit": "mm"}, "give both or none"),
        ({"full_unit": "mm"}, "give both or none"),
        ({"part_unit": "mm", "full_unit": "km"}, "full_unit is 'km', but must be one of mm, cm"),
        ({"part_unit": "mm", "full_unit": "m", "scale": 2.0}, "give one of them"),
    ],
)
def test_units_that_do_not_fit_together_are_refused(given, message) -> None:
    with pytest.raises(OptionError, match=message):
        MatchOptions(**given)
