"""Synchronization: wrong maps are outvoted by detours, and loops close."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

from sherd.mesh.surface_points import points_at_vertices
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.puzzle.synchronization import PieceMap, cycle_error, synchronized


@pytest.fixture(scope="module")
def pieces(request) -> list[TriangleMesh]:
    """Four equal sheets, 30 by 30 vertices on unit area."""
    x, y = np.meshgrid(np.linspace(0, 1, 30), np.linspace(0, 1, 30), indexing="ij")
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    faces = np.concatenate(
        [np.stack([a, b, c], axis=2).reshape(-1, 3), np.stack([a, c, d], axis=2).reshape(-1, 3)]
    )
    sheet = TriangleMesh(np.stack([x.ravel(), y.ravel(), 0.1 * x.ravel() ** 2], axis=1), faces)
    return [sheet] * 4


def identity(mesh: TriangleMesh) -> PieceMap:
    count = mesh.vertex_count
    points = points_at_vertices(mesh, np.arange(count))
    return PieceMap(points, np.ones(count, dtype=bool), np.full(count, 0.9))


def upside_down(mesh: TriangleMesh) -> PieceMap:
    """Every vertex on the one opposite: wrong everywhere."""
    count = mesh.vertex_count
    points = points_at_vertices(mesh, np.arange(count)[::-1])
    return PieceMap(points, np.ones(count, dtype=bool), np.full(count, 0.5))


def test_a_wrong_map_is_outvoted_and_loops_close(pieces) -> None:
    maps = {pair: identity(pieces[0]) for pair in permutations(range(4), 2)}
    assert cycle_error(pieces, maps, 1.0) < 1e-12
    maps[0, 1] = maps[1, 0] = upside_down(pieces[0])
    before = cycle_error(pieces, maps, 1.0)
    after = synchronized(pieces, maps, 1.0)
    assert before > 0.1
    # the median is iterated eight times, so it has all but arrived
    assert cycle_error(pieces, after, 1.0) < 1e-4
    off = after[0, 1].points.positions(pieces[1]) - pieces[0].vertices
    assert np.abs(off).max() < 1e-3


def test_pieces_without_a_map_of_their_own_are_joined_by_detours(pieces) -> None:
    chain = {(0, 1), (1, 0), (1, 2), (2, 1)}
    found = synchronized(pieces, {pair: identity(pieces[0]) for pair in chain}, 1.0)
    assert set(found) == set(permutations(range(3), 2))
    off = found[0, 2].points.positions(pieces[2]) - pieces[0].vertices
    assert np.abs(off).max() < 1e-9
    assert (found[0, 2].trust < found[0, 1].trust).all()


def test_without_loops_the_cycle_error_is_unknown(pieces) -> None:
    assert np.isnan(cycle_error(pieces, {(0, 1): identity(pieces[0])}, 1.0))
