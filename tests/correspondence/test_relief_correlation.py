"""Relief: kept by a pose, lost when a surface is laid somewhere else."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from sherd.arrays import Floats
from sherd.correspondence.shared import relief_correlation
from sherd.correspondence.shared.accident import independent_places
from sherd.correspondence.shared.relief_correlation import (
    alike_in,
    alike_in_form,
    alike_in_relief,
    alike_where_laid,
    concordance_in,
)
from sherd.descriptors.relief import curvatures, form, relief
from sherd.mesh.surface_finder import SurfaceFinder
from sherd.mesh.surface_points import SurfacePoints, closest_points, points_at_vertices
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.puzzle.pairwise.join_chance import UNLIKE
from sherd.shapes import creature
from sherd.spectral.diffusion import diffused


def unit(mesh: TriangleMesh) -> TriangleMesh:
    return mesh.with_vertices(mesh.vertices / mesh.length)


@pytest.fixture(scope="module")
def poses() -> tuple[TriangleMesh, TriangleMesh]:
    return unit(creature(5000)), unit(creature(5000, pose="walk"))


def laid(
    here: TriangleMesh, there: TriangleMesh, points: SurfacePoints, *, shared: bool = True
) -> tuple[Any, Any]:
    """A question and its placement, as far as relief asks."""
    surfaces = [
        SimpleNamespace(mesh=mesh, cut_distance=np.ones(mesh.vertex_count))
        for mesh in (here, there)
    ]
    surfaces[0].dense = SimpleNamespace(vertices=np.arange(0, here.vertex_count, SPARED))
    question = SimpleNamespace(part=surfaces[0], full=surfaces[1])
    place = SimpleNamespace(
        trip=SimpleNamespace(points=points), shared=np.full(here.vertex_count, shared)
    )
    return question, place


# Every fifth vertex is a place that may count.
SPARED = 5
HALF_TURN = np.array([1.0, -1.0, -1.0])


def likeness(
    first: TriangleMesh,
    second: TriangleMesh,
    *,
    turned: bool = False,
    shared: bool = True,
    alike: Callable[..., float] = alike_in_relief,
) -> float:
    """Of two poses of one mesh, each in its place on the other or turned about the long axis."""
    both = []
    for here, there in ((first, second), (second, first)):
        center = there.vertices.mean(axis=0)
        turn = HALF_TURN if turned else np.ones(3)
        places = closest_points(there, (there.vertices - center) * turn + center)
        both.append(laid(here, there, places, shared=shared))
    questions, placements = zip(*both, strict=True)
    return alike(questions, placements)


def test_a_pose_keeps_its_relief_and_another_place_has_another_one(poses) -> None:
    assert likeness(*poses) > 2 * UNLIKE
    assert likeness(*poses, turned=True) < UNLIKE


def test_a_mirror_image_has_the_same_relief(poses) -> None:
    mesh = poses[0]
    turned = TriangleMesh(mesh.vertices * [-1.0, 1.0, 1.0], mesh.faces[:, ::-1])
    np.testing.assert_allclose(relief(turned), relief(mesh), atol=1e-6)
    assert likeness(mesh, mesh) == pytest.approx(1.0)


def test_form_is_kept_by_a_pose_and_lost_elsewhere(poses) -> None:
    there = likeness(*poses, alike=alike_in_form)
    assert there > 0.6
    assert likeness(*poses, turned=True, alike=alike_in_form) < 0.5 * there


def test_form_is_positive_where_a_surface_bulges_and_knows_no_side(poses) -> None:
    mesh = poses[0]
    turned = TriangleMesh(mesh.vertices * [-1.0, 1.0, 1.0], mesh.faces[:, ::-1])
    np.testing.assert_allclose(form(turned), form(mesh), atol=1e-6)
    tip = np.linalg.norm(mesh.vertices - mesh.vertices.mean(axis=0), axis=1).argmax()
    assert form(mesh)[tip] > 0


def test_what_shares_nothing_is_not_alike(poses) -> None:
    assert likeness(*poses, shared=False) == 0.0
    assert likeness(*poses, shared=False, alike=alike_in_form) == 0.0


def test_one_vertex_that_is_shared_says_nothing(poses) -> None:
    mesh = poses[0]
    question, place = laid(mesh, mesh, points_at_vertices(mesh, np.arange(mesh.vertex_count)))
    place.shared = np.arange(mesh.vertex_count) == 7
    assert alike_in_relief((question, question), (place, place)) == 0.0


def alike_laid_at(here: TriangleMesh, there: TriangleMesh, positions: Floats) -> float | None:
    question, _ = laid(here, there, points_at_vertices(there, np.arange(there.vertex_count)))
    question.full.finder = SurfaceFinder(there)
    return alike_where_laid(question, SimpleNamespace(positions=positions))


def test_what_is_laid_whole_is_as_alike_as_what_shares_all(poses) -> None:
    here, there = poses
    center = there.vertices.mean(axis=0)
    turned = (there.vertices - center) * HALF_TURN + center
    assert alike_laid_at(here, there, there.vertices) == pytest.approx(likeness(*poses), abs=0.05)
    assert alike_laid_at(here, there, turned) < UNLIKE


def test_what_lies_at_cuts_only_is_not_judged_by_its_relief(poses, monkeypatch) -> None:
    monkeypatch.setattr(
        relief_correlation, "seen_area", lambda *_: np.zeros(len(poses[0].vertices))
    )
    assert alike_laid_at(*poses, poses[1].vertices) is None


@pytest.fixture(scope="module")
def itself(poses) -> tuple[Any, Any]:
    """A mesh in its place on itself, both ways."""
    mesh = poses[0]
    question, place = laid(mesh, mesh, points_at_vertices(mesh, np.arange(mesh.vertex_count)))
    return (question, question), (place, place)


def test_curvatures_are_kept_by_a_pose_in_size_as_well(poses) -> None:
    mesh = poses[0]
    for own, other in zip(*(curvatures(pose) for pose in poses), strict=True):
        question, place = laid(*poses, points_at_vertices(poses[1], np.arange(mesh.vertex_count)))
        back, home = laid(*poses[::-1], points_at_vertices(mesh, np.arange(mesh.vertex_count)))
        assert concordance_in((own, other), (question, back), (place, home)) > 0.85


@pytest.mark.parametrize(
    ("change", "most"), [(lambda values: values + 2.0, 0.5), (lambda values: 0.1 * values, 0.5)]
)
def test_who_has_more_everywhere_is_not_the_same(itself, change, most: float) -> None:
    """Ranks among one's own are the same, those among both are not."""
    rng = np.random.default_rng(0)
    values = rng.normal(size=itself[1][0].shared.size) + 1.0
    assert concordance_in((values, values), *itself) == pytest.approx(1.0)
    assert alike_in((values, change(values)), *itself) == pytest.approx(1.0)
    assert concordance_in((values, change(values)), *itself) < most


