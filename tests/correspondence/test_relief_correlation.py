"""Relief: kept by a pose, lost when a surface is laid somewhere else."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from sherd.correspondence.shared.relief_correlation import alike_in_form, alike_in_relief
from sherd.descriptors.relief import form, relief
from sherd.mesh.surface_points import SurfacePoints, closest_points, points_at_vertices
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.puzzle.pairwise.join_chance import UNLIKE
from sherd.shapes import creature


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
    question = SimpleNamespace(part=surfaces[0], full=surfaces[1])
    place = SimpleNamespace(
        trip=SimpleNamespace(points=points), shared=np.full(here.vertex_count, shared)
    )
    return question, place


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
