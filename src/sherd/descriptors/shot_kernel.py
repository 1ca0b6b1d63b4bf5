"""The compiled inner loops of SHOT: histograms of normals around points, in given frames."""

from __future__ import annotations

import math

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.compiled import compiled
from sherd.mesh.vertex_cells_kernel import sorted_into_cells
from sherd.threads import over_rows

__all__ = [
    "AZIMUTHS",
    "BINS",
    "neighborhood_moments",
    "shot_histograms",
    "vote",
]


# The grid of Salti, Tombari, Di Stefano 2014: 8 azimuth x 2 elevation x 2 radial sectors with 11
# bins for the cosine between the normal of a neighbor and the axis of the point.
AZIMUTHS = 8
ELEVATIONS = 2
SHELLS = 2
COSINES = 11
BINS = ELEVATIONS * SHELLS * COSINES
# Enough votes to fill the 352 bins several times over. A ball holds more only where a surface is
# crumpled or many times as dense as answers need, and then the time would grow with the square.
MOST_VOTES = 2000


def shot_histograms(
    vertices: Floats,
    normals: Floats,
    weights: Floats,
    queries: Ints,
    *,
    x_axes: Floats,
    z_axes: Floats,
    radii: tuple[float, ...],
) -> Floats:
    """Weighted histograms of normals in the spherical sectors around each query vertex.

    A neighbor adds its weight to the sectors by its place in the frame of the query, and inside a
    sector to the bin of the cosine between its normal and the z axis; all four coordinates are
    interpolated linearly, so that a histogram is a continuous function of the shape.

    Parameters
    ----------
    vertices, normals
        (n, 3) positions, l, and unit normals.
    weights
        (n,) weight of each vertex as a neighbor: its area, or zero to hide it.
    queries
        (q,) vertices described.
    x_axes, z_axes
        (q, 3) unit and orthogonal; azimuth is counted from x towards z cross x.
    radii
        Radii of the neighborhoods, l.

    Returns
    -------
    (q, r, 8, 44) float64
        Azimuth, then elevation, radius and cosine; each (8, 44) block has norm 1, or is zero
        where the ball holds no weight.

    References
    ----------
    Salti, Tombari, Di Stefano, *SHOT: unique signatures of histograms for surface and texture
    description*, 2014, section 4. Deviation: neighbors weigh their area, not 1, so that the
    meshing does not matter.
    """
    cells = sorted_into_cells(vertices, max(radii))
    histograms = np.zeros((len(queries), len(radii), AZIMUTHS, BINS))
    over_rows(
        _vote_all, len(queries), np.ascontiguousarray(vertices), np.ascontiguousarray(normals),
        weights, queries, np.ascontiguousarray(x_axes), np.ascontiguousarray(z_axes),
        np.array(radii), cells, histograms,
    )  # fmt: skip
    norms = np.sqrt((histograms**2).sum(axis=(2, 3), keepdims=True))
    histograms /= np.where(norms > 0, norms, 1.0)
    return histograms


def neighborhood_moments(
    vertices: Floats, weights: Floats, queries: Ints, *, radius: float
) -> tuple[Floats, Floats]:
    """Covariance (q, 3, 3) l^2 and mean (q, 3) l of the neighbors' offsets from each query.

    The covariance weighs a neighbor by `weight * (radius - distance)`, the mean by its weight
    alone; both are zero for an empty ball. Tombari et al. 2010, equation 1.
    """
    covariance = np.zeros((len(queries), 3, 3))
    mean = np.zeros((len(queries), 3))
    cells = sorted_into_cells(vertices, radius)
    over_rows(
        _moments, len(queries), np.ascontiguousarray(vertices), weights, queries, radius, cells,
        covariance, mean,
    )  # fmt: skip
    return covariance, mean


