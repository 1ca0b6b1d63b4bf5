"""Compiled elastic surface: rotations and positions that keep a mesh as rigid as possible.

    E(p) = sum over edges w_ij |p_i - p_j - R_ij (y_i - y_j)|^2 + sum_i (p_i - t_i)' D_i (p_i - t_i)

with y the rest positions, R_ij the mean of the rotations of the two ends, w_ij cotangent weights,
and data matrices D_i.

References
----------
Sorkine, Alexa, *As-rigid-as-possible surface modeling*, 2007, equations 3, 5 and 8.
Horn, *Closed-form solution of absolute orientation using unit quaternions*, 1987, section 4.
Theobald, *Rapid calculation of RMSDs using a quaternion-based characteristic polynomial*, 2005.
"""

from __future__ import annotations

import math

import numpy as np

from sherd.arrays import Floats
from sherd.compiled import compiled
from sherd.surface.elastic_surface import ElasticSurface
from sherd.threads import over_rows

__all__ = ["closest_rotations", "fit_rotations", "relax_positions", "softened", "strains"]


# The root is off by 1e-16 over its gap, and the eigenvector by that over the gap again: six digits.
SMALLEST_GAP = 1e-5


def fit_rotations(elastic: ElasticSurface, positions: Floats) -> Floats:
    """The rotations (n, 3, 3) that fit the edges at each vertex best."""
    rotations = np.empty((len(elastic.rest), 3, 3))
    over_rows(_fit_rotations, len(elastic.rest), elastic, positions, rotations)
    return rotations


def closest_rotations(matrices: Floats) -> Floats:
    """The rotation R of largest trace(R' M) for each matrix M (n, 3, 3)."""
    rotations = np.empty((len(matrices), 3, 3))
    over_rows(_closest_rotations, len(matrices), np.ascontiguousarray(matrices), rotations)
    return rotations


def strains(elastic: ElasticSurface, positions: Floats, rotations: Floats) -> Floats:
    """Root of each vertex's share of E over its edges' squared lengths (n,): relative strain."""
    result = np.empty(len(elastic.rest))
    over_rows(_strains, len(elastic.rest), elastic, positions, rotations, result)
    return result


def softened(elastic: ElasticSurface, strain: Floats) -> ElasticSurface:
    """Edge weights divided by 1 + strain^2, mean of both ends: where it strains, creases form."""
    weights = np.empty(len(elastic.weights))
    over_rows(_softened, len(strain), elastic, strain, weights)
    return elastic._replace(weights=weights)


@compiled()
def _fit_rotations(rows, elastic, positions, rotations):
    pointers, neighbors, weights, rest = elastic
    a = np.empty((3, 3))
    for i in range(rows[0], rows[1]):
        a[:] = 0.0
        for entry in range(pointers[i], pointers[i + 1]):
            j = neighbors[entry]
            for r in range(3):
                moved = weights[entry] * (positions[j, r] - positions[i, r])
                for c in range(3):
                    a[r, c] += moved * (rest[j, c] - rest[i, c])
        _closest_rotation(a, rotations[i])


@compiled()
def _closest_rotations(rows, matrices, rotations):
    for i in range(rows[0], rows[1]):
        _closest_rotation(matrices[i], rotations[i])


