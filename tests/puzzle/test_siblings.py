"""Whether the skin of a piece is about as alike to the whole as that of the others is."""

from __future__ import annotations

import pytest

from sherd.assemble import assemble
from sherd.puzzle import trials
from sherd.puzzle.siblings import beside_siblings, chosen_beside_siblings, is_less_alike
from sherd.puzzle.trials import Trial
from sherd.results.status import Status
from sherd.shapes import creature, puzzle_pieces

from .test_joint_choice import MESH, candidate

AREAS = MESH.vertex_areas


def trial(piece: int, chance: float, alike: float | None) -> Trial:
    """One of four pieces of a square, where it belongs."""
    return Trial(piece, None, None, candidate(piece / 4, (piece + 1) / 4, chance), alike=alike)


def test_one_that_is_far_less_alike_than_the_others_is_in_doubt() -> None:
    some = [trial(0, 0.99, 0.8), trial(1, 0.99, 0.76), trial(2, 0.745, 0.5)]
    less = beside_siblings(some[2], some, AREAS)
    assert is_less_alike(some[2], some, AREAS)
    # log odds of 0.745, less 4.7 times what 0.28 has above 0.15
    assert less.chance == pytest.approx(0.61, abs=0.01)
    assert [beside_siblings(each, some, AREAS).chance for each in some[:2]] == pytest.approx(
        [0.99, 0.99]
    )


def test_who_is_alone_or_beside_others_of_whom_nothing_is_known_stays_as_it_is() -> None:
    known, unknown = trial(0, 0.9, 0.3), trial(1, 0.8, None)
    for placed in ([known], [known, unknown]):
        assert beside_siblings(known, placed, AREAS).chance == pytest.approx(0.9)
    assert beside_siblings(unknown, [known, unknown], AREAS).chance == pytest.approx(0.8)


def test_an_unlikely_piece_counts_little_for_what_is_expected() -> None:
    right = trial(0, 0.95, 0.8)
    assert not is_less_alike(right, [right, trial(1, 0.95, 0.9), trial(2, 0.3, 1.0)], AREAS)
    foreign = trial(2, 0.25, 0.3)
    assert is_less_alike(foreign, [right, trial(1, 0.95, 0.9), foreign], AREAS)


def test_what_is_unlikely_beside_the_others_is_refused_and_the_rest_is_chosen_anew() -> None:
    some = [trial(0, 0.9, 0.9), trial(1, 0.9, 0.9), trial(2, 0.3, 0.3)]
    chosen = chosen_beside_siblings(some, 3, AREAS)
    assert sorted(chosen.trials) == [0, 1]
    assert all(each.chance == pytest.approx(0.9, abs=0.05) for each in chosen.trials.values())


def test_it_is_said_of_a_piece_that_its_skin_is_less_alike(monkeypatch) -> None:
    full, walking = creature(5000), creature(5000, pose="walk")
    pieces = [piece.mesh for piece in puzzle_pieces(full, [walking, full, walking])]
    small = min(range(3), key=lambda k: pieces[k].area)

    def alike(placement) -> float:
        part = placement.question.part.placed.vertex_count
        return 0.1 if part == pieces[small].vertex_count else 0.8

    monkeypatch.setattr(trials, "alike_there", alike)
    answer = assemble(full, pieces).pieces
    assert answer[small].placed
    assert answer[small].match.status is Status.DOUBTFUL
    assert "its skin is far less alike there than that of the other pieces" in answer[small].reason
    others = [answer[k] for k in range(3) if k != small]
    assert not any("far less alike" in each.reason for each in others)
