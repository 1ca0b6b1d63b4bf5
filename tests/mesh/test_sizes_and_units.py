"""A part of an impossible size is refused, and the units that would explain it are named."""

from __future__ import annotations

import pytest

from sherd.errors import InfeasibleError
from sherd.mesh.sizes import check_sizes
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.mesh.units import MISTAKEN, likely_units, unit_factor, units_of_two

FULL = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], name="full")


def part(length: float) -> TriangleMesh:
    return TriangleMesh(length * FULL.vertices, FULL.faces, name="part")


@pytest.mark.parametrize(
    ("pair", "ratio"),
    list(zip(MISTAKEN, (1000, 100, 10, 25.4, 39.37, 304.8, 3.281), strict=True)),
)
def test_units_are_as_far_apart_as_everybody_knows(pair, ratio) -> None:
    assert 1 / unit_factor(*pair) == pytest.approx(ratio, rel=1e-4)
    # a part of half the length in the smaller unit, and the other way round
    assert pair in likely_units(0.9 * ratio)
    assert pair[::-1] in likely_units(0.25 / ratio)


@pytest.mark.parametrize("ratio", [0.2, 0.5, 1.0, 1.1, 1e5, 1e-6])
def test_sizes_that_agree_or_that_nothing_explains_propose_nothing(ratio: float) -> None:
    assert likely_units(ratio) == ()


def test_the_message_says_what_to_type() -> None:
    with pytest.raises(InfeasibleError) as caught:
        check_sizes(FULL, part(700), options=True)
    said = str(caught.value)
    assert "part is in millimeters and the full shape in meters" in said
    assert 'part_unit="mm", full_unit="m" (--part-unit mm --full-unit m)' in said
    with pytest.raises(InfeasibleError, match=r"multiply the vertices of the part by 0\.001"):
        check_sizes(FULL, part(700))  # where there is no such option
    with pytest.raises(InfeasibleError, match='part_unit="m", full_unit="mm"'):
        check_sizes(FULL, part(0.0007), options=True)


def test_what_was_typed_is_not_proposed_again() -> None:
    check_sizes(FULL, part(700), factor=0.001, options=True)
    with pytest.raises(InfeasibleError, match="multiplied by 10") as caught:
        check_sizes(FULL, part(70), factor=10.0, options=True)
    assert "would fit" not in str(caught.value)


@pytest.mark.parametrize(("one", "other"), [(0.8, 1000.0), (1.2, 1000.0), (1000.0, 1.2)])
def test_of_two_pieces_either_may_be_the_larger_one(one, other) -> None:
    said = units_of_two("this", "that", one / other)
    assert ("this is in meters and that in millimeters" in said) == (one < other)
    assert "0.001" in said
    assert "1000" in said


def test_sizes_that_no_units_explain_are_left_at_that() -> None:
    assert units_of_two("this", "that", 1.0e-9) == ""
