"""Compiled elastic surface: rotations and positions that keep a mesh as rigid as possible.

    E(p) = sum over edges w_ij |p_i - p_j - R_ij (y_i - y_j)|^2 + sum_i (p_i - t_i)' D_i (p_i - t_i)

with y the rest positions, R_ij the mean of the rotations of the two ends, w_ij cotangent weights,
and data matrices D_i.

References
----------
Sorkine, Alexa, *As-rigid-as-possible surface modeling*, 2007, equations 3, 5 and 8.
Horn, *Closed-form solution of absolute orientation using unit quaternions*, 1987, section 4.
"""

from __future__ import annotations

import math

import numba
import numpy as np

__all__ = ["fit_rotations", "relax_positions", "softened", "strains"]


@numba.njit(cache=True, parallel=True)
def fit_rotations(pointers, neighbors, weights, rest, positions, rotations):  # type: ignore[no-untyped-def]
    """Write the rotations (n, 3, 3) that fit the edges at each vertex best."""
    for i in numba.prange(len(rest)):
        a = np.zeros((3, 3))
        for entry in range(pointers[i], pointers[i + 1]):
            j = neighbors[entry]
            for r in range(3):
                moved = weights[entry] * (positions[j, r] - positions[i, r])
                for c in range(3):
                    a[r, c] += moved * (rest[j, c] - rest[i, c])
        _closest_rotation(a, rotations[i])


@numba.njit(cache=True)
def _closest_rotation(a, rotation):  # type: ignore[no-untyped-def]
    """Rotation R of largest trace(R' a): the top eigenvector of Horn's matrix is its quaternion."""
    s = a.T
    h = np.empty((4, 4))
    h[0, 0] = s[0, 0] + s[1, 1] + s[2, 2]
    h[1, 1] = s[0, 0] - s[1, 1] - s[2, 2]
    h[2, 2] = -s[0, 0] + s[1, 1] - s[2, 2]
    h[3, 3] = -s[0, 0] - s[1, 1] + s[2, 2]
    h[0, 1] = h[1, 0] = s[1, 2] - s[2, 1]
    h[0, 2] = h[2, 0] = s[2, 0] - s[0, 2]
    h[0, 3] = h[3, 0] = s[0, 1] - s[1, 0]
    h[1, 2] = h[2, 1] = s[0, 1] + s[1, 0]
    h[1, 3] = h[3, 1] = s[2, 0] + s[0, 2]
    h[2, 3] = h[3, 2] = s[1, 2] + s[2, 1]
    w, x, y, z = np.linalg.eigh(h)[1][:, 3]
    rotation[0, 0] = w * w + x * x - y * y - z * z
    rotation[1, 1] = w * w - x * x + y * y - z * z
    rotation[2, 2] = w * w - x * x - y * y + z * z
    rotation[0, 1], rotation[1, 0] = 2 * (x * y - w * z), 2 * (x * y + w * z)
    rotation[0, 2], rotation[2, 0] = 2 * (x * z + w * y), 2 * (x * z - w * y)
    rotation[1, 2], rotation[2, 1] = 2 * (y * z - w * x), 2 * (y * z + w * x)


@numba.njit(cache=True)
def _apply(pointers, neighbors, weights, data, x, out):  # type: ignore[no-untyped-def]
    for i in range(len(x)):
        for r in range(3):
            total = data[i, r, 0] * x[i, 0] + data[i, r, 1] * x[i, 1] + data[i, r, 2] * x[i, 2]
            for entry in range(pointers[i], pointers[i + 1]):
                total += weights[entry] * (x[i, r] - x[neighbors[entry], r])
            out[i, r] = total


@numba.njit(cache=True)
def _right_side(pointers, neighbors, weights, rest, rotations, pull, out):  # type: ignore[no-untyped-def]
    for i in range(len(rest)):
        for r in range(3):
            total = pull[i, r]
            for entry in range(pointers[i], pointers[i + 1]):
                j = neighbors[entry]
                for c in range(3):
                    turn = 0.5 * (rotations[i, r, c] + rotations[j, r, c])
                    total += weights[entry] * turn * (rest[i, c] - rest[j, c])
            out[i, r] = total


@numba.njit(cache=True)
def relax_positions(  # type: ignore[no-untyped-def]  # noqa: PLR0913
    pointers, neighbors, weights, rest, rotations, data, pull, positions, tolerance, limit
):
    """Positions (n, 3) of least energy for fixed rotations, by conjugate gradients.

    They start from `positions`; `pull` (n, 3) are the data matrices times their targets.
    Preconditioned by the inverse of the 3 x 3 diagonal blocks; stops when the residual has
    fallen by `tolerance`, or after `limit` steps.
    """
    count = len(rest)
    x = positions.copy()
    right = np.empty((count, 3))
    _right_side(pointers, neighbors, weights, rest, rotations, pull, right)
    product = np.empty((count, 3))
    _apply(pointers, neighbors, weights, data, x, product)
    inverse = np.empty((count, 3, 3))
    for i in range(count):
        block = data[i].copy()
        diagonal = 1e-12
        for entry in range(pointers[i], pointers[i + 1]):
            diagonal += weights[entry]
        for r in range(3):
            block[r, r] += diagonal
        inverse[i] = np.linalg.inv(block)
    residual = right - product
    z = np.empty((count, 3))
    _precondition(inverse, residual, z)
    direction = z.copy()
    rho = (residual * z).sum()
    goal = rho * tolerance * tolerance
    for _ in range(limit):
        if rho <= goal or rho <= 0.0:
            break
        _apply(pointers, neighbors, weights, data, direction, product)
        alpha = rho / (direction * product).sum()
        x += alpha * direction
        residual -= alpha * product
        _precondition(inverse, residual, z)
        following = (residual * z).sum()
        direction = z + (following / rho) * direction
        rho = following
    return x


@numba.njit(cache=True)
def _precondition(inverse, residual, out):  # type: ignore[no-untyped-def]
    for i in range(len(residual)):
        for r in range(3):
            out[i, r] = (
                inverse[i, r, 0] * residual[i, 0]
                + inverse[i, r, 1] * residual[i, 1]
                + inverse[i, r, 2] * residual[i, 2]
            )


@numba.njit(cache=True, parallel=True)
def strains(pointers, neighbors, weights, rest, positions, rotations):  # type: ignore[no-untyped-def]
    """Root of each vertex's share of E over its edges' squared lengths (n,): relative strain."""
    count = len(rest)
    result = np.empty(count)
    for i in numba.prange(count):
        moved, size = 0.0, 1e-30
        for entry in range(pointers[i], pointers[i + 1]):
            j = neighbors[entry]
            for r in range(3):
                turned = 0.0
                for c in range(3):
                    turned += rotations[i, r, c] * (rest[j, c] - rest[i, c])
                moved += weights[entry] * (positions[j, r] - positions[i, r] - turned) ** 2
                size += weights[entry] * (rest[j, r] - rest[i, r]) ** 2
        result[i] = math.sqrt(moved / size)
    return result


@numba.njit(cache=True, parallel=True)
def softened(pointers, neighbors, weights, strain):  # type: ignore[no-untyped-def]
    """Edge weights divided by 1 + strain^2, mean of both ends: where it strains, creases form."""
    result = np.empty(len(weights))
    for i in numba.prange(len(strain)):
        here = 1.0 / (1.0 + strain[i] * strain[i])
        for entry in range(pointers[i], pointers[i + 1]):
            there = strain[neighbors[entry]]
            result[entry] = weights[entry] * 0.5 * (here + 1.0 / (1.0 + there * there))
    return result
