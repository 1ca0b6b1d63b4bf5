"""Around three pieces that were laid on each other one comes back to where one began, or not."""

from __future__ import annotations

from itertools import permutations
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from sherd.mesh.surface_points import closest_points
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.puzzle.growing import joined_maps
from sherd.puzzle.growing.joined_maps import open_loop
from sherd.puzzle.growing.union import Union
from sherd.puzzle.synchronization import PieceMap

SIDE = 11


def sheet() -> TriangleMesh:
    """A unit square of area 1."""
    x, y = np.meshgrid(*2 * [np.linspace(0, 1, SIDE)], indexing="ij")
    number = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    a, b, c, d = (number[i : i + SIDE - 1, j : j + SIDE - 1] for i in (0, 1) for j in (0, 1))
    faces = np.concatenate(
        [np.stack(each, axis=2).reshape(-1, 3) for each in ((a, c, d), (a, d, b))]
    )
    return TriangleMesh(np.stack([x, y, 0 * x], axis=2).reshape(-1, 3), faces)


def joins() -> list[Any]:
    unions = [Union.of_piece(sheet(), k) for k in range(3)]
    return [SimpleNamespace(first=unions[i], second=unions[j]) for i, j in ((0, 1), (0, 2), (1, 2))]


def maps(monkeypatch: pytest.MonkeyPatch, pairs: Any, off: float) -> None:
    """Each piece lies on each as it is, but the third `off` to the side on the first."""

    def direct(pieces: Any, joins: Any) -> Any:
        found = {}
        for here, there in pairs:
            aside = off if (here, there) == (2, 0) else 0.0
            moved = pieces[here].vertices + np.array([aside, 0.0, 0.0])
            known = moved[:, 0] <= 1.0
            points = closest_points(pieces[there], moved)
            found[here, there] = PieceMap(points, known, known.astype(float))
        return found

    monkeypatch.setattr(joined_maps, "direct_maps", direct)


def test_where_all_say_the_same_the_loop_is_closed(monkeypatch) -> None:
    maps(monkeypatch, permutations(range(3), 2), 0.0)
    assert open_loop(joins()) == pytest.approx(0.0, abs=1e-9)


def test_it_is_as_open_as_one_of_them_is_off(monkeypatch) -> None:
    maps(monkeypatch, [(0, 1), (1, 2), (2, 0)], 0.2)
    assert open_loop(joins()) == pytest.approx(0.2, abs=1e-6)


def test_without_a_way_around_it_is_open_without_end(monkeypatch) -> None:
    maps(monkeypatch, [(0, 1), (1, 0)], 0.0)
    assert open_loop(joins()) == np.inf
