"""Who looks like a part of a body, or its mirror image does, belongs to it wherever it lies."""

from __future__ import annotations

import pytest

from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.puzzle.growing.belonging import chance_as_a_part
from sherd.puzzle.pairwise import body as body_module
from sherd.puzzle.pairwise.answer import LIKELY
from sherd.puzzle.pairwise.body import Body
from sherd.shapes import creature, cut_by_ball, landmarks, whole
from sherd.shapes.fragment import cut_by_level
from sherd.spectral.geodesics import Geodesics


@pytest.fixture(scope="module")
def body() -> Body:
    """Stands, and lacks its left foreleg."""
    full = creature(5000)
    away = Geodesics(full).distances_from([landmarks(full)["left_front_hoof"]])[0]
    return Body(cut_by_level(whole(full, full), away - 0.5).mesh, 0)


def limb(name: str) -> TriangleMesh:
    """Of the same body, walking."""
    full = creature(5000)
    return cut_by_ball(whole(creature(5000, pose="walk"), full), landmarks(full)[name], 0.5).mesh


def test_a_leg_whose_twin_a_body_has_is_a_part_of_it(body: Body) -> None:
    assert chance_as_a_part(body, limb("left_front_hoof")) > LIKELY


def test_so_is_what_the_body_has(body: Body) -> None:
    assert chance_as_a_part(body, limb("tail_tip")) > LIKELY


def test_what_is_of_another_kind_is_none(body: Body, bottle: TriangleMesh) -> None:
    assert chance_as_a_part(body, bottle) < LIKELY


def test_nor_is_what_is_larger_than_the_body(body: Body) -> None:
    larger = creature(5000)
    assert chance_as_a_part(body, larger.with_vertices(3.0 * larger.vertices)) == 0.0


def test_what_is_folded_where_it_lies_is_none(body: Body, monkeypatch) -> None:
    monkeypatch.setattr(body_module, "log_odds_against", lambda placement, alike: -6.0)
    assert chance_as_a_part(body, limb("tail_tip")) < LIKELY
