"""Compiled: edges of a triangulation flipped on its surface until it is Delaunay.

The triangles are known by the lengths of their sides alone. Side k of face f goes from its corner
k to its corner k + 1 and has the number 3 f + k; `glue` (3 m,) is the number of the same side seen
from the neighbor, or -1.
"""

from __future__ import annotations

import math

import numpy as np

from sherd.compiled import compiled

__all__ = ["flip_to_delaunay"]

# Cotangents that add up to less than rounding are no reason for a flip, nor for the flip back.
ROUNDING = 1e-9


@compiled()
def flip_to_delaunay(faces, lengths, glue, most):
    """Flip edges whose opposite angles exceed pi together, at most so often; returns how often.

    `faces` (m, 3), `lengths` (m, 3) and `glue` are changed in place. Lengths must satisfy the
    triangle inequality with some margin.

    References
    ----------
    Fisher, Springborn, Bobenko, Schroeder, *An algorithm for the construction of intrinsic
    Delaunay triangulations with applications to digital geometry processing*, 2006, section 3.
    """
    count = len(glue)
    queue, waiting = np.empty(count, np.int64), np.zeros(count, np.uint8)
    head, size = 0, 0
    for side in range(count):
        if glue[side] > side:
            queue[size] = side
            waiting[side] = 1
            size += 1
    flips = 0
    old, new = np.empty(4, np.int64), np.empty(4, np.int64)
    beyond = np.empty(4, np.int64)
    while size > 0 and flips < most:
        side = queue[head]
        head = (head + 1) % count
        size -= 1
        waiting[side] = 0
        other = glue[side]
        f, g = side // 3, other // 3
        if other < 0 or f == g:
            continue
        s, t = side % 3, other % 3
        bc, ca = 3 * f + (s + 1) % 3, 3 * f + (s + 2) % 3
        ad, db = 3 * g + (t + 1) % 3, 3 * g + (t + 2) % 3
        diagonal = _flipped_length(
            lengths[f, s], lengths[f, (s + 1) % 3], lengths[f, (s + 2) % 3],
            lengths[g, (t + 1) % 3], lengths[g, (t + 2) % 3],
        )  # fmt: skip
        if diagonal < 0.0:
            continue
        old[0], old[1], old[2], old[3] = db, bc, ca, ad
        new[0], new[1], new[2], new[3] = 3 * f, 3 * f + 1, 3 * g, 3 * g + 1
        sides = (
            lengths[g, db % 3], lengths[f, bc % 3], lengths[f, ca % 3], lengths[g, ad % 3],
        )  # fmt: skip
        a, b, c, d = faces[f, s], faces[f, bc % 3], faces[f, ca % 3], faces[g, db % 3]
        for k in range(4):
            beyond[k] = glue[old[k]]
            for j in range(4):  # the two triangles may be glued to each other elsewhere too
                if glue[old[k]] == old[j]:
                    beyond[k] = new[j]
                    break
        faces[f, 0], faces[f, 1], faces[f, 2] = d, b, c
        faces[g, 0], faces[g, 1], faces[g, 2] = c, a, d
        lengths[f, 0], lengths[f, 1], lengths[f, 2] = sides[0], sides[1], diagonal
        lengths[g, 0], lengths[g, 1], lengths[g, 2] = sides[2], sides[3], diagonal
        glue[3 * f + 2], glue[3 * g + 2] = 3 * g + 2, 3 * f + 2
        for k in range(4):
            glue[new[k]] = beyond[k]
            if beyond[k] >= 0:
                glue[beyond[k]] = new[k]
        flips += 1
        for k in range(4):
            if beyond[k] >= 0 and waiting[new[k]] == 0 and waiting[beyond[k]] == 0:
                queue[(head + size) % count] = new[k]
                waiting[new[k]] = 1
                size += 1
    return flips


@compiled()
def _flipped_length(ab, bc, ca, ad, db):
    """Length from c to d across the edge a b, or -1 if the edge may stay."""
    # a at the origin, b on the x axis, c above and d below
    x, u = (ab * ab + ca * ca - bc * bc) / (2.0 * ab), (ab * ab + ad * ad - db * db) / (2.0 * ab)
    y, v = math.sqrt(max(ca * ca - x * x, 0.0)), math.sqrt(max(ad * ad - u * u, 0.0))
    # the cotangent at c is ((a - c) . (b - c)) / (ab y), at d likewise
    at_c, at_d = y * y - x * (ab - x), v * v - u * (ab - u)
    if at_c * v + at_d * y >= -ROUNDING * ab * ab * (y + v):
        return -1.0
    return math.hypot(x - u, y + v)
