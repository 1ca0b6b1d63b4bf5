"""Unions: two overlapping pieces of the generated animal as one surface, and maps between them."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.puzzle.growing.answer import Meeting
from sherd.puzzle.growing.joined_maps import direct_maps
from sherd.puzzle.growing.meeting import meeting
from sherd.puzzle.growing.union import Join, Union, recalled, united
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
    return meeting(pieces[0].mesh, pieces[1].mesh, 0)


@pytest.fixture(scope="module")
def join(pieces, met) -> Join:
    alone = [Union.of_piece(piece.mesh, number) for number, piece in enumerate(pieces)]
    return Join(alone[0], alone[1], met)


def test_pieces_that_overlap_surely_belong_together(met) -> None:
    assert met.chance > SURE


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
    again = meeting(front, pieces[1].mesh, 0, known, taken)
    assert 0 <= again.chance <= 1