@compiled()
def _closest_rotation(a, rotation):
    """Rotation R of largest trace(R' a): the top eigenvector of Horn's matrix is its quaternion.

    The largest eigenvalue is the root of the characteristic polynomial that Newton's method
    reaches from above (Theobald 2005); its eigenvector is a column of the adjugate matrix. Where
    it is nearly a double root, as for an edge alone, the general solver decides.
    """
    norm = 0.0
    for r in range(3):
        for c in range(3):
            norm += a[r, c] * a[r, c]
    norm = math.sqrt(norm)
    if norm == 0.0:
        for r in range(3):
            for c in range(3):
                rotation[r, c] = 1.0 if r == c else 0.0
        return
    horn = _horn(a, norm)
    top = _largest_root(a, norm, horn)
    less = (
        (horn[0][0] - top, horn[0][1], horn[0][2], horn[0][3]),
        (horn[1][0], horn[1][1] - top, horn[1][2], horn[1][3]),
        (horn[2][0], horn[2][1], horn[2][2] - top, horn[2][3]),
        (horn[3][0], horn[3][1], horn[3][2], horn[3][3] - top),
    )
    # the adjugate of rank one is a multiple of q q', so its largest column is at its largest
    # diagonal entry
    (ww, xx, yy, zz), (wx, wy, wz, xy, xz, yz) = _adjugate(less)
    most = max(abs(ww), abs(xx), abs(yy), abs(zz))
    if most == abs(ww):
        w, x, y, z = ww, wx, wy, wz
    elif most == abs(xx):
        w, x, y, z = wx, xx, xy, xz
    elif most == abs(yy):
        w, x, y, z = wy, xy, yy, yz
    else:
        w, x, y, z = wz, xz, yz, zz
    size = math.sqrt(w * w + x * x + y * y + z * z)
    # the adjugate is the product of the three gaps to the other eigenvalues, and a has norm 1
    if size < SMALLEST_GAP:
        h, vectors = np.array(horn), np.empty((4, 4))
        best, size = _top_eigenvector(h, vectors), 1.0
        w, x, y, z = vectors[best, 0], vectors[best, 1], vectors[best, 2], vectors[best, 3]
    w, x, y, z = w / size, x / size, y / size, z / size
    rotation[0, 0] = w * w + x * x - y * y - z * z
    rotation[1, 1] = w * w - x * x + y * y - z * z
    rotation[2, 2] = w * w - x * x - y * y + z * z
    rotation[0, 1], rotation[1, 0] = 2 * (x * y - w * z), 2 * (x * y + w * z)
    rotation[0, 2], rotation[2, 0] = 2 * (x * z + w * y), 2 * (x * z - w * y)
    rotation[1, 2], rotation[2, 1] = 2 * (y * z - w * x), 2 * (y * z + w * x)


@compiled(inline="always")
def _horn(a, norm):
    """Horn's symmetric traceless matrix (4 rows of 4) of a (3, 3) over its norm."""
    trace = (a[0, 0] + a[1, 1] + a[2, 2]) / norm
    x, y, z = 2 * a[0, 0] / norm - trace, 2 * a[1, 1] / norm - trace, 2 * a[2, 2] / norm - trace
    wx, wy, wz = (
        (a[2, 1] - a[1, 2]) / norm, (a[0, 2] - a[2, 0]) / norm, (a[1, 0] - a[0, 1]) / norm,
    )  # fmt: skip
    xy, xz, yz = (
        (a[1, 0] + a[0, 1]) / norm, (a[0, 2] + a[2, 0]) / norm, (a[2, 1] + a[1, 2]) / norm,
    )  # fmt: skip
    return (trace, wx, wy, wz), (wx, x, xy, xz), (wy, xy, y, yz), (wz, xz, yz, z)


@compiled(inline="always")
def _minors(h):
    """Determinants of two rows and two columns: of the first rows of h (4, 4), of the last ones.

    By columns 01, 02, 03, 12, 13, 23.
    """
    p, q, r, s = h
    upper = (
        p[0] * q[1] - q[0] * p[1], p[0] * q[2] - q[0] * p[2], p[0] * q[3] - q[0] * p[3],
        p[1] * q[2] - q[1] * p[2], p[1] * q[3] - q[1] * p[3], p[2] * q[3] - q[2] * p[3],
    )  # fmt: skip
    lower = (
        r[0] * s[1] - s[0] * r[1], r[0] * s[2] - s[0] * r[2], r[0] * s[3] - s[0] * r[3],
        r[1] * s[2] - s[1] * r[2], r[1] * s[3] - s[1] * r[3], r[2] * s[3] - s[2] * r[3],
    )  # fmt: skip
    return upper, lower


@compiled(inline="always")
def _adjugate(h):
    """The diagonal (4,) of the adjugate of a symmetric h (4, 4), and what is above it, by rows."""
    upper, lower = _minors(h)
    p, q, r, s = h
    diagonal = (
        q[1] * lower[5] - q[2] * lower[4] + q[3] * lower[3],
        p[0] * lower[5] - p[2] * lower[2] + p[3] * lower[1],
        s[0] * upper[4] - s[1] * upper[2] + s[3] * upper[0],
        r[0] * upper[3] - r[1] * upper[1] + r[2] * upper[0],
    )
    above = (
        -p[1] * lower[5] + p[2] * lower[4] - p[3] * lower[3],
        s[1] * upper[5] - s[2] * upper[4] + s[3] * upper[3],
        -r[1] * upper[5] + r[2] * upper[4] - r[3] * upper[3],
        -s[0] * upper[5] + s[2] * upper[2] - s[3] * upper[1],
        r[0] * upper[5] - r[2] * upper[2] + r[3] * upper[1],
        -r[0] * upper[4] + r[1] * upper[2] - r[3] * upper[0],
    )
    return diagonal, above


