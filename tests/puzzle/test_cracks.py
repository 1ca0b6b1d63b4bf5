"""Cracks: closed where the skin goes on, and only there."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.arrays import Bools, Floats, Ints
from sherd.mesh.border_loops import border_loops
from sherd.mesh.geometry import face_cross
from sherd.puzzle.growing.cracks import closed_cracks, shortest_triangulation

SIZE = 12


def grid() -> tuple[Floats, Ints]:
    """A square of 12 x 12 vertices in the plane, faces upward."""
    x, y = np.meshgrid(np.arange(SIZE), np.arange(SIZE), indexing="ij")
    vertices = np.column_stack([x.ravel(), y.ravel(), np.zeros(SIZE**2)]).astype(np.float64)
    corner = (np.arange(SIZE - 1)[:, None] * SIZE + np.arange(SIZE - 1)).ravel()
    lower = np.column_stack([corner, corner + SIZE, corner + SIZE + 1])
    upper = np.column_stack([corner, corner + SIZE + 1, corner + 1])
    return vertices, np.concatenate([lower, upper])


def on_rim(vertices: Floats) -> Bools:
    found: Bools = ((vertices[:, :2] == 0) | (vertices[:, :2] == SIZE - 1)).any(axis=1)
    return found


def anywhere(triangles: Ints) -> Bools:
    return np.ones(len(triangles), dtype=bool)


def total_area(vertices: Floats, faces: Ints) -> float:
    """Signed: a face that is turned over counts against it."""
    return float(0.5 * face_cross(vertices, faces)[:, 2].sum())


@pytest.mark.parametrize("width", [1, 4])
def test_a_hole_in_the_skin_is_closed_and_its_rim_stays(width) -> None:
    vertices, faces = grid()
    centers = vertices[faces].mean(axis=1)
    gone = (np.abs(centers[:, 0] - 5.5) < 0.5 * width) & (np.abs(centers[:, 1] - 5.5) < 3)
    closed = closed_cracks(vertices, faces[~gone], ~on_rim(vertices), anywhere)
    assert [len(loop) for loop in border_loops(closed)] == [4 * (SIZE - 1)]
    assert total_area(vertices, closed) == pytest.approx((SIZE - 1) ** 2)
    assert len(closed) <= len(faces)


def test_a_slit_from_the_rim_is_closed_but_for_its_mouth() -> None:
    vertices, faces = grid()
    centers = vertices[faces].mean(axis=1)
    gone = (np.abs(centers[:, 0] - 5.5) < 0.5) & (centers[:, 1] < 6)
    closed = closed_cracks(vertices, faces[~gone], ~on_rim(vertices), anywhere)
    assert total_area(vertices, closed) == pytest.approx((SIZE - 1) ** 2 - 1)
    assert len(border_loops(closed)) == 1


def test_what_ends_the_skin_and_what_would_cap_a_limb_stays_open() -> None:
    vertices, faces = grid()
    centers = vertices[faces].mean(axis=1)
    gone = (np.abs(centers - 5.5)[:, :2] < 1.5).all(axis=1)
    nowhere = np.zeros(len(vertices), dtype=bool)
    assert len(closed_cracks(vertices, faces[~gone], nowhere, anywhere)) == (~gone).sum()
    off = closed_cracks(vertices, faces[~gone], ~on_rim(vertices), lambda faces: ~anywhere(faces))
    assert len(off) == (~gone).sum()


def test_faces_that_only_touch_give_way() -> None:
    """Two holes that meet in one vertex: their border would pass it twice."""
    vertices, faces = grid()
    centers = vertices[faces].mean(axis=1)
    first = (np.abs(centers[:, :2] - 4.0) < 1).all(axis=1)
    second = (np.abs(centers[:, :2] - 6.0) < 1).all(axis=1)
    closed = closed_cracks(vertices, faces[~first & ~second], ~on_rim(vertices), anywhere)
    assert [len(loop) for loop in border_loops(closed)] == [4 * (SIZE - 1)]
    assert total_area(vertices, closed) == pytest.approx((SIZE - 1) ** 2)


def test_the_shortest_diagonals_are_taken_unless_they_are_edges_already() -> None:
    square = np.array([[0.0, 0, 0], [2, 0, 0], [3, 1, 0], [0, 1, 0]])
    ring = np.arange(4)

    def diagonals(taken: set[tuple[int, int]]) -> set[tuple[int, ...]]:
        found = shortest_triangulation(square, ring, taken)
        return {
            tuple(sorted(set(a) & set(b))) for a in found.tolist() for b in found.tolist() if a < b
        }

    assert diagonals(set()) == {(1, 3)}
    assert diagonals({(1, 3)}) == {(0, 2)}
    assert not len(shortest_triangulation(square, ring, {(1, 3), (0, 2)}))
    assert not len(shortest_triangulation(square, ring, {(0, 3)}))
    faces = shortest_triangulation(square, ring, set())
    assert (face_cross(square, faces)[:, 2] > 0).all()
