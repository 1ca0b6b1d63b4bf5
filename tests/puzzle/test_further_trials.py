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
from sherd.puzzle.partition import Partition
from sherd.puzzle.trials import Trial
from sherd.shapes import creature


@pytest.fixture(scope="module")
def full() -> SimpleNamespace:
    """What is asked of a template here."""
    mesh = creature(5000)
    placed = mesh.with_vertices(mesh.vertices / mesh.length)
    return SimpleNamespace(placed=placed, partition=Partition(placed))


def balls(full, *corners: int) -> list[Bools]:
    """Vertices around the extreme ones of some axes: they lie far apart."""
    places = full.placed.vertices
    found = []
    for corner in corners:
        at = places[(places[:, abs(corner) - 1] * np.sign(corner)).argmax()]
        found.append(np.linalg.norm(places - at, axis=1) < 0.15)
    return found


def trial(
    full,
    piece: int,
    region: Bools,
    chance: float,
    *,
    area: float | None = None,
    score: float = 0.7,
) -> Trial:
    """A piece that lies in a region; as large as that, if nothing is said, and connected."""
    mesh = full.placed
    size = float(mesh.vertex_areas @ region) if area is None else area
    placed = SimpleNamespace(
        question=SimpleNamespace(
            part=SimpleNamespace(mesh=mesh.with_vertices(mesh.vertices * np.sqrt(size)))
        ),
        best=SimpleNamespace(mask=region, score=score),
    )
    border = border_of(mesh, mesh.vertices)  # a closed mesh has none
    return Trial(piece, placed, full.partition, Candidate(region, region, chance, border))


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
    assert again(full, [trial(full, 0, front, 0.9), trial(full, 1, rear, 0.85)]) == []
    assert asked == []


def test_the_loser_is_asked_where_the_winner_is_not_and_then_the_winner_without_it(
    full, asked
) -> None:
    (front,) = balls(full, 1)
    again(full, [trial(full, 0, front, 0.9), trial(full, 1, front, 0.6)])
    assert [piece for piece, _ in asked] == [1, 0]
    assert all(np.array_equal(taken, front) for _, taken in asked)


@pytest.mark.parametrize(("score", "moves"), [(0.6, True), (0.8, False)])
def test_the_winner_is_asked_too_if_the_loser_fits_worse_where_it_went(
    full, monkeypatch, score, moves
) -> None:
    """Two hooves: the surer one has the place of the other, which is content with its place."""
    front, rear = balls(full, 1, -1)
    asked = []

    def elsewhere(template, first, taken, stages) -> list[Trial]:
        asked.append(first.piece)
        assert np.array_equal(taken, front)  # the rear, where 1 went, may be where 0 belongs
        return [trial(full, 1, rear, 0.85, score=score)] if first.piece == 1 else []

    monkeypatch.setattr(further_trials, "_elsewhere", elsewhere)
    again(full, [trial(full, 0, front, 0.95), trial(full, 1, front, 0.9)])
    assert asked == ([1, 0] if moves else [1])


def test_for_a_piece_that_would_not_be_placed_nobody_moves(full, asked) -> None:
    (front,) = balls(full, 1)
    again(full, [trial(full, 0, front, 0.9), trial(full, 1, front, 0.1)])
    assert [piece for piece, _ in asked] == [1]


def within(full, low: float, high: float) -> Bools:
    """A slice of the animal, between these shares of its area from one end on."""
    place = full.placed.vertices[:, 0]
    before = np.cumsum(full.placed.vertex_areas[np.argsort(place)])[np.argsort(np.argsort(place))]
    return (before > low) & (before <= high)


def test_a_neighbor_in_doubt_that_reaches_into_a_lost_place_is_asked_without_it(
    full, asked
) -> None:
    """It slid a fifth of the place, too little to have it, and enough to be in the way."""
    slid, lost = within(full, 0.1, 0.3), within(full, 0.26, 0.46)
    again(full, [trial(full, 0, slid, 0.6), trial(full, 1, lost, 0.25)])
    assert any(piece == 0 and np.array_equal(taken, lost) for piece, taken in asked)
    asked.clear()
    again(full, [trial(full, 0, slid, 0.9), trial(full, 1, lost, 0.25)])
    assert {piece for piece, _ in asked} == {1}


def test_nobody_moves_for_a_piece_that_cannot_lie_beside_the_others(full, asked) -> None:
    most, same = within(full, 0.0, 0.6), within(full, 0.05, 0.6)
    again(full, [trial(full, 0, most, 0.9), trial(full, 1, same, 0.6)])
    assert [piece for piece, _ in asked] == [1]


def test_a_piece_is_not_asked_where_there_is_no_room_for_half_of_it(full, asked) -> None:
    large, small = within(full, 0.0, 0.8), within(full, 0.5, 0.7)
    again(full, [trial(full, 0, large, 0.9), trial(full, 1, small, 0.3, area=0.32)])
    assert [piece for piece, _ in asked] == [1]
    asked.clear()
    again(full, [trial(full, 0, large, 0.9), trial(full, 1, small, 0.3, area=0.5)])
    assert asked == []


