"""A part that fits in two places alike is never called good, and landmarks decide."""

from __future__ import annotations

import numpy as np
import pytest

from sherd import Status, match
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.match_result import MatchResult
from sherd.shapes import Fragment, creature, cut_by_ball, whole


@pytest.fixture(scope="module")
def body() -> TriangleMesh:
    return creature(5000)


@pytest.fixture(scope="module")
def two_bodies(body) -> TriangleMesh:
    """The same animal twice in one file."""
    beside = body.vertices + np.array([3.0 * body.length, 0.0, 0.0])
    return TriangleMesh(
        np.concatenate([body.vertices, beside]),
        np.concatenate([body.faces, body.faces + body.vertex_count]),
    )


@pytest.fixture(scope="module")
def part(body) -> Fragment:
    return cut_by_ball(whole(creature(5000, pose="walk"), body), 0, 0.5)


@pytest.fixture(scope="module")
def found(two_bodies, part) -> MatchResult:
    return match(two_bodies, part.mesh)


def test_a_part_of_one_of_two_like_bodies_is_doubtful_and_says_why(found) -> None:
    assert found.status is Status.DOUBTFUL
    assert "fits about as well in another place" in found.advice
    assert found.chance < 0.5


def test_the_other_place_is_the_first_alternative(found, body) -> None:
    other = found.alternatives[0]
    assert other.name == "elsewhere"
    assert not (other.mask & found.best.mask).any()
    apart = np.linalg.norm(other.points.positions(found.full) - found.positions, axis=1)
    assert apart.min() > 2.0 * body.length


def test_no_vertex_is_surer_than_that_it_lies_on_one_of_both(found) -> None:
    assert found.confidence.max() <= 0.5


def test_a_landmark_decides_between_two_like_bodies(two_bodies, body, part) -> None:
    vertex = int(part.truth.nearest_vertices(body)[0])
    for first in (0, body.vertex_count):
        found = match(two_bodies, part.mesh, landmarks=[(0, first + vertex)])
        assert found.status is Status.GOOD, found.advice
        assert (found.nearest_vertices >= first).all()
        assert (found.nearest_vertices < first + body.vertex_count).all()


def test_a_part_with_one_place_has_no_rival(body, part) -> None:
    found = match(body, part.mesh)
    assert found.status is Status.GOOD
    assert all(other.mirrored for other in found.alternatives)