@compiled(inline="always")
def _largest_root(a, norm, horn):
    """Largest eigenvalue of Horn's matrix of a (3, 3) over its norm, by Newton's method from above.

    Its characteristic polynomial is x^4 - 2 x^2 - 8 det(a / norm) x + det(horn): Theobald 2005.
    """
    determinant = (
        a[0, 0] * (a[1, 1] * a[2, 2] - a[1, 2] * a[2, 1])
        - a[0, 1] * (a[1, 0] * a[2, 2] - a[1, 2] * a[2, 0])
        + a[0, 2] * (a[1, 0] * a[2, 1] - a[1, 1] * a[2, 0])
    )
    c1 = -8.0 * determinant / (norm * norm * norm)
    u, v = _minors(horn)
    c0 = u[0] * v[5] - u[1] * v[4] + u[2] * v[3] + u[3] * v[2] - u[4] * v[1] + u[5] * v[0]
    x = math.sqrt(3.0)  # no eigenvalue of four with sum zero and sum of squares 4 is larger
    for _ in range(50):
        value = ((x * x - 2.0) * x + c1) * x + c0
        slope = (4.0 * x * x - 4.0) * x + c1
        if slope <= 0.0:
            break
        step = value / slope
        x -= step
        if abs(step) < 1e-14 * x:
            break
    return x


@compiled()
def _top_eigenvector(h, vectors):
    """Row of `vectors` (4, 4) with the unit eigenvector of the largest eigenvalue of h (4, 4).

    Cyclic Jacobi rotations, which leave the eigenvalues on the diagonal of h: Golub and Van Loan,
    *Matrix computations*, 2013, section 8.5.3. LAPACK's solver takes seconds to compile.
    """
    for k in range(4):
        for j in range(4):
            vectors[k, j] = 1.0 if k == j else 0.0
    for _ in range(12):  # they converge quadratically, after five sweeps or six
        for p in range(3):
            for q in range(p + 1, 4):
                if h[p, q] == 0.0:
                    continue
                tau = 0.5 * (h[q, q] - h[p, p]) / h[p, q]
                t = (1.0 if tau >= 0.0 else -1.0) / (abs(tau) + math.hypot(1.0, tau))
                c = 1.0 / math.hypot(1.0, t)
                s = t * c
                for k in range(4):
                    at_p, at_q = h[k, p], h[k, q]
                    h[k, p], h[k, q] = c * at_p - s * at_q, s * at_p + c * at_q
                for k in range(4):
                    at_p, at_q = h[p, k], h[q, k]
                    h[p, k], h[q, k] = c * at_p - s * at_q, s * at_p + c * at_q
                    at_p, at_q = vectors[p, k], vectors[q, k]
                    vectors[p, k], vectors[q, k] = c * at_p - s * at_q, s * at_p + c * at_q
    best = 0
    for k in range(1, 4):
        best = k if h[k, k] > h[best, best] else best
    return best


@compiled()
def relax_positions(elastic, rotations, data, pull, positions, tolerance, limit):
    """Positions (n, 3) of least energy for fixed rotations, by conjugate gradients.

    They start from `positions`; `pull` (n, 3) are the data matrices times their targets.
    Preconditioned by the inverse of the 3 x 3 diagonal blocks; stops when the residual has
    fallen by `tolerance`, or after `limit` steps. On one core: a step is shorter than what it
    costs to wait for another core that is busy with something else.
    """
    pointers, neighbors, weights, rest = elastic
    count = len(rest)
    x = positions.copy()
    residual, z, product = np.empty((count, 3)), np.empty((count, 3)), np.empty((count, 3))
    blocks, inverse = np.empty((count, 6)), np.empty((count, 6))
    rho = 0.0
    for i in range(count):
        _blocks(i, pointers, weights, data, blocks, inverse)
        _multiply(i, pointers, neighbors, weights, blocks, x, product)
        _right_side(i, pointers, neighbors, weights, rest, rotations, pull, residual)
        for r in range(3):
            residual[i, r] -= product[i, r]
        rho += _precondition(i, inverse, residual, z)
    direction = z.copy()
    goal = rho * tolerance * tolerance
    for _ in range(limit):
        if rho <= goal or rho <= 0.0:
            break
        bend = 0.0
        for i in range(count):
            bend += _multiply(i, pointers, neighbors, weights, blocks, direction, product)
        alpha = rho / bend
        following = 0.0
        for i in range(count):
            for r in range(3):
                x[i, r] += alpha * direction[i, r]
                residual[i, r] -= alpha * product[i, r]
            following += _precondition(i, inverse, residual, z)
        beta = following / rho
        for i in range(count):
            for r in range(3):
                direction[i, r] = z[i, r] + beta * direction[i, r]
        rho = following
    return x


