"""Which trials are chosen, and what their chances are among the other places of the same piece."""

from __future__ import annotations

import pytest

from sherd.puzzle.joint_choice import Candidate
from sherd.puzzle.trials import Trial, chosen_together

from .test_joint_choice import MESH, candidate


def trial(piece: int, lies: Candidate) -> Trial:
    """A piece that lies there, wherever it came from."""
    return Trial(piece, None, None, lies)


def chances(*trials: Trial) -> dict[int, float]:
    count = 1 + max(each.piece for each in trials)
    chosen, _ = chosen_together(trials, count, MESH.vertex_areas)
    return {piece: each.chance for piece, each in chosen.items()}


def test_a_piece_that_could_lie_in_another_place_as_well_is_in_doubt() -> None:
    left, right = candidate(0.0, 0.4, 0.7), candidate(0.6, 1.0, 0.5)
    assert chances(trial(0, left)) == {0: pytest.approx(0.7)}
    # odds of 7 : 3 and of 1 : 1 against nowhere
    both = chances(trial(0, left), trial(0, right))
    assert both == {0: pytest.approx((7 / 3) / (1 + 7 / 3 + 1))}


def test_a_place_that_another_piece_has_and_the_same_place_again_raise_no_doubt() -> None:
    left, right = candidate(0.0, 0.25, 0.7), candidate(0.75, 1.0, 0.5)
    sure = candidate(0.75, 1.0, 0.95)
    assert chances(trial(0, left), trial(0, right), trial(1, sure))[0] == pytest.approx(0.7)
    again = candidate(0.0, 0.26, 0.6)
    assert chances(trial(0, left), trial(0, again))[0] == pytest.approx(0.7)
