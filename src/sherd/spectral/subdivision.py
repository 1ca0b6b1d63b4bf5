"""Conforming subdivision: edges are cut in the middle, and all faces at an edge agree."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Bools, Floats, Ints

__all__ = ["split_edges", "split_long_edges"]


# Children of a face (v0 v1 v2 and the middles m0 of v0v1, m1 of v1v2, m2 of v2v0 as 3, 4, 5) whose
# cut edges are: all; the first two; the first only; none.
_CHILDREN = {
    3: [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
    2: [[3, 1, 4], [0, 3, 4], [0, 4, 2]],
    1: [[0, 3, 2], [3, 1, 2]],
    0: [[0, 1, 2]],
}
# Each pass halves every long edge, so this allows a shortening by 2^40.
MAX_PASSES = 40
# More vertices than fit beside what is computed from them.
MOST_VERTICES = 20_000_000


def split_edges(faces: Ints, count: int, chosen: Bools | None = None) -> tuple[Ints, Ints]:
    """Put a vertex on edges and split the faces at them in two, three or four.

    Parameters
    ----------
    faces
        (m, 3) int, indices below `count`.
    count
        Number of vertices n; the new vertices are n, n + 1, ... in the order of the edges.
    chosen
        (3m,) bool for the half edges face after face, equal for the two sides of an edge;
        all edges if not given.

    Returns
    -------
    faces, parents
        (m', 3) int, and (v, 2) int, the ends of the edge that each new vertex lies on.
    """
    sides = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    cut = np.ones(len(sides), dtype=bool) if chosen is None else chosen
    keys, place = np.unique(sides[cut, 0] * count + sides[cut, 1], return_inverse=True)
    flat = np.full(len(sides), -1, dtype=np.int64)
    flat[cut] = count + place
    middle = flat.reshape(-1, 3)
    parents = np.stack([keys // count, keys % count], axis=1)
    number = (middle >= 0).sum(axis=1)
    # turn each face so that its cut edges come first
    first = np.where(number == 1, (middle >= 0).argmax(axis=1), 0)
    first = np.where(number == 2, ((middle < 0).argmax(axis=1) + 1) % 3, first)
    turn = (first[:, None] + np.arange(3)) % 3
    corners = np.concatenate(
        [np.take_along_axis(faces, turn, axis=1), np.take_along_axis(middle, turn, axis=1)], axis=1
    )
    children = [
        corners[number == cuts][:, pattern].reshape(-1, 3) for cuts, pattern in _CHILDREN.items()
    ]
    return np.concatenate(children), parents


def split_long_edges(
    vertices: Floats, faces: Ints, limit: float, *, most: int = MOST_VERTICES
) -> tuple[Floats, Ints]:
    """Halve edges longer than `limit` (l) until none is left; the surface stays the same set.

    Where that would take more than `most` vertices, as along a hair-thin face many times as long
    as its area suggests, the longest edges are halved until there are as many.
    """
    for _ in range(MAX_PASSES):
        ends = vertices[faces]
        lengths = np.linalg.norm(np.roll(ends, -1, axis=1) - ends, axis=2).ravel()
        long = lengths > limit
        if not long.any():
            break
        # both sides of an edge see the same two points, but not always the same last bit
        sides = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        keys = sides[:, 0] * len(vertices) + sides[:, 1]
        cut, first = np.unique(keys[long], return_index=True)
        room = most - len(vertices)
        if room <= 0:
            break
        if len(cut) > room:
            cut = cut[np.argsort(-lengths[long][first], kind="stable")[:room]]
        faces, parents = split_edges(faces, len(vertices), np.isin(keys, cut))
        vertices = np.concatenate([vertices, vertices[parents].mean(axis=1)])
    return vertices, faces
