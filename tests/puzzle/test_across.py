"""The last limb lies across from its twin, if its mirror image lies on that."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.puzzle.growing.across import MOST_ACROSS, laid_across, on_its_twin
from sherd.puzzle.pairwise.answer import JOINED
from sherd.puzzle.pairwise.body import Body, Lying
from sherd.shapes import Fragment, creature, cut_by_ball, landmarks, whole
from sherd.shapes.fragment import cut_by_level
from sherd.spectral.geodesics import Geodesics
from sherd.surface.transformed import mirrored_mesh


@cache
def body_without_a_leg() -> Fragment:
    full = creature(5000)
    away = Geodesics(full).distances_from([landmarks(full)["left_front_hoof"]])[0]
    return cut_by_level(whole(full, full), away - 0.3)


@cache
def walking(name: str, radius: float = 0.55) -> Fragment:
    full = creature(5000)
    return cut_by_ball(whole(creature(5000, pose="walk"), full), landmarks(full)[name], radius)


def test_a_leg_whose_mirror_image_lies_on_its_twin_is_laid_across_from_that() -> None:
    body, leg = body_without_a_leg(), walking("left_front_hoof")
    met = laid_across(Body(body.mesh, 0), leg.mesh)
    assert met is not None
    # likely, but another animal's leg would lie there as well
    assert met.chance == pytest.approx(MOST_ACROSS)
    question, place = met.questions[0], met.placements[0]
    full = creature(5000)
    length = full.length
    here = cKDTree(question.part.placed.vertices).query(question.part.mesh.vertices)[1]
    there = place.trip.points.nearest_vertices(question.full.mesh)
    on = cKDTree(question.full.placed.vertices).query(question.full.mesh.vertices[there])[1]
    off = body.truth.positions(full)[on] - leg.truth.positions(full)[here]
    error = np.linalg.norm(off, axis=1)[place.shared] / length
    assert error.mean() < 0.02
    # of the leg the body has what is farther from its hoof than 0.3 of 0.55
    assert 0.5 < np.average(place.shared, weights=question.part.mesh.vertex_areas) < 0.95


def test_what_the_body_has_lies_within_it_and_not_across() -> None:
    body = Body(body_without_a_leg().mesh, 0)
    assert laid_across(body, walking("right_front_hoof").mesh) is None
    assert laid_across(body, walking("tail_tip", 0.4).mesh) is None


def test_what_is_no_limb_lies_nowhere(bottle) -> None:
    assert laid_across(Body(body_without_a_leg().mesh, 0), bottle) is None


@pytest.mark.parametrize(
    ("as_it_is", "covered", "stands"),
    [(0.7, 0.2, True), (0.9, 0.2, False), (None, 0.2, True), (0.7, 1.0, False)],
)
def test_what_lies_there_as_it_is_or_covers_the_body_is_no_mirror_image_of_a_limb(
    as_it_is, covered, stands, monkeypatch
) -> None:
    body = body_without_a_leg().mesh
    mask = np.arange(body.vertex_count) < covered * body.vertex_count
    image: Any = SimpleNamespace(best=SimpleNamespace(score=0.8, mask=mask), twin_score=as_it_is)

    def matched(first: Body, second: TriangleMesh) -> Any:
        assert np.allclose(second.vertices[:, 0], -body.vertices[:, 0])
        return Lying(image, 0.0)

    monkeypatch.setattr(Body, "matched", matched)
    assert (on_its_twin(Body(body, 0), body) is image) == stands


def test_what_cannot_be_matched_has_no_twin() -> None:
    body = Body(body_without_a_leg().mesh, 0)
    larger = body.mesh.with_vertices(3.0 * body.mesh.vertices)
    assert body.matched(larger) is None
    assert on_its_twin(body, larger) is None


def test_a_mirror_image_is_turned_outward() -> None:
    full = creature(5000)
    normals = mirrored_mesh(full).vertex_normals
    assert np.allclose(normals * [-1, 1, 1], full.vertex_normals)


def test_what_is_across_from_a_twin_is_never_sure() -> None:
    assert MOST_ACROSS < JOINED
