"""Members asked in their own poses: what they surely share is carried to their unions."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from sherd.arrays import Bools, Floats, Ints
from sherd.puzzle.growing import members
from sherd.puzzle.growing.asking import Asking
from sherd.puzzle.growing.members import (
    ask_members,
    carried,
    laid_as_before,
    told_by,
    told_by_members,
)
from sherd.puzzle.growing.record import Growth
from sherd.puzzle.growing.union import Join, Union, united
from sherd.puzzle.pairwise.answer import Meeting
from sherd.puzzle.pairwise.body import Body, Told
from sherd.puzzle.pairwise.join_chance import ends_with_one, fills_a_gap
from sherd.shapes import creature, cut_by_ball, landmarks, whole
from sherd.shapes.fragment import Fragment


@pytest.fixture(scope="module")
def cut(cut_halves: Callable[[float, float], tuple[Fragment, Fragment]]) -> tuple[Fragment, ...]:
    """The front standing, the rear walking, and a hind leg of which only the rear has all."""
    full, walking = creature(5000), creature(5000, pose="walk")
    leg = cut_by_ball(whole(walking, full), landmarks(full)["left_hind_hoof"], 0.45)
    return (*cut_halves(0.85, 1.05), leg)


@pytest.fixture(scope="module")
def halves(laid_truly: Callable[[int, int], Join]) -> Join:
    return laid_truly(0, 1)


@pytest.fixture(scope="module")
def leg(laid_truly: Callable[[int, int], Join]) -> Join:
    return laid_truly(1, 2)


def on_full(cut: tuple[Fragment, ...], union: Union, at: Floats) -> Floats:
    """Where the vertices of a union nearest to positions truly lie on the whole."""
    rows = cKDTree(union.mesh.vertices).query(at)[1]
    places = np.empty((len(rows), 3))
    for number, piece in enumerate(cut):
        own = np.flatnonzero(union.owner[rows] == number)
        nearest = cKDTree(piece.mesh.vertices).query(union.places[rows[own]])[1]
        places[own] = piece.truth.positions(piece.full)[nearest]
    return places


def test_places_are_carried_also_where_a_piece_gave_way(cut, near, halves) -> None:
    union = united(halves)
    rear = cut[1]
    positions, found = carried(
        rear.mesh.vertices, np.full(rear.mesh.vertex_count, 1), union, [halves]
    )
    assert found.mean() > 0.95
    gone = ~np.isin(np.arange(len(found)), _kept(union, rear))
    assert (found & gone).sum() > 50  # the belt that both have is the front's now
    off = on_full(cut, union, positions) - rear.truth.positions(rear.full)
    away = np.linalg.norm(off, axis=1)[found] / rear.full.length
    assert away.mean() < 0.01
    assert np.quantile(away, 0.99) < 2 * near


def _kept(union: Union, piece: Fragment) -> Ints:
    """The vertices of the rear that the union has as its own."""
    places = union.places[union.owner == 1]
    away, nearest = cKDTree(piece.mesh.vertices).query(places)
    return np.unique(nearest[away < 1e-9])


def test_a_union_is_told_what_its_member_knows(cut, alone, halves, leg) -> None:
    union = united(halves)
    told = told_by(leg, union, alone[2], [halves])
    assert told.known.mean() > 0.8
    off = on_full(cut, union, told.positions[told.known])
    off -= cut[2].truth.positions(cut[2].full)[told.known]
    assert np.linalg.norm(off, axis=1).mean() / cut[2].full.length < 0.015


def test_where_a_member_is_sure_the_union_is_joined_there(cut, alone, halves, leg) -> None:
    union, asked = united(halves), []
    growth = replace(Growth.begun(alone), joins=[halves])

    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        asked.append((first.members, second.members))
        return leg.met

    def glance(first: Union, second: Union) -> Any:
        return replace(leg.met, chance=0.6 if first is alone[1] else 0.1)

    asking = Asking(meet, glance, laid, no_twins, no_part, no_image, no_kin)
    assert told_by_members(union, alone[2], asking, growth) is None
    ask_members(union, alone[2], np.ones((3, 3)), asking, growth)
    assert asked == [((1,), (2,))]  # what looks likely at a glance
    assert growth.of_members == {((0,), (2,)): 0.1, ((1,), (2,)): 0.99}
    join = told_by_members(union, alone[2], asking, growth)
    assert join is not None
    assert join.met.chance > 0.9
    assert (join.first, join.second) == (union, alone[2])
    assert join.met.placements[0].shared.mean() > 0.8
    assert [each.met for each in growth.told.values()] == [leg.met]
    # nobody is asked twice
    ask_members(union, alone[2], np.ones((3, 3)), asking, growth)
    assert len(asked) == 1


def test_what_goes_on_all_around_fills_a_gap(halves) -> None:
    met = halves.met
    assert fills_a_gap(met.questions, met.placements)
    left = [q.part.mesh.vertices[:, 2] > 0.0 for q in met.questions]
    half = tuple(
        replace(place, shared=place.shared & side)
        for place, side in zip(met.placements, left, strict=True)
    )
    assert not fills_a_gap(met.questions, half)


def test_who_goes_on_beyond_the_other_crosses_its_border(halves) -> None:
    met = halves.met
    assert ends_with_one(met.questions, met.placements) > 0.95
    inside = tuple(
        replace(place, shared=place.shared & (question.part.cut_distance > 0.0))
        for question, place in zip(met.questions, met.placements, strict=True)
    )
    assert ends_with_one(met.questions, inside) < 0.01


def test_what_lies_within_fills_no_gap(leg) -> None:
    assert not fills_a_gap(leg.met.questions, leg.met.placements)


def test_what_a_union_said_is_laid_on_one_that_has_it(cut, alone, halves, leg) -> None:
    """The leg on the rear alone, and then on the front and the rear; both of one union."""
    union = united(halves)
    growth = replace(Growth.begun(alone), joins=[halves])
    asking = Asking(laid, laid, laid, no_twins, no_part, no_image, no_kin)
    first = laid_as_before(leg, union, alone[2], asking, growth)
    assert first is not None
    again = laid_as_before(first, union, alone[2], asking, growth)
    assert again is not None
    told = told_by(first, union, alone[2], growth.joins)
    assert told.known.mean() > 0.8
    off = on_full(cut, union, told.positions[told.known])
    off -= cut[2].truth.positions(cut[2].full)[told.known]
    assert np.linalg.norm(off, axis=1).mean() / cut[2].full.length < 0.015


def no_part(first: Union, second: Union) -> float:
    """Nothing is asked as a part."""
    return 0.0


def no_kin(numbers: Collection[int], others: Collection[int]) -> float:
    """Nobody has the skin of anybody."""
    return 0.0


def no_image(first: Union, second: Union) -> Meeting:
    """No mirror image is asked here."""
    raise AssertionError("asked of a mirror image")


def no_twins(first: Union, second: Union) -> None:
    """Nothing lies across from anything."""


def laid(first: Union, second: Union, told: Told) -> Any:
    return Body(first.mesh, 0).met(second.mesh, told)


def test_what_evidence_ranks_last_is_not_asked(alone) -> None:
    count = members.MEMBERS + 2
    pieces = [Union.of_piece(alone[0].mesh, number) for number in range(count + 1)]
    union = replace(pieces[0], members=tuple(range(count)))
    evidence = np.add.outer(np.arange(count + 1.0), np.arange(count + 1.0))
    growth = Growth.begun(pieces)
    asked = []

    def glance(first: Union, second: Union) -> Any:
        asked.append(first.members[0])
        return SimpleNamespace(chance=0.1)

    asking = Asking(laid, glance, laid, no_twins, no_part, no_image, no_kin)
    ask_members(union, pieces[-1], evidence, asking, growth)
    assert asked == [count - 1 - k for k in range(members.MEMBERS)]
    assert not growth.sure_of_members


def test_a_union_that_does_not_lie_there_is_not_joined(alone, leg, monkeypatch) -> None:
    union = replace(alone[1], members=(1, 0))
    growth = replace(Growth.begun(alone), sure_of_members=[leg])
    asking = Asking(laid, laid, lambda *_: leg.met, no_twins, no_part, no_image, no_kin)

    def found() -> Join | None:
        return told_by_members(union, alone[2], asking, growth)

    assert found() is not None
    monkeypatch.setattr(members, "left_out", lambda before, join: 0.6)
    assert found() is None
    monkeypatch.setattr(members, "left_out", lambda before, join: 0.0)
    monkeypatch.setattr(members, "ends_with_one", lambda questions, placements: 0.5)
    assert found() is None
