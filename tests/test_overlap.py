"""overlap: what two incomplete shapes share, on generated animals whose truth is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh

import sherd
from sherd.benchmark.datasets.cut_pairs import points_on_other_part
from sherd.benchmark.datasets.pairs import Pair
from sherd.benchmark.metrics import region_overlap
from sherd.errors import InfeasibleError, OptionError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.overlap_result import Overlap
from sherd.results.status import Status
from sherd.shapes.creature import creature, landmarks
from sherd.shapes.fragment import Fragment, cut_by_ball, cut_by_level, moved, whole


@pytest.fixture(scope="module")
def fragments() -> tuple[Fragment, Fragment]:
    """The front of the standing animal, and all but the head of the walking one."""
    full = creature(5000)
    nose = landmarks(full)["nose"]
    front = cut_by_ball(whole(full, full), nose, 0.85)
    walking = whole(creature(5000, pose="walk"), full)
    near = cut_by_ball(walking, nose, 0.35).region
    faces = ~near[walking.mesh.faces].any(axis=1)
    mesh, kept = walking.mesh.submesh(faces)
    rear = replace(walking, mesh=mesh, truth=walking.truth[kept], present=walking.present[kept])
    return front, moved(rear, np.random.default_rng(3))


@pytest.fixture(scope="module")
def answer(fragments: tuple[Fragment, Fragment]) -> Overlap:
    return sherd.overlap(fragments[0].mesh, fragments[1].mesh)


def as_pair(fragment: Fragment) -> Pair:
    return Pair("", fragment.full, fragment.mesh, fragment.truth, None)


def test_what_is_shared_is_found_on_both_with_its_points(fragments, answer) -> None:
    front, rear = fragments
    truth, on_rear = points_on_other_part(as_pair(front), as_pair(rear))
    _, on_front = points_on_other_part(as_pair(rear), as_pair(front))
    assert region_overlap(front.mesh, answer.first_to_second.matched, on_front) > 0.88
    assert region_overlap(rear.mesh, answer.second_to_first.matched, on_rear) > 0.88
    rows = np.flatnonzero(on_rear)
    there = answer.second_to_first.points[rows].positions(front.mesh)
    off = np.linalg.norm(there - truth[rows].positions(front.mesh), axis=1) / front.full.length
    assert off.mean() < 0.015


def test_there_and_back_is_one_answer(answer) -> None:
    check = answer.check()
    assert check.passed
    assert check.there_and_back < 0.5


def test_swapping_the_shapes_swaps_the_answer(fragments, answer) -> None:
    swapped = sherd.overlap(fragments[1].mesh, fragments[0].mesh)
    for one, other in (
        (answer.first_to_second, swapped.second_to_first),
        (answer.second_to_first, swapped.first_to_second),
    ):
        assert np.array_equal(one.matched, other.matched)
        assert np.array_equal(one.points.faces, other.points.faces)
        assert np.allclose(one.points.barycentric, other.points.barycentric)
    assert swapped.chance == pytest.approx(answer.chance)
    assert swapped.curve.first == answer.curve.second


def test_a_front_and_a_rear_that_share_the_middle_are_laid_there() -> None:
    # most of either belongs nowhere, and lies well on the other's legs
    full = creature(5000)
    places = full.vertices - full.vertices.mean(axis=0)
    along = places @ np.linalg.svd(places, full_matrices=False)[2][0]
    order = np.argsort(along)
    share = np.cumsum(full.vertex_areas[order]) / full.area
    until, since = (along[order][np.searchsorted(share, at)] for at in (0.65, 0.35))
    walking = whole(creature(5000, pose="walk"), full)
    front = cut_by_level(whole(full, full), until - along)
    rear = moved(cut_by_level(walking, along - since), np.random.default_rng(3))
    answer = sherd.overlap(front.mesh, rear.mesh)
    truth, on_rear = points_on_other_part(as_pair(front), as_pair(rear))
    assert region_overlap(rear.mesh, answer.second_to_first.matched, on_rear) > 0.88
    rows = np.flatnonzero(on_rear & answer.second_to_first.matched)
    there = answer.second_to_first.points[rows].positions(front.mesh)
    off = np.linalg.norm(there - truth[rows].positions(front.mesh), axis=1) / full.length
    assert off.mean() < 0.03


def test_more_is_shared_the_more_strain_is_accepted(answer) -> None:
    for shares in (answer.curve.first, answer.curve.second):
        assert np.all(np.diff(shares) > -0.01)
        assert 0 <= shares[0] <= shares[-1] <= 1


def test_nothing_shared_is_an_answer(fragments) -> None:
    size = np.linspace(0, 1, 40)
    x, y = np.meshgrid(size, size, indexing="ij")
    grid = np.arange(1600).reshape(40, 40)
    corners = [grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]]
    faces = np.concatenate(
        [
            np.stack([corners[k] for k in three], axis=-1).reshape(-1, 3)
            for three in ((0, 1, 2), (0, 2, 3))
        ]
    )
    bumps = 0.1 * np.sin(9 * x) * np.cos(8 * y)
    vertices = np.stack([x, y, bumps], axis=-1).reshape(-1, 3) * fragments[0].full.length * 0.7
    answer = sherd.overlap(fragments[0].mesh, (vertices, faces))
    assert answer.status is not Status.GOOD
    assert len(answer.second_to_first.points) == 1600
    assert answer.first_to_second.confidence.max() <= 1


def test_what_is_inside_out_is_turned_over_and_numbered_as_it_was(fragments, answer) -> None:
    front, rear = (each.mesh for each in fragments)
    inward = TriangleMesh(front.vertices, front.faces[:, ::-1], name="inward")
    turned = sherd.overlap(inward, rear)
    assert "turned over" in " ".join(turned.notices["first"])
    assert not turned.notices["second"]
    np.testing.assert_array_equal(turned.second_to_first.matched, answer.second_to_first.matched)
    rows = np.flatnonzero(answer.second_to_first.matched)
    there = turned.second_to_first.points[rows].positions(turned.first)
    before = answer.second_to_first.points[rows].positions(front)
    np.testing.assert_allclose(there, before, atol=1e-9 * front.length)


def test_what_stands_apart_is_not_shared_and_all_else_is() -> None:
    full, ball = creature(5000), trimesh.creation.icosphere(3, 0.15)
    scene = TriangleMesh(
        np.concatenate([full.vertices, ball.vertices + 5.0]),
        np.concatenate([full.faces, ball.faces + full.vertex_count]),
    )
    answer = sherd.overlap(scene, creature(5000, pose="walk"))
    assert answer.status is Status.GOOD
    shared = answer.first_to_second.matched
    assert shared[: full.vertex_count].mean() > 0.95
    assert not shared[full.vertex_count :].any()


def test_what_is_ignored_is_not_shared_and_what_does_not_exist_is_refused(fragments) -> None:
    front, rear = fragments
    with pytest.raises(OptionError, match="ignore_first names vertex 99999 of the first shape"):
        sherd.overlap(front.mesh, rear.mesh, ignore_first=[99999])
    with pytest.raises(OptionError, match="landmarks names vertex 99999 of the second shape"):
        sherd.overlap(front.mesh, rear.mesh, landmarks=[(0, 99999)])
    with pytest.raises(InfeasibleError, match="every face of the second shape"):
        sherd.overlap(front.mesh, rear.mesh, ignore_second=np.ones(rear.mesh.vertex_count, bool))
    with pytest.raises(OptionError, match="strain is 0"):
        sherd.OverlapOptions(strain=0.0)


def test_a_dot_beside_the_other_is_refused_and_the_scale_between_units_told(fragments) -> None:
    front, rear = fragments
    small = rear.mesh.with_vertices(rear.mesh.vertices * 1e-3)
    equal = 1e3 * front.mesh.length / rear.mesh.length
    for scale in ("same", "unknown", 1e-1):
        with pytest.raises(InfeasibleError, match="in different units") as refused:
            sherd.overlap(front.mesh, small, scale=scale)
        assert f"{equal:.4g} would make them equally large" in str(refused.value)


def test_a_left_leg_is_not_taken_for_a_right_one() -> None:
    full, walking = creature(5000), creature(5000, pose="walk")
    places = landmarks(full)
    left = cut_by_ball(whole(full, full), places["left_front_hoof"], 0.5).mesh
    right = cut_by_ball(whole(walking, full), places["right_front_hoof"], 0.5).mesh
    answer = sherd.overlap(left, right)
    assert answer.status is not Status.GOOD
    assert "mirror image" in answer.advice
    assert answer.chance < 0.2
