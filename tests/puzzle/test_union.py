"""Unions: two overlapping pieces of the generated animal as one surface, and maps between them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sherd.mesh.border_loops import border_loops
from sherd.mesh.topology import component_labels
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.puzzle.growing.common_places import crowding, laid_alike, left_out, lying_in, recalled
from sherd.puzzle.growing.joined_maps import direct_maps
from sherd.puzzle.growing.union import Join, Union, repaired, united
from sherd.puzzle.pairwise.answer import Meeting
from sherd.puzzle.pairwise.meeting import free_vertices, pair_question
from sherd.results.advice import SURE
from sherd.shapes import creature, cut_by_ball, landmarks, moved, whole
from sherd.shapes.fragment import Fragment


@pytest.fixture(scope="module")
def pieces() -> tuple[Fragment, Fragment]:
    """The front standing and the rear walking: together all, and a belt twice."""
    rng = np.random.default_rng(3)
    full, walking = creature(5000), creature(5000, pose="walk")
    marks = landmarks(full)
    front = cut_by_ball(whole(full, full), marks["nose"], 0.85)
    rear = moved(cut_by_ball(whole(walking, full), marks["tail_tip"], 1.05), rng)
    return front, rear


@pytest.fixture(scope="module")
def met(pieces) -> Meeting:
    """Asked in units of the whole, which is larger than both."""
    return pair_question(pieces[0].mesh, pieces[1].mesh, 0, unit=pieces[0].full.length).in_full()


@pytest.fixture(scope="module")
def join(pieces, met) -> Join:
    alone = [Union.of_piece(piece.mesh, number) for number, piece in enumerate(pieces)]
    return Join(alone[0], alone[1], met)


def test_pieces_that_overlap_surely_belong_together(met) -> None:
    assert met.chance > SURE


def test_the_unit_is_that_of_the_whole_as_far_as_it_is_known(pieces, met) -> None:
    assert met.unit == pieces[0].full.length
    assert met.questions[0].full.placed.length * met.unit == pytest.approx(
        pieces[0].mesh.length, rel=0.02
    )


def test_the_union_is_about_as_large_as_both_together(pieces, join) -> None:
    union = united(join)
    full = pieces[0].full
    covered = pieces[0].region | pieces[1].region
    assert union.members == (0, 1)
    assert union.mesh.area == pytest.approx(float(full.vertex_areas @ covered), rel=0.1)
    # every vertex knows where on its own piece it is from
    for number, piece in enumerate(pieces):
        own = union.places[union.owner == number]
        low, high = piece.mesh.vertices.min(axis=0), piece.mesh.vertices.max(axis=0)
        assert (own >= low - 0.05).all()
        assert (own <= high + 0.05).all()


def test_a_vertex_in_which_sheets_met_keeps_its_name_on_each() -> None:
    corners = [[1, 0, 0], [0, 1, 0], [0, 0, 0], [-1, 0, 0], [0, -1, 0]]
    joint = TriangleMesh(corners, [[2, 0, 1], [2, 3, 4]])
    union = repaired(Union(joint, np.array([0, 0, 1, 1, 1]), joint.vertices, (0, 1)))
    assert union.mesh.vertex_count == 6
    assert np.array_equal(union.places, union.mesh.vertices)
    assert union.owner[(union.mesh.vertices == 0).all(axis=1)].tolist() == [1, 1]


def test_where_either_goes_on_the_union_has_no_crack(pieces, join) -> None:
    """It is open where the animal is on neither piece: at two hooves."""
    union, full = united(join), pieces[0].full
    covered = pieces[0].region | pieces[1].region
    missing = full.faces[~covered[full.faces].any(axis=1)]
    labels = component_labels(missing, full.vertex_count)[missing[:, 0]]
    assert len(border_loops(union.mesh.faces)) == len(np.unique(labels)) == 2


def test_what_larger_unions_share_no_more_is_left_out(join) -> None:
    assert left_out(join, join) == 0
    nothing = [replace(each, shared=np.zeros_like(each.shared)) for each in join.met.placements]
    other = Join(join.first, join.second, replace(join.met, placements=tuple(nothing)))
    assert left_out(join, other) == 1
    assert left_out(other, join) == 0


def test_two_on_one_place_lie_on_each_other_as_they_do_there(pieces, join) -> None:
    """The same piece laid twice: each vertex lies on itself."""
    pairs = laid_alike(join, join)
    assert len(pairs) == 4
    rear = pieces[1].mesh.vertices
    apart = np.linalg.norm(rear[pairs[:, 0]] - rear[pairs[:, 1]], axis=1)
    assert apart.max() < 3 * pieces[1].mesh.mean_edge_length


def test_what_both_have_is_mapped_from_each_to_the_other(pieces, join) -> None:
    maps = direct_maps([piece.mesh for piece in pieces], [join])
    assert set(maps) == {(0, 1), (1, 0)}
    for (here, there), found in maps.items():
        own, other = pieces[here], pieces[there]
        at = found.points[found.known].interpolate(other.mesh, other.truth.positions(other.full))
        off = np.linalg.norm(at - own.truth[found.known].positions(own.full), axis=1)
        assert off.mean() < 0.03 * own.full.length
        shared = other.region[own.truth.nearest_vertices(own.full)]
        assert found.known[shared].mean() > 0.7


def test_places_are_recalled_in_the_union(pieces, join) -> None:
    union = united(join)
    alone = join.second
    full = pieces[0].full
    pairs = recalled(join, join.first, alone)
    assert len(pairs) == 4
    on_first = pieces[0].truth[pairs[:, 0]].positions(full)
    on_second = pieces[1].truth[pairs[:, 1]].positions(full)
    assert np.linalg.norm(on_first - on_second, axis=1).max() < 0.06 * full.length
    again = recalled(join, Union(union.mesh, union.owner, union.places, (0,)), alone)
    places = union.places[again[:, 0]]
    own = pieces[0].mesh.vertices[pairs[: len(again), 0]]
    assert np.linalg.norm(places - own, axis=1).max() < 0.1 * full.length


def test_what_is_known_of_places_that_are_taken_does_not_count(pieces, join) -> None:
    """Half of what is recalled lies where another piece does by now."""
    known = recalled(join, join.first, join.second)
    assert len(known) > 1
    front = pieces[0].mesh
    along = front.vertices[known[:, 0]].mean(axis=0)
    beside = front.vertices - along
    taken = beside @ (beside[known[0, 0]] - beside[known[-1, 0]]) > 0
    assert 0 < taken[known[:, 0]].sum() < len(known)
    question = pair_question(front, pieces[1].mesh, 0, known, taken)
    asked = question.problems[0].question
    assert 0 < len(asked.pins.landmarks) < len(known)
    free = free_vertices(question.described[0], front, taken)
    found = question.labelings.forward
    labeled = question.problems[0].labels.vertices[found.labels[found.placed]]
    assert free[labeled].all()
    assert 0 <= question.at_a_glance().chance <= 1


def test_who_lies_in_the_same_place_crowds_whole_or_in_part(join) -> None:
    """The same answer, and one that shares half of it: by area, whichever comes first."""
    question, place = join.met.questions[0], join.met.placements
    there = place[1].shared
    height = question.full.mesh.vertices @ np.array([1.0, 0.0, 0.0])
    lower = there & (height < np.median(height[there]))
    half = replace(place[1], shared=lower)
    smaller = replace(join, met=replace(join.met, placements=(place[0], half)))
    nothing = replace(place[1], shared=np.zeros_like(there))
    empty = replace(join, met=replace(join.met, placements=(place[0], nothing)))
    assert crowding(join, join) == pytest.approx(1.0)
    assert crowding(join, smaller) == crowding(smaller, join) == pytest.approx(1.0)
    upper = replace(place[1], shared=there & ~lower)
    other = replace(join, met=replace(join.met, placements=(place[0], upper)))
    assert crowding(smaller, other) == crowding(other, smaller) < 0.5
    assert crowding(join, empty) == crowding(empty, join) == 0.0
    # but only of the smaller one it is the whole place
    assert lying_in(smaller, join) == pytest.approx(1.0)
    assert 0.3 < lying_in(join, smaller) < 0.8
    assert lying_in(join, empty) == lying_in(empty, join) == 0.0
