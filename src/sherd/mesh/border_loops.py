"""Border loops of a mesh, in the order of its faces, and a strip of faces between two loops."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.mesh.topology import half_edges

__all__ = [
    "border_loops",
    "filled_loop",
    "is_watertight",
    "strip_between",
    "without_pinched_borders",
]


def border_half_edges(faces: Ints) -> Ints:
    """Half edges (b, 2) of faces, in their direction, that no other face has in reverse."""
    halves = half_edges(faces)
    base = int(faces.max(initial=0)) + 1
    key, reverse = halves[:, 0] * base + halves[:, 1], halves[:, 1] * base + halves[:, 0]
    border: Ints = halves[~np.isin(key, reverse)]
    return border


def without_pinched_borders(faces: Ints) -> Ints:
    """Faces (k, 3) of which no vertex lies on the border twice, where loops would not be clear.

    Faces at such vertices are left out until there are none.
    """
    while len(faces):
        starts = border_half_edges(faces)[:, 0]
        pinched = np.flatnonzero(np.bincount(starts, minlength=1) > 1)
        if not len(pinched):
            break
        faces = faces[~np.isin(faces, pinched).any(axis=1)]
    return faces


def border_loops(faces: Ints) -> list[Ints]:
    """The loops that the border runs in, each in the direction of the faces, longest first.

    Of a mesh without pinched borders.
    """
    following = dict(border_half_edges(faces).tolist())
    loops = []
    while following:
        start, step = next(iter(following.items()))
        del following[start]
        loop = [start]
        while step != start and step in following:
            loop.append(step)
            step = following.pop(step)
        loops.append(np.array(loop, dtype=np.int64))
    return sorted(loops, key=len, reverse=True)


def strip_between(vertices: Floats, first: Ints, second: Ints) -> Ints:
    """Faces (p + q, 3) that close the gap between two border loops of p and q vertices.

    Both run in the direction of their own faces, so against each other; the faces of the strip
    continue both. It starts at the two nearest vertices and goes on with the shorter diagonal.

    Returns
    -------
    array
        Each edge of both loops belongs to one of them.
    """
    back = second[::-1]
    apart = np.linalg.norm(vertices[first][:, None] - vertices[back][None], axis=2)
    i, j = np.unravel_index(int(apart.argmin()), apart.shape)
    ahead, back = np.roll(first, -int(i)), np.roll(back, -int(j))
    return _advanced(vertices, np.append(ahead, ahead[0]), np.append(back, back[0]))


def _advanced(vertices: Floats, ahead: Ints, back: Ints) -> Ints:
    """Faces between two chains that run beside each other, the second against its own faces."""
    faces = []
    i = j = 0
    while i < len(ahead) - 1 or j < len(back) - 1:
        first = second = np.inf
        if i < len(ahead) - 1:
            first = float(np.linalg.norm(vertices[ahead[i + 1]] - vertices[back[j]]))
        if j < len(back) - 1:
            second = float(np.linalg.norm(vertices[back[j + 1]] - vertices[ahead[i]]))
        if first <= second:
            faces.append((ahead[i + 1], ahead[i], back[j]))
            i += 1
        else:
            faces.append((back[j], back[j + 1], ahead[i]))
            j += 1
    return np.array(faces, dtype=np.int64)


def filled_loop(loop: Ints) -> Ints:
    """Faces (p - 2, 3) that close a small border loop of p vertices, all at its first one."""
    first = np.full(len(loop) - 2, loop[0])
    return np.column_stack([loop[2:], loop[1:-1], first])


def is_watertight(faces: Ints) -> bool:
    """Whether the reverse of each half edge is one as well, and none comes twice."""
    halves = half_edges(faces)
    base = int(faces.max(initial=0)) + 1
    key = np.sort(halves[:, 0] * base + halves[:, 1])
    reverse = np.sort(halves[:, 1] * base + halves[:, 0])
    return bool(np.array_equal(key, reverse) and (np.diff(key) > 0).all())