def test_what_is_the_same_everywhere_says_nothing(itself) -> None:
    flat = np.zeros(itself[1][0].shared.size)
    assert concordance_in((flat, flat), *itself) == 0.0


def test_the_smoother_two_surfaces_are_the_fewer_places_say_something(poses, itself) -> None:
    """Correlations of noise of so many independent places scatter as far as the count says."""
    rng = np.random.default_rng(1)
    noise = rng.normal(size=(poses[0].vertex_count, 20))

    def count(fields: Floats) -> float:
        pairs = zip(fields.T[::2], fields.T[1::2], strict=True)
        return float(np.mean([independent_places(pair, *itself) for pair in pairs]))

    counts = [count(diffused(poses[0], noise, width)) for width in (0.02, 0.05, 0.12)]
    assert 3.0 < counts[2] < 0.5 * counts[1] < 0.25 * counts[0]
    smooth = diffused(poses[0], noise, 0.05)
    found = [alike_in(pair, *itself) for pair in zip(smooth.T[::2], smooth.T[1::2], strict=True)]
    assert np.std(found) * np.sqrt(counts[1]) == pytest.approx(1.0, abs=0.5)


def test_no_place_counts_twice(poses, itself) -> None:
    rng = np.random.default_rng(2)
    first, second = rng.normal(size=(2, poses[0].vertex_count))
    places = len(itself[0][0].part.dense.vertices)
    assert 0.3 * places < independent_places((first, second), *itself) <= places


def test_where_nothing_is_shared_no_place_counts(poses) -> None:
    mesh = poses[0]
    points = points_at_vertices(mesh, np.arange(mesh.vertex_count))
    question, place = laid(mesh, mesh, points, shared=False)
    values = np.arange(float(mesh.vertex_count))
    assert independent_places((values, values), (question, question), (place, place)) == 0.0
    assert concordance_in((values, values), (question, question), (place, place)) == 0.0
