"""Further trials, with stand-ins for what places a piece: who is asked again, and without what."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from sherd.arrays import Bools
from sherd.output import Stages
from sherd.puzzle import further_trials
from sherd.puzzle.border import border_of
from sherd.puzzle.further_trials import torn_apart, trials_again
from sherd.puzzle.joint_choice import Candidate
from sherd.puzzle.trials import Trial
from sherd.shapes import creature


@pytest.fixture(scope="module")
def full() -> SimpleNamespace:
    """What is asked of a template here."""
    mesh = creature(5000)
    return SimpleNamespace(placed=mesh.with_vertices(mesh.vertices / mesh.length))


def balls(full, *corners: int) -> list[Bools]:
    """Vertices around the extreme ones of some axes: they lie far apart."""
    places = full.placed.vertices
    found = []
    for corner in corners:
        at = places[(places[:, abs(corner) - 1] * np.sign(corner)).argmax()]
        found.append(np.linalg.norm(places - at, axis=1) < 0.15)
    return found


def trial(full, piece: int, region: Bools, chance: float) -> Trial:
    """A piece that lies in a region; the piece itself is whole."""
    border = border_of(full.placed, full.placed.vertices)
    placed = SimpleNamespace(
        question=SimpleNamespace(part=SimpleNamespace(mesh=full.placed)),
        best=SimpleNamespace(mask=region),
    )
    made = SimpleNamespace(
        piece=piece, placed=placed, candidate=Candidate(region, region, chance, border)
    )
    made.chance = chance
    return made


@pytest.fixture
def asked(full, monkeypatch) -> list[tuple[int, Bools]]:
    """Which piece was placed again, and what was taken."""
    found: list[tuple[int, Bools]] = []
    monkeypatch.setattr(
        further_trials,
        "_elsewhere",
        lambda template, first, taken, stages: [found.append((first.piece, taken))][:0],
    )
    return found


def again(full, trials: list[Trial]) -> list[Trial]:
    return trials_again(full, trials, 2, Stages(visible=False))


def test_sure_pieces_and_pieces_in_nobodys_way_are_not_asked_again(full, asked) -> None:
    front, rear = balls(full, 1, -1)
    assert again(full, [trial(full, 0, front, 0.9), trial(full, 1, rear, 0.3)]) == []
    assert asked == []


def test_the_loser_is_asked_where_the_winner_is_not_and_then_the_winner_without_it(
    full, asked
) -> None:
    (front,) = balls(full, 1)
    again(full, [trial(full, 0, front, 0.9), trial(full, 1, front, 0.6)])
    assert [piece for piece, _ in asked] == [1, 0]
    assert all(np.array_equal(taken, front) for _, taken in asked)


def test_for_a_piece_that_would_not_be_placed_nobody_moves(full, asked) -> None:
    (front,) = balls(full, 1)
    again(full, [trial(full, 0, front, 0.9), trial(full, 1, front, 0.1)])
    assert [piece for piece, _ in asked] == [1]


def test_a_torn_piece_is_asked_without_either_place(full, asked) -> None:
    front, rear = balls(full, 1, -1)
    again(full, [trial(full, 0, front | rear, 0.3)])
    assert [piece for piece, _ in asked] == [0, 0]
    taken = {int(mask.sum()) for _, mask in asked}
    assert taken == {int(front.sum()), int(rear.sum())}


def test_what_has_no_place_is_asked_again_in_the_gap_that_is_left(full, monkeypatch) -> None:
    front, rear = balls(full, 1, -1)
    asked = []

    def elsewhere(template, first, taken, stages) -> list[Trial]:
        asked.append((first.piece, taken))
        return [trial(full, 0, rear, 0.9)] if first.piece == 0 else []

    monkeypatch.setattr(further_trials, "_elsewhere", elsewhere)
    trials = [trial(full, 0, front, 0.9), trial(full, 1, front, 0.6), trial(full, 2, front, 0.1)]
    trials_again(full, trials, 3, Stages(visible=False))
    # 2 is asked while 0 lies in front, and again when 0 lies behind and 1 in front
    assert [piece for piece, _ in asked] == [1, 2, 0, 2]


def test_parts_of_a_mask_come_largest_first_and_without_noise(full) -> None:
    front, rear = balls(full, 1, -1)
    areas = full.placed.vertex_areas
    speck = np.zeros(len(areas), dtype=bool)
    speck[np.flatnonzero(~front & ~rear)[0]] = True
    parts = torn_apart(full.placed, front | rear | speck)
    assert [float(areas @ part) for part in parts] == sorted(
        (float(areas @ front), float(areas @ rear)), reverse=True
    )