@compiled(inline="always")
def _blocks(i, pointers, weights, data, blocks, inverse):
    """Write the diagonal block of one vertex, (xx, xy, xz, yy, yz, zz), and its inverse."""
    diagonal = 1e-12
    for entry in range(pointers[i], pointers[i + 1]):
        diagonal += weights[entry]
    xx, yy, zz = data[i, 0, 0] + diagonal, data[i, 1, 1] + diagonal, data[i, 2, 2] + diagonal
    xy, xz, yz = data[i, 0, 1], data[i, 0, 2], data[i, 1, 2]
    block = (xx, xy, xz, yy, yz, zz)
    minors = (
        yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy,
        xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy,
    )  # fmt: skip
    scale = 1.0 / (xx * minors[0] + xy * minors[1] + xz * minors[2])
    for k in range(6):
        blocks[i, k] = block[k]
        inverse[i, k] = scale * minors[k]


@compiled(inline="always")
def _multiply(i, pointers, neighbors, weights, blocks, x, out):
    """Row i of the energy's matrix times x, into `out`; returns its product with x."""
    b = blocks[i]
    x0, x1, x2 = x[i, 0], x[i, 1], x[i, 2]
    t0 = b[0] * x0 + b[1] * x1 + b[2] * x2
    t1 = b[1] * x0 + b[3] * x1 + b[4] * x2
    t2 = b[2] * x0 + b[4] * x1 + b[5] * x2
    for entry in range(pointers[i], pointers[i + 1]):
        j, weight = neighbors[entry], weights[entry]
        t0 -= weight * x[j, 0]
        t1 -= weight * x[j, 1]
        t2 -= weight * x[j, 2]
    out[i, 0], out[i, 1], out[i, 2] = t0, t1, t2
    return t0 * x0 + t1 * x1 + t2 * x2


@compiled(inline="always")
def _right_side(i, pointers, neighbors, weights, rest, rotations, pull, out):
    t0, t1, t2 = pull[i, 0], pull[i, 1], pull[i, 2]
    for entry in range(pointers[i], pointers[i + 1]):
        j, weight = neighbors[entry], 0.5 * weights[entry]
        for c in range(3):
            edge = weight * (rest[i, c] - rest[j, c])
            t0 += (rotations[i, 0, c] + rotations[j, 0, c]) * edge
            t1 += (rotations[i, 1, c] + rotations[j, 1, c]) * edge
            t2 += (rotations[i, 2, c] + rotations[j, 2, c]) * edge
    out[i, 0], out[i, 1], out[i, 2] = t0, t1, t2


@compiled(inline="always")
def _precondition(i, inverse, residual, out):
    """Row i of the inverse blocks times the residual, into `out`; returns their product."""
    b = inverse[i]
    x0, x1, x2 = residual[i, 0], residual[i, 1], residual[i, 2]
    t0 = b[0] * x0 + b[1] * x1 + b[2] * x2
    t1 = b[1] * x0 + b[3] * x1 + b[4] * x2
    t2 = b[2] * x0 + b[4] * x1 + b[5] * x2
    out[i, 0], out[i, 1], out[i, 2] = t0, t1, t2
    return t0 * x0 + t1 * x1 + t2 * x2


@compiled()
def _strains(rows, elastic, positions, rotations, result):
    pointers, neighbors, weights, rest = elastic
    for i in range(rows[0], rows[1]):
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


@compiled()
def _softened(rows, elastic, strain, result):
    pointers, neighbors, weights, _ = elastic
    for i in range(rows[0], rows[1]):
        here = 1.0 / (1.0 + strain[i] * strain[i])
        for entry in range(pointers[i], pointers[i + 1]):
            there = strain[neighbors[entry]]
            result[entry] = weights[entry] * 0.5 * (here + 1.0 / (1.0 + there * there))
