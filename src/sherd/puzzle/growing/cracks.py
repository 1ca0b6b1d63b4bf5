"""Cracks of a union closed: borders where the skin of one of its pieces goes on.

Where two pieces were joined a seam of triangles runs between them, and here and there it leaves a
hole. That is no cut: what looks for the end of the union would take it for one, neighborhoods would
count less there, and geodesic lengths around it be no evidence.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.mesh.border_loops import border_loops, without_pinched_borders
from sherd.mesh.topology import unique_edges

__all__ = ["closed_cracks", "shortest_triangulation"]

# The triangulation of a polygon of n vertices compares n^3 / 6 triangles. A ring around a body of
# area 1 with edges of 0.01 has two hundred on either side of a crack.
MOST_CORNERS = 400
# A hole four edges wide or less is a crack if half of its corners are: the others lie where two
# borders run side by side, so that neither piece has skin on both sides.
SMALL = 12


def closed_cracks(
    vertices: Floats, faces: Ints, goes_on: Bools, lies: Callable[[Ints], Bools]
) -> Ints:
    """The faces (m, 3), and those that close what is open though the skin goes on.

    Parameters
    ----------
    vertices, faces
        A union with its seam. Faces around vertices at which sheets only touch are left out first,
        and what that opens is closed as well.
    goes_on
        (n,) bool, where one of both pieces has skin on either side; elsewhere a border is a cut.
    lies
        Which of some triangles (c, 3) lie on that skin; others would cap a limb, and are left out.
    """
    faces = without_pinched_borders(faces)
    known = {(first, second) for first, second in unique_edges(faces)[0].tolist()}
    added = [np.empty((0, 3), dtype=np.int64)]
    for loop in border_loops(faces):
        for run in _runs(loop, goes_on):
            if 3 <= len(run) <= MOST_CORNERS:
                # a border runs with its own faces, and what closes it runs against them
                taken = known if len(run) < len(loop) else known - {_edge(run[0], run[-1])}
                added.append(shortest_triangulation(vertices, run[::-1], taken))
    closing = np.concatenate(added)
    return np.concatenate([faces, closing[lies(closing)]])


def _runs(loop: Ints, goes_on: Bools) -> list[Ints]:
    """The longest runs of a loop along which the skin goes on; all of it, or stretches of it."""
    inside = goes_on[loop]
    if inside.all() or (len(loop) <= SMALL and inside.mean() >= 0.5):
        return [loop]
    if not inside.any():
        return []
    first = int(np.flatnonzero(~inside)[0])
    loop, inside = np.roll(loop, -first), np.roll(inside, -first)
    ends = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(np.int8)))
    return [loop[start:end] for start, end in zip(ends[::2], ends[1::2], strict=True)]


def _edge(first: int, second: int) -> tuple[int, int]:
    return (int(min(first, second)), int(max(first, second)))


def shortest_triangulation(vertices: Floats, polygon: Ints, taken: set[tuple[int, int]]) -> Ints:
    """Triangles (p - 2, 3) between the corners (p,) of a polygon with the shortest diagonals.

    Those of least total length, by dynamic programming over ever longer stretches of the polygon
    (Klincsek, *Minimal triangulations of polygonal domains*, 1980). None if each triangulation
    needs one of the edges (i, j), i < j, that are `taken`; the sides of the polygon may be among
    them, but for the one from its last to its first corner.
    """
    count = len(polygon)
    length = np.linalg.norm(vertices[polygon][:, None] - vertices[polygon][None], axis=2)
    names = polygon.tolist()
    for row in range(count):
        for column in range(row + 2, count):
            if _edge(names[row], names[column]) in taken:
                length[row, column] = np.inf
    cost = np.zeros((count, count))
    apex = np.zeros((count, count), dtype=np.int64)
    for step in range(2, count):
        for row in range(count - step):
            column = row + step
            total = cost[row, row + 1 : column] + cost[row + 1 : column, column]
            best = int(total.argmin())
            apex[row, column] = row + 1 + best
            cost[row, column] = total[best] + length[row, column]
    if not np.isfinite(cost[0, -1]):
        return np.empty((0, 3), dtype=np.int64)
    triangles, waiting = [], [(0, count - 1)]
    while waiting:
        row, column = waiting.pop()
        if column - row >= 2:
            middle = int(apex[row, column])
            triangles.append((row, middle, column))
            waiting += [(row, middle), (middle, column)]
    found: Ints = polygon[np.array(triangles, dtype=np.int64)]
    return found
