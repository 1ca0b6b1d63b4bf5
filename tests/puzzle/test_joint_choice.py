"""The joint choice: the search against all choices there are."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.puzzle import joint_choice as module
from sherd.puzzle.border import Border, border_of, facing_lengths
from sherd.puzzle.joint_choice import (
    Candidate,
    Ties,
    choice_among,
    energy_of,
    joint_choice,
    shared_areas,
)

SIDE = 12


def plane() -> TriangleMesh:
    """A square of unit area with a vertex on each crossing of a grid."""
    x, y = np.meshgrid(np.linspace(0, 1, SIDE + 1), np.linspace(0, 1, SIDE + 1), indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    faces = np.concatenate(
        [np.stack([a, b, c], axis=2).reshape(-1, 3), np.stack([a, c, d], axis=2).reshape(-1, 3)]
    )
    return TriangleMesh(vertices, faces)


MESH = plane()


def candidate(low: float, high: float, chance: float) -> Candidate:
    """A piece that lies on a stripe of the square."""
    middle = MESH.vertices[MESH.faces].mean(axis=1)[:, 0]
    piece, kept = MESH.submesh((middle > low) & (middle < high))
    region = np.zeros(MESH.vertex_count, dtype=bool)
    region[kept] = True
    core = region.copy()
    core[kept[piece.boundary_vertices]] = False
    return Candidate(region, core, chance, border_of(piece, piece.vertices))


def energy(pieces: list[list[Candidate]], choice: tuple[int, ...]) -> float:
    """What the module says, term by term."""
    chosen = [some[c] for some, c in zip(pieces, choice, strict=True) if c >= 0]
    areas = MESH.vertex_areas
    total = 0.0
    sure = [(each.chance - module.LEAST_CHANCE) / (1 - module.LEAST_CHANCE) for each in chosen]
    for each, gain in zip(chosen, sure, strict=True):
        total += module.OMEGA * each.border.length - areas @ each.region * gain
    if chosen:
        cores = shared_areas([each.core for each in chosen], areas)
        regions = np.array([areas @ each.region for each in chosen])
        share = cores / np.minimum.outer(np.diag(cores), np.diag(cores))
        table = share * np.minimum.outer(regions, regions)
        shared = np.triu(table * np.maximum(np.maximum.outer(sure, sure), 0.0), 1).sum()
        facing = np.triu(facing_lengths([each.border for each in chosen]), 1).sum()
        total += module.KAPPA * shared - module.OMEGA * facing
    return total


def test_no_choice_has_less_energy() -> None:
    rng = np.random.default_rng(2)
    for _ in range(12):
        pieces = []
        for _ in range(4):
            starts = rng.uniform(0, 0.7, size=rng.integers(0, 4))
            pieces.append([candidate(s, s + 0.3, rng.uniform(0, 1)) for s in starts])
        found = joint_choice(pieces, MESH.vertex_areas)
        every = product(*(range(-1, len(some)) for some in pieces))
        least = min(energy(pieces, choice) for choice in every)
        assert found.proven
        assert abs(found.energy - least) < 1e-9
        assert abs(energy(pieces, tuple(found.candidates.tolist())) - least) < 1e-9


def test_two_alike_pieces_go_to_two_places() -> None:
    """Both like the left place best; only together is it known who must go."""
    left, right = (0.0, 0.5), (0.5, 1.0)
    pieces = [
        [candidate(*left, 0.9), candidate(*right, 0.85)],
        [candidate(*left, 0.95), candidate(*right, 0.3)],
    ]
    assert joint_choice(pieces, MESH.vertex_areas).candidates.tolist() == [1, 0]


def test_what_lies_wholly_on_a_surer_piece_is_refused_unless_pieces_may_overlap() -> None:
    pieces = [[candidate(0.0, 0.5, 0.9)], [candidate(0.0, 0.5, 0.97)]]
    assert joint_choice(pieces, MESH.vertex_areas).candidates.tolist() == [-1, 0]
    both = joint_choice(pieces, MESH.vertex_areas, may_overlap=True)
    assert both.candidates.tolist() == [0, 0]


def test_of_two_thin_pieces_in_one_place_one_is_refused() -> None:
    """Their cores are a small part of them."""
    thin, over = candidate(0.4, 0.6, 0.95), candidate(0.4, 0.6, 0.9)
    areas = MESH.vertex_areas
    assert areas @ thin.core < 0.5 * areas @ thin.region
    around = [[candidate(0.0, 0.4, 0.95)], [candidate(0.6, 1.0, 0.95)]]
    assert joint_choice([[thin], [over], *around], areas).candidates.tolist() == [0, -1, 0, 0]


def test_doubtful_pieces_may_reach_into_each_other_and_a_sure_one_gives_nothing_up() -> None:
    reaching = [candidate(0.4, 0.9, 0.45)]
    doubtful, sure = [candidate(0.0, 0.6, 0.5)], [candidate(0.0, 0.6, 0.99)]
    assert joint_choice([doubtful, reaching], MESH.vertex_areas).candidates.tolist() == [0, 0]
    assert joint_choice([sure, reaching], MESH.vertex_areas).candidates.tolist() == [0, -1]


def test_an_unlikely_piece_that_fills_a_hole_has_a_place_and_one_in_the_open_has_not() -> None:
    unlikely = [candidate(0.4, 0.6, 0.25)]
    around = [[candidate(0.0, 0.4, 0.95)], [candidate(0.6, 1.0, 0.95)]]
    assert joint_choice([unlikely], MESH.vertex_areas).candidates.tolist() == [-1]
    assert joint_choice([unlikely, *around], MESH.vertex_areas).candidates.tolist() == [0, 0, 0]


def test_nothing_to_choose_from() -> None:
    assert joint_choice([], MESH.vertex_areas).energy == 0.0
    assert joint_choice([[], []], MESH.vertex_areas).candidates.tolist() == [-1, -1]


def ring(count: int) -> Ties:
    """Pieces around a ring, each likeliest at its own place, and likely at two others."""
    rng = np.random.default_rng(4)
    owner, number = np.repeat(np.arange(count), 3), np.tile(np.arange(3), count)
    wrong = [rng.choice(np.delete(np.arange(count), k), 2, replace=False) for k in range(count)]
    place = np.array([[k, *some] for k, some in enumerate(wrong)]).ravel()
    away = np.abs(place[:, None] - place)
    return Ties(
        count=count,
        owner=owner,
        number=number,
        chances=np.where(number == 0, 0.75, 0.6) + rng.uniform(-0.03, 0.03, 3 * count),
        regions=np.full(3 * count, 1 / count),
        lengths=np.full(3 * count, 0.6),
        facing=np.where(np.minimum(away, count - away) == 1, 0.3, 0.0),
        cores=np.where(away == 0, 0.7 / count, 0.0),
    )


@pytest.mark.parametrize("count", [8, 16, 20])
def test_many_alike_pieces_go_where_each_is_likeliest(count: int) -> None:
    ties = ring(count)
    found = choice_among(ties, ties.chances)
    assert found.proven
    assert not found.candidates.any()


def test_a_search_that_is_broken_off_keeps_what_it_began_with() -> None:
    ties = ring(8)
    right = np.zeros(8, dtype=np.int64)
    found = choice_among(ties, ties.chances, start=right, most_nodes=0)
    assert not found.proven
    assert found.nodes == 0
    assert found.candidates.tolist() == right.tolist()
    assert found.energy == pytest.approx(energy_of(ties, ties.chances, right))
    worse = np.array([1, 0, 0, 0, 0, 0, 0, -1])
    assert choice_among(ties, ties.chances, start=worse).candidates.tolist() == right.tolist()


def test_a_search_that_is_broken_off_says_so(monkeypatch) -> None:
    monkeypatch.setattr(module, "MOST_NODES", 2)
    pieces = [[candidate(0.0, 0.5, 0.9)], [candidate(0.3, 0.8, 0.9)], [candidate(0.5, 1.0, 0.9)]]
    assert not joint_choice(pieces, MESH.vertex_areas).proven


def test_facing_borders_are_measured_and_others_are_not() -> None:
    def border(low: float, high: float) -> Border:
        return candidate(low, high, 1.0).border

    table = facing_lengths([border(0.0, 0.5), border(0.5, 1.0), border(0.75, 1.0)])
    assert abs(table[0, 1] - 1.0) < 0.2  # the ends of the outer edges are near each other as well
    assert table[0, 2] == 0.0
    assert np.array_equal(table, table.T)
