"""Compiled search for pairs of faces that pierce each other, by sweep and prune.

Two triangles in general position meet if and only if an edge of one of them pierces the other; an
edge pierces a triangle if its ends lie on both sides of the plane and the line passes all three
edges on the same side, five signs of volumes of tetrahedra (Segura and Feito, *Algorithms to test
ray-triangle intersection*, 2001, section 2). Touching is no piercing: coordinates are taken as
they are, and what lies in one plane is not found.
"""

from __future__ import annotations

from sherd.compiled import compiled

__all__ = ["piercing_pairs"]


@compiled()
def piercing_pairs(vertices, faces, order, low, high, pairs):
    """Write pairs (k, 2) of faces that pierce each other; returns how many there are in all.

    `order` (m,) are the faces by ascending `low` (m, 3) of the first axis; `high` (m, 3) is the
    other corner of each face's box. Where `pairs` is too short the rest is only counted.
    """
    found = 0
    for first in range(len(order)):
        f = order[first]
        for second in range(first + 1, len(order)):
            g = order[second]
            if low[g, 0] > high[f, 0]:
                break
            if low[g, 1] > high[f, 1] or low[f, 1] > high[g, 1]:
                continue
            if low[g, 2] > high[f, 2] or low[f, 2] > high[g, 2]:
                continue
            if _meet(vertices, faces[f], faces[g]):
                if found < len(pairs):
                    pairs[found, 0], pairs[found, 1] = min(f, g), max(f, g)
                found += 1
    return found


@compiled()
def _meet(vertices, f, g):
    """Whether an edge of one face pierces the other; edges at shared corners cannot."""
    shared = 0
    for i in range(3):
        for j in range(3):
            if f[i] == g[j]:
                shared += 1
    if shared >= 2:
        return False
    for k in range(3):
        a, b = f[k], f[(k + 1) % 3]
        if a not in g and b not in g and _pierces(vertices, a, b, g):
            return True
        a, b = g[k], g[(k + 1) % 3]
        if a not in f and b not in f and _pierces(vertices, a, b, f):
            return True
    return False


@compiled()
def _pierces(vertices, a, b, face):
    p, q = vertices[a], vertices[b]
    u, v, w = vertices[face[0]], vertices[face[1]], vertices[face[2]]
    above, below = _volume(u, v, w, p), _volume(u, v, w, q)
    if not ((above > 0 and below < 0) or (above < 0 and below > 0)):
        return False
    first, second, third = _volume(p, q, u, v), _volume(p, q, v, w), _volume(p, q, w, u)
    return (first > 0 and second > 0 and third > 0) or (first < 0 and second < 0 and third < 0)


@compiled(inline="always")
def _volume(a, b, c, d):
    """Six times the signed volume of a tetrahedron."""
    x0, y0, z0 = a[0] - d[0], a[1] - d[1], a[2] - d[2]
    x1, y1, z1 = b[0] - d[0], b[1] - d[1], b[2] - d[2]
    x2, y2, z2 = c[0] - d[0], c[1] - d[1], c[2] - d[2]
    return x0 * (y1 * z2 - z1 * y2) - y0 * (x1 * z2 - z1 * x2) + z0 * (x1 * y2 - y1 * x2)
