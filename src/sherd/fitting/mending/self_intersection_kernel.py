"""Compiled search for pairs of faces that pierce each other, by sweep and prune.

Two triangles in general position meet if and only if an edge of one of them pierces the other; an
edge pierces a triangle if its ends lie on both sides of the plane and the line passes all three
edges on the same side, five signs of volumes of tetrahedra (Segura and Feito, *Algorithms to test
ray-triangle intersection*, 2001, section 2). Touching is no piercing: coordinates are taken as
they are, and what lies in one plane is not found.
"""

from __future__ import annotations

from sherd.compiled import compiled

__all__ = ["count_pierced", "write_pierced"]


@compiled()
def count_pierced(rows, vertices, faces, low, high, strips, counts):
    """Write for each entry (e,) how many later ones of its strip it pierces or is pierced by.

    An entry is one of the `faces` (e, 3) in one of the strips that it reaches into; `strips` (2, e)
    are that strip and its first one. Entries are sorted by strip and by the first row of `low`
    (3, e), of which `high` (3, e) is the other corner of each face's box.
    """
    for first in range(rows[0], rows[1]):
        second = _next_pierced(vertices, faces, low, high, strips, first, first)
        while second > 0:
            counts[first] += 1
            second = _next_pierced(vertices, faces, low, high, strips, first, second)


@compiled()
def write_pierced(rows, vertices, faces, low, high, strips, ends, pairs):
    """Write the pairs (k, 2) that were counted; `ends` (e,) are the sums of the counts so far."""
    for first in range(rows[0], rows[1]):
        second = first
        for place in range(ends[first - 1] if first else 0, ends[first]):
            second = _next_pierced(vertices, faces, low, high, strips, first, second)
            pairs[place, 0], pairs[place, 1] = first, second


@compiled()
def _next_pierced(vertices, faces, low, high, strips, first, second):
    """The entry next to `second` that `first` pierces or is pierced by; 0 if there is no more.

    Two faces that reach into several strips both meet in the first of these only.
    """
    for later in range(second + 1, len(faces)):
        if strips[0, later] != strips[0, first] or low[0, later] > high[0, first]:
            break
        # written out: a function of arrays, called for each pair, takes six times as long
        if (
            low[1, later] <= high[1, first]
            and low[1, first] <= high[1, later]
            and low[2, later] <= high[2, first]
            and low[2, first] <= high[2, later]
            and max(strips[1, first], strips[1, later]) == strips[0, first]
            and _meet(vertices, faces, first, later)
        ):
            return later
    return 0


# Corners are numbers of vertices below: to take a row of an array costs as much as a volume.


@compiled()
def _meet(vertices, faces, first, second):
    """Whether an edge of one face pierces the other; edges at shared corners cannot."""
    shared = 0
    for i in range(3):
        for j in range(3):
            if faces[first, i] == faces[second, j]:
                shared += 1
    return shared < 2 and (
        _pierced(vertices, faces, first, second) or _pierced(vertices, faces, second, first)
    )


@compiled()
def _pierced(vertices, faces, face, other):
    """Whether an edge of the other face that meets no corner of the face goes through it."""
    p, q, r = faces[other, 0], faces[other, 1], faces[other, 2]
    at_p = _side(vertices, faces, face, p)
    at_q = _side(vertices, faces, face, q)
    at_r = _side(vertices, faces, face, r)
    # nearly all faces whose boxes meet lie on one side of each other; a shared corner has side 0
    if not (min(at_p, at_q, at_r) < 0 < max(at_p, at_q, at_r)):
        return False
    return (
        (_opposite(at_p, at_q) and _passes(vertices, p, q, faces, face))
        or (_opposite(at_q, at_r) and _passes(vertices, q, r, faces, face))
        or (_opposite(at_r, at_p) and _passes(vertices, r, p, faces, face))
    )


@compiled()
def _opposite(one, other):
    return (one > 0 and other < 0) or (one < 0 and other > 0)


@compiled()
def _side(vertices, faces, face, p):
    """Above 0 where the vertex is on one side of the face, below 0 on the other."""
    return _volume(vertices, faces[face, 0], faces[face, 1], faces[face, 2], p)


@compiled()
def _passes(vertices, p, q, faces, face):
    """Whether the line from p to q has all three edges of the face on the same side."""
    u, v, w = faces[face, 0], faces[face, 1], faces[face, 2]
    first, second = _volume(vertices, p, q, u, v), _volume(vertices, p, q, v, w)
    third = _volume(vertices, p, q, w, u)
    return (first > 0 and second > 0 and third > 0) or (first < 0 and second < 0 and third < 0)


@compiled()
def _volume(vertices, a, b, c, d):
    """Six times the signed volume of a tetrahedron."""
    x, y, z = vertices[d, 0], vertices[d, 1], vertices[d, 2]
    x0, y0, z0 = vertices[a, 0] - x, vertices[a, 1] - y, vertices[a, 2] - z
    x1, y1, z1 = vertices[b, 0] - x, vertices[b, 1] - y, vertices[b, 2] - z
    x2, y2, z2 = vertices[c, 0] - x, vertices[c, 1] - y, vertices[c, 2] - z
    return x0 * (y1 * z2 - z1 * y2) - y0 * (x1 * z2 - z1 * x2) + z0 * (x1 * y2 - y1 * x2)
