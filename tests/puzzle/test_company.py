"""Borders as evidence: what closes a hole belongs there, and an open border says nothing."""

from __future__ import annotations

import pytest

from sherd.puzzle.border import facing_lengths
from sherd.puzzle.company import choice_in_company
from sherd.puzzle.joint_choice import joint_choice

from .test_joint_choice import MESH, candidate

AREAS = MESH.vertex_areas


def test_a_piece_that_closes_a_hole_is_placed_though_it_looks_like_nothing() -> None:
    around = [[candidate(0.0, 0.4, 0.95)], [candidate(0.6, 1.0, 0.95)]]
    odd = [candidate(0.4, 0.6, 0.1)]
    assert joint_choice([odd, *around], AREAS).candidates.tolist() == [-1, 0, 0]
    choice, judged = choice_in_company([odd, *around], AREAS)
    assert choice.candidates.tolist() == [0, 0, 0]
    assert judged[0][0].chance > 0.2
    alone, judged = choice_in_company([odd], AREAS)
    assert alone.candidates.tolist() == [-1]
    assert judged[0][0].chance == 0.1


def test_a_piece_that_meets_others_along_half_of_its_border_is_judged_as_before() -> None:
    beside = [candidate(0.0, 0.4, 0.95)]
    odd = candidate(0.4, 0.6, 0.1)
    met = facing_lengths([odd.border, beside[0].border])[0, 1]
    assert met < 0.5 * odd.border.length
    choice, judged = choice_in_company([[odd], beside], AREAS)
    assert choice.candidates.tolist() == [-1, 0]
    assert judged[0][0].chance == 0.1


def test_what_lies_on_another_piece_closes_no_hole() -> None:
    """Two left hands at one wrist: both meet the arm, and neither is the surer for it."""
    around = [[candidate(0.0, 0.4, 0.95)], [candidate(0.6, 1.0, 0.95)]]
    hands = [[candidate(0.4, 0.6, 0.7)], [candidate(0.4, 0.6, 0.6)]]
    choice, judged = choice_in_company([*hands, *around], AREAS)
    assert choice.candidates.tolist() == [0, -1, 0, 0]
    assert judged[0][0].chance > 0.9
    assert judged[1][0].chance == 0.6


def test_of_two_places_the_one_whose_borders_fit_is_taken() -> None:
    around = [[candidate(0.0, 0.3, 0.95)], [candidate(0.5, 0.7, 0.95)]]
    torn = [candidate(0.75, 0.95, 0.5), candidate(0.3, 0.5, 0.45)]
    assert joint_choice([torn, *around], AREAS).candidates.tolist()[1:] == [0, 0]
    choice, _ = choice_in_company([torn, *around], AREAS)
    assert choice.candidates.tolist() == [1, 0, 0]


def test_no_chance_is_lowered_and_none_is_certain() -> None:
    around = [[candidate(0.0, 0.4, 0.995)], [candidate(0.6, 1.0, 0.995)]]
    _, judged = choice_in_company([[candidate(0.4, 0.6, 0.995)], *around], AREAS)
    assert [some[0].chance for some in judged] == pytest.approx([0.995] * 3)


def test_a_piece_that_fills_the_gap_is_placed_though_its_borders_are_off() -> None:
    """Its borders lie inside its neighbors' places, where they face nothing."""
    around = [[candidate(0.0, 0.3, 0.95)], [candidate(0.75, 1.0, 0.95)]]
    odd = [candidate(0.38, 0.67, 0.15)]
    assert joint_choice([odd, *around], AREAS).candidates.tolist() == [-1, 0, 0]
    choice, judged = choice_in_company([odd, *around], AREAS)
    assert choice.candidates.tolist() == [0, 0, 0]
    # what is said of it in the end does not follow from the gap alone
    assert judged[0][0].chance == pytest.approx(0.15)
    # in a wider gap it would say nothing
    choice, _ = choice_in_company([odd, around[0]], AREAS)
    assert choice.candidates.tolist() == [-1, 0]


def test_two_that_are_right_only_together_are_found() -> None:
    """One reaches into the other's place; where it leaves that free it fits a little worse."""
    slid, right = candidate(0.25, 0.62, 0.46), candidate(0.25, 0.5, 0.44)
    beside = candidate(0.5, 0.75, 0.25)
    around = [[candidate(0.0, 0.25, 0.95)], [candidate(0.75, 1.0, 0.95)]]
    pieces = [[slid, right], [beside], *around]
    assert joint_choice(pieces, AREAS).candidates.tolist() == [0, -1, 0, 0]
    choice, _ = choice_in_company(pieces, AREAS)
    assert choice.candidates.tolist() == [1, 0, 0, 0]


def test_what_is_unlikely_is_not_placed_for_the_sake_of_its_neighbors() -> None:
    """A foreign piece in a gap would close its neighbors' borders."""
    around = [[candidate(0.0, 0.4, 0.5)], [candidate(0.75, 1.0, 0.5)]]
    foreign = [candidate(0.4, 0.75, 0.005)]
    choice, _ = choice_in_company([foreign, *around], AREAS)
    assert choice.candidates.tolist() == [-1, 0, 0]