@compiled()
def _vote_all(  # noqa: PLR0913
    rows, vertices, normals, weights, queries, x_axes, z_axes, radii, cells, histograms
):
    for row in range(rows[0], rows[1]):
        frame = (x_axes[row], z_axes[row])
        vote(vertices, normals, weights, queries[row], frame, radii, cells, histograms[row])


@compiled()
def vote(vertices, normals, weights, query, frame, radii, cells, histogram):  # noqa: PLR0915
    """Add the votes of all neighbors of one vertex to its histogram (r, 8, 44).

    Each is shared linearly between the two nearest bins of each of the four coordinates.
    `frame` are its x and z axis; `cells` are those of :func:`sorted_into_cells`.
    """
    # Scalars instead of small arrays: an allocation per neighbor would triple the time.
    order, starts, origin, size, shape = cells
    x_axis, z_axis = frame
    reach = radii.max()
    px, py, pz = vertices[query, 0], vertices[query, 1], vertices[query, 2]
    x0, x1, x2 = x_axis[0], x_axis[1], x_axis[2]
    z0, z1, z2 = z_axis[0], z_axis[1], z_axis[2]
    y0, y1, y2 = z1 * x2 - z2 * x1, z2 * x0 - z0 * x2, z0 * x1 - z1 * x0
    ci = math.floor((px - origin[0]) / size)
    cj = math.floor((py - origin[1]) / size)
    ck = math.floor((pz - origin[2]) / size)
    k_low, k_high = max(ck - 1, 0), min(ck + 2, shape[2])
    stride = _stride(vertices, query, cells, reach)
    number = 0
    for i in range(max(ci - 1, 0), min(ci + 2, shape[0])):
        for j in range(max(cj - 1, 0), min(cj + 2, shape[1])):
            first = (i * shape[1] + j) * shape[2]
            for entry in range(starts[first + k_low], starts[first + k_high]):
                other = order[entry]
                weight = weights[other]
                if other == query or weight == 0.0:
                    continue
                dx, dy, dz = (
                    vertices[other, 0] - px,
                    vertices[other, 1] - py,
                    vertices[other, 2] - pz,
                )
                distance = math.sqrt(dx * dx + dy * dy + dz * dz)
                if distance >= reach or distance == 0.0:
                    continue
                number += 1
                if number % stride != 0:
                    continue
                cosine = normals[other, 0] * z0 + normals[other, 1] * z1 + normals[other, 2] * z2
                along, across = dx * x0 + dy * x1 + dz * x2, dx * y0 + dy * y1 + dz * y2
                height = (dx * z0 + dy * z1 + dz * z2) / distance
                # each coordinate in widths of a bin, counted from the middle of the first
                at_azimuth = _turn(across, along) * AZIMUTHS
                at_height = (min(1.0, max(-1.0, height)) + 1.0) * 0.5 * ELEVATIONS - 0.5
                at_cosine = (min(1.0, max(-1.0, cosine)) + 1.0) * 0.5 * COSINES - 0.5
                a0, h0, c0 = int(at_azimuth), int(at_height + 1.0) - 1, int(at_cosine + 1.0) - 1
                fa, fh, fc = at_azimuth - a0, at_height - h0, at_cosine - c0
                a0, a1 = a0 % AZIMUTHS, (a0 + 1) % AZIMUTHS
                h0, h1 = max(0, h0), min(ELEVATIONS - 1, h0 + 1)
                c0, c1 = max(0, c0), min(COSINES - 1, c0 + 1)
                for k in range(len(radii)):
                    if distance < radii[k]:
                        at_radius = distance / radii[k] * SHELLS - 0.5
                        r0 = int(at_radius + 1.0) - 1
                        fr = at_radius - r0
                        r0, r1 = max(0, r0), min(SHELLS - 1, r0 + 1)
                        for step in range(4):
                            h, share = (h0, 1.0 - fh) if step < 2 else (h1, fh)
                            r, part = (r0, 1.0 - fr) if step % 2 == 0 else (r1, fr)
                            share *= weight * part
                            near, far = share * (1.0 - fa), share * fa
                            base = (h * SHELLS + r) * COSINES
                            histogram[k, a0, base + c0] += near * (1.0 - fc)
                            histogram[k, a0, base + c1] += near * fc
                            histogram[k, a1, base + c0] += far * (1.0 - fc)
                            histogram[k, a1, base + c1] += far * fc


