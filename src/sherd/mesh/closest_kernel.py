"""Compiled closest points on triangles; numba loads slowly, so import this where it is used."""

from __future__ import annotations

import math

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.compiled import compiled
from sherd.threads import over_rows

__all__ = ["closest_on_faces"]


def closest_on_faces(
    positions: Floats, near: Ints, corners: Floats, balls: Floats, penalty: Floats
) -> tuple[Ints, Floats]:
    """The face (p,) and weights (p, 3) of the point closest to each position (p, 3).

    Ericson, *Real-Time Collision Detection*, 2005, section 5.1.5.

    Parameters
    ----------
    positions
        Where to search from.
    near
        (g, k) the faces that are searched: each row serves p / g positions in turn.
    corners, balls
        (m, 3, 3) and (m, 4) of the faces; see :func:`sherd.mesh.geometry.face_balls`.
    penalty
        (g, k), l^2, is added to the squared distances.
    """
    faces, weights = np.empty(len(positions), dtype=np.int64), np.empty((len(positions), 3))
    over_rows(
        _closest_on_faces, len(positions), np.ascontiguousarray(positions), near, corners, balls,
        penalty, faces, weights,
    )  # fmt: skip
    return faces, weights


@compiled()
def _closest_on_faces(rows, positions, near, corners, balls, penalty, faces, weights):
    served = max(len(positions) // max(len(near), 1), 1)
    for row in range(rows[0], rows[1]):
        best = np.inf
        group = row // served
        faces[row] = near[group, 0]
        weights[row, 0], weights[row, 1], weights[row, 2] = 1.0, 0.0, 0.0
        for k in range(near.shape[1]):
            face = near[group, k]
            # most faces are known not to be the closest by the ball around them
            away = 0.0
            for x in range(3):
                away += (balls[face, x] - positions[row, x]) ** 2
            away = max(math.sqrt(away) - balls[face, 3], 0.0)
            if away * away + penalty[group, k] > best:
                continue
            a, b, c = corners[face]
            v, w = _closest_weights(positions[row], a, b, c)
            distance = penalty[group, k]
            for x in range(3):
                foot = a[x] + v * (b[x] - a[x]) + w * (c[x] - a[x])
                distance += (foot - positions[row, x]) ** 2
            if distance < best:
                best = distance
                faces[row] = face
                weights[row, 0], weights[row, 1], weights[row, 2] = 1.0 - v - w, v, w


@compiled()
def _closest_weights(p, a, b, c):  # noqa: PLR0911
    """Weights of b and c at the point of the triangle closest to p."""
    d1 = d2 = d3 = d4 = d5 = d6 = 0.0
    for x in range(3):
        ab, ac = b[x] - a[x], c[x] - a[x]
        d1 += ab * (p[x] - a[x])
        d2 += ac * (p[x] - a[x])
        d3 += ab * (p[x] - b[x])
        d4 += ac * (p[x] - b[x])
        d5 += ab * (p[x] - c[x])
        d6 += ac * (p[x] - c[x])
    if d1 <= 0.0 and d2 <= 0.0:
        return 0.0, 0.0
    if d3 >= 0.0 and d4 <= d3:
        return 1.0, 0.0
    if d6 >= 0.0 and d5 <= d6:
        return 0.0, 1.0
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        return d1 / max(d1 - d3, 1e-300), 0.0
    vb = d5 * d2 - d1 * d6
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        return 0.0, d2 / max(d2 - d6, 1e-300)
    va = d3 * d6 - d5 * d4
    if va <= 0.0 and d4 >= d3 and d5 >= d6:
        w = (d4 - d3) / max((d4 - d3) + (d5 - d6), 1e-300)
        return 1.0 - w, w
    total = max(va + vb + vc, 1e-300)
    # a triangle without area may have lost all digits of these
    v = min(max(vb / total, 0.0), 1.0)
    return v, min(max(vc / total, 0.0), 1.0 - v)