def test_a_place_that_leaves_another_a_chance_is_compared_with_the_gap(full, asked) -> None:
    """A left leg on the right one's place, which is missing, is in nobody's way."""
    front, body = within(full, 0.0, 0.2), within(full, 0.3, 0.7)
    again(full, [trial(full, 0, body, 0.95), trial(full, 1, front, 0.75)])
    assert [(piece, bool((taken & front).any())) for piece, taken in asked] == [(1, True)]
    assert np.array_equal(asked[0][1], front | body)
    asked.clear()
    again(full, [trial(full, 0, body, 0.95), trial(full, 1, front, 0.85)])
    assert asked == []


def test_a_sure_piece_that_lies_on_others_is_asked_elsewhere(full, asked) -> None:
    """A hoof on a leg that two thirds of it share: both may stay, if it fits nowhere else."""
    leg, on_it = within(full, 0.0, 0.3), within(full, 0.24, 0.34)
    again(full, [trial(full, 0, leg, 0.95), trial(full, 1, on_it, 0.9)])
    assert [piece for piece, _ in asked] == [1]
    assert np.array_equal(asked[0][1], leg)
    asked.clear()
    beside = within(full, 0.28, 0.38)
    again(full, [trial(full, 0, leg, 0.95), trial(full, 1, beside, 0.9)])
    assert asked == []


def test_two_in_doubt_that_could_change_places_are_asked_so(full, asked) -> None:
    front, rear, body = within(full, 0.0, 0.1), within(full, 0.9, 1.0), within(full, 0.3, 0.7)
    trials = [trial(full, 0, front, 0.7), trial(full, 1, rear, 0.7), trial(full, 2, body, 0.95)]
    trials_again(full, trials, 3, Stages(visible=False))
    taken = [
        (piece, tuple(map(bool, ((at & front).any(), (at & rear).any())))) for piece, at in asked
    ]
    assert (0, (True, False)) in taken
    assert (1, (False, True)) in taken
    asked.clear()
    larger = within(full, 0.71, 1.0)  # has no room where the front lies
    trials[1] = trial(full, 1, larger, 0.7)
    trials_again(full, trials, 3, Stages(visible=False))
    assert all((taken & larger).any() for piece, taken in asked if piece == 0)


def test_a_torn_piece_is_asked_without_either_place(full, asked) -> None:
    front, rear = balls(full, 1, -1)
    again(full, [trial(full, 0, front | rear, 0.3)])
    sizes = [int(mask.sum()) for _, mask in asked]
    # and at last in neither, as it has a place by then which may be wrong
    assert set(sizes[:2]) == {int(front.sum()), int(rear.sum())}
    assert sizes[2:] == [int((front | rear).sum())]


def test_what_has_no_place_is_asked_again_in_the_gap_that_is_left(full, monkeypatch) -> None:
    front, rear = balls(full, 1, -1)
    asked = []

    def elsewhere(template, first, taken, stages) -> list[Trial]:
        asked.append((first.piece, taken))
        return [trial(full, 0, rear, 0.9)] if first.piece == 0 else []

    monkeypatch.setattr(further_trials, "_elsewhere", elsewhere)
    trials = [trial(full, 0, front, 0.9), trial(full, 1, front, 0.6), trial(full, 2, front, 0.1)]
    trials_again(full, trials, 3, Stages(visible=False))
    # 2 is asked while 0 lies in front, and again when 0 lies behind and 1 in front, in doubt
    assert [piece for piece, _ in asked] == [1, 2, 0, 1, 2]


def test_what_has_no_place_is_asked_in_each_gap_of_its_size_alone(full, asked) -> None:
    """Two gaps: in both at once it was torn between them."""
    left, middle, right = within(full, 0, 0.15), within(full, 0.3, 0.55), within(full, 0.8, 1)
    gaps = within(full, 0.15, 0.3), within(full, 0.55, 0.8)
    areas = full.placed.vertex_areas

    def alone(size: float) -> list[bool]:
        """Whether it was asked in each gap, and hardly elsewhere."""
        asked.clear()
        lost = trial(full, 3, within(full, 0.0, 0.12), 0.1, area=size)
        placed = [trial(full, k, each, 0.9) for k, each in enumerate((left, middle, right))]
        trials_again(full, [*placed, lost], 4, Stages(visible=False))
        free = [~taken for piece, taken in asked if piece == 3]
        return [
            any(float(areas @ (each ^ gap)) < 0.5 * float(areas @ gap) for each in free)
            for gap in gaps
        ]

    assert alone(0.2) == [True, True]
    assert alone(0.4) == [False, True]
    assert alone(0.1) == [True, False]


def test_parts_of_a_mask_come_largest_first_and_without_noise(full) -> None:
    front, rear = balls(full, 1, -1)
    areas = full.placed.vertex_areas
    speck = np.zeros(len(areas), dtype=bool)
    speck[np.flatnonzero(~front & ~rear)[0]] = True
    parts = torn_apart(full.placed, front | rear | speck)
    assert [float(areas @ part) for part in parts] == sorted(
        (float(areas @ front), float(areas @ rear)), reverse=True
    )