@compiled(inline="always")
def _turn(y, x):
    """Angle of (x, y) in turns from 0 to 1, within 2e-6: a fifth of the time of `atan2`.

    Hastings, *Approximations for digital computers*, 1955, sheet 9.
    """
    wide, narrow = max(abs(x), abs(y)), min(abs(x), abs(y))
    q = narrow / wide if wide > 0.0 else 0.0
    s = q * q
    angle = q * (
        0.9998660 + s * (-0.3302995 + s * (0.1801410 + s * (-0.0851330 + s * 0.0208351)))
    ) / (2.0 * math.pi)  # fmt: skip
    if abs(y) > abs(x):
        angle = 0.25 - angle
    if x < 0.0:
        angle = 0.5 - angle
    if y < 0.0:
        angle = 1.0 - angle
    return angle


@compiled()
def _stride(vertices, query, cells, reach):
    """Of how many neighbors in its ball one votes: 1, unless there are more than MOST_VOTES."""
    order, starts, origin, size, shape = cells
    px, py, pz = vertices[query, 0], vertices[query, 1], vertices[query, 2]
    ci = math.floor((px - origin[0]) / size)
    cj = math.floor((py - origin[1]) / size)
    ck = math.floor((pz - origin[2]) / size)
    k_low, k_high = max(ck - 1, 0), min(ck + 2, shape[2])
    around = 0
    for i in range(max(ci - 1, 0), min(ci + 2, shape[0])):
        for j in range(max(cj - 1, 0), min(cj + 2, shape[1])):
            first = (i * shape[1] + j) * shape[2]
            around += starts[first + k_high] - starts[first + k_low]
    if around <= 3 * MOST_VOTES:  # a ball is a seventh of the cubes around it
        return 1
    inside = 0
    for i in range(max(ci - 1, 0), min(ci + 2, shape[0])):
        for j in range(max(cj - 1, 0), min(cj + 2, shape[1])):
            first = (i * shape[1] + j) * shape[2]
            for entry in range(starts[first + k_low], starts[first + k_high]):
                other = order[entry]
                dx, dy = vertices[other, 0] - px, vertices[other, 1] - py
                dz = vertices[other, 2] - pz
                inside += dx * dx + dy * dy + dz * dz < reach * reach
    return 1 + inside // MOST_VOTES


@compiled()
def _moments(rows, vertices, weights, queries, radius, cells, covariance, mean):
    """Sum the first and second moments of the neighbors of each query."""
    order, starts, origin, size, shape = cells
    for row in range(rows[0], rows[1]):
        query = queries[row]
        total, mass = 0.0, 0.0
        d = np.empty(3)
        low, high = np.empty(3, np.int64), np.empty(3, np.int64)
        for axis in range(3):
            place = math.floor((vertices[query, axis] - origin[axis]) / size)
            low[axis], high[axis] = max(place - 1, 0), min(place + 2, shape[axis])
        for i in range(low[0], high[0]):
            for j in range(low[1], high[1]):
                first = (i * shape[1] + j) * shape[2]
                for entry in range(starts[first + low[2]], starts[first + high[2]]):
                    other = order[entry]
                    for axis in range(3):
                        d[axis] = vertices[other, axis] - vertices[query, axis]
                    distance = math.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
                    if distance >= radius:
                        continue
                    weight = weights[other] * (radius - distance)
                    total += weight
                    mass += weights[other]
                    for u in range(3):
                        mean[row, u] += weights[other] * d[u]
                        for v in range(3):
                            covariance[row, u, v] += weight * d[u] * d[v]
        if total > 0.0:
            mean[row] /= mass
            covariance[row] /= total
