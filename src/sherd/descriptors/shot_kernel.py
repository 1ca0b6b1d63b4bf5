"""The compiled inner loop of SHOT: histograms of normals around points, in given frames."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

__all__ = ["AZIMUTH_BINS", "COSINE_BINS", "neighborhood_covariances", "shot_histograms"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# The grid of Tombari et al. 2010: 8 azimuth x 2 elevation x 2 radial sectors, 11 cosine bins.
AZIMUTH_BINS = 8
COSINE_BINS = 11


def shot_histograms(
    positions: Floats,
    normals: Floats,
    weights: Floats,
    *,
    centers: Floats,
    x_axes: Floats,
    z_axes: Floats,
    radius: float,
) -> NDArray[np.float32]:
    """Weighted histograms of normals in the spherical sectors around each center.

    A sample adds its weight to the sectors by its place in the frame of the center, and inside
    a sector to the bin of the cosine between its normal and the z axis; all four coordinates
    are interpolated linearly, so that the histogram is a continuous function of the shape.

    Parameters
    ----------
    positions, normals
        (n, 3) sample points (l) and their unit normals.
    weights
        (n,) area that each sample stands for, l^2.
    centers
        (q, 3) l.
    x_axes, z_axes
        (q, 3) unit and orthogonal; y = z cross x.
    radius
        Radius of the ball, l.

    Returns
    -------
    (q, 8, 44) float32
        Azimuth sector, then elevation, radius and cosine; each (8, 44) block has norm 1, or is
        zero where the ball holds no weight.

    References
    ----------
    Tombari, Salti, Di Stefano, *Unique signatures of histograms for local surface
    description*, 2010, section 3. Deviation: samples weigh their area, not 1, so that the
    meshing does not matter.
    """
    order, starts, origin, shape = _grid(positions, radius)
    return _histograms(
        positions[order], normals[order], weights[order], starts, origin, shape,
        centers, x_axes, z_axes, radius,
    )  # fmt: skip


def neighborhood_covariances(
    positions: Floats, weights: Floats, *, centers: Floats, radius: float
) -> tuple[Floats, Floats]:
    """Moments of the samples about each center, weight falling linearly to 0 at `radius`.

    Returns
    -------
    covariance
        (q, 3, 3), l^2: `sum w (radius - d) x x' / sum w (radius - d)`; zero for an empty ball.
    mean
        (q, 3), l: mean offset of the samples, by weight alone.
    """
    order, starts, origin, shape = _grid(positions, radius)
    return _covariances(positions[order], weights[order], starts, origin, shape, centers, radius)


def _grid(positions: Floats, cell: float) -> tuple[Ints, Ints, Floats, Ints]:
    """Sort points by cubic cell: (order, start of each cell in the order, origin, cell counts)."""
    origin = positions.min(axis=0)
    extent = positions.max(axis=0) - origin
    # cells may be larger than asked, so that a tiny radius cannot ask for more cells than memory
    size = max(cell, float(extent.max()) / 200.0)
    shape = np.floor(extent / size).astype(np.int64) + 1
    index = np.minimum(((positions - origin) / size).astype(np.int64), shape - 1)
    flat = (index[:, 0] * shape[1] + index[:, 1]) * shape[2] + index[:, 2]
    order = np.argsort(flat, kind="stable")
    starts = np.searchsorted(flat[order], np.arange(shape.prod() + 1))
    return order, starts, np.append(origin, size), shape


@numba.njit(cache=True)
def _cell_range(value, low, size, radius, count):  # type: ignore[no-untyped-def]  # pragma: no cover
    first = int(np.floor((value - radius - low) / size))
    last = int(np.floor((value + radius - low) / size))
    return max(first, 0), min(last, count - 1)


@numba.njit(cache=True, parallel=True)
def _histograms(  # type: ignore[no-untyped-def]  # pragma: no cover  # noqa: PLR0913
    positions, normals, weights, starts, origin, shape, centers, x_axes, z_axes, radius
):
    count = len(centers)
    out = np.zeros((count, AZIMUTH_BINS, 4 * COSINE_BINS), dtype=np.float32)
    size = origin[3]
    for q in numba.prange(count):
        block = np.zeros((AZIMUTH_BINS, 4 * COSINE_BINS))
        p = centers[q]
        x = x_axes[q]
        z = z_axes[q]
        y0 = z[1] * x[2] - z[2] * x[1]
        y1 = z[2] * x[0] - z[0] * x[2]
        y2 = z[0] * x[1] - z[1] * x[0]
        i0, i1 = _cell_range(p[0], origin[0], size, radius, shape[0])
        j0, j1 = _cell_range(p[1], origin[1], size, radius, shape[1])
        k0, k1 = _cell_range(p[2], origin[2], size, radius, shape[2])
        for i in range(i0, i1 + 1):
            for j in range(j0, j1 + 1):
                row = (i * shape[1] + j) * shape[2]
                for s in range(starts[row + k0], starts[row + k1 + 1]):
                    w = weights[s]
                    if w <= 0.0:
                        continue
                    dx = positions[s, 0] - p[0]
                    dy = positions[s, 1] - p[1]
                    dz = positions[s, 2] - p[2]
                    distance = np.sqrt(dx * dx + dy * dy + dz * dz)
                    if distance > radius or distance < 1e-9 * radius:
                        continue
                    a = dx * x[0] + dy * x[1] + dz * x[2]
                    b = dx * y0 + dy * y1 + dz * y2
                    c = dx * z[0] + dy * z[1] + dz * z[2]
                    cosine = normals[s, 0] * z[0] + normals[s, 1] * z[1] + normals[s, 2] * z[2]
                    cosine = min(1.0, max(-1.0, cosine))
                    # continuous bin coordinates; a sector's center lies at whole numbers
                    f_cosine = (cosine + 1.0) / 2.0 * COSINE_BINS - 0.5
                    f_azimuth = (np.arctan2(b, a) / (2.0 * np.pi) + 1.0) % 1.0 * AZIMUTH_BINS
                    f_height = (min(1.0, max(-1.0, c / distance)) + 1.0) - 0.5
                    f_radial = distance / radius * 2.0 - 0.5
                    n_cosine = int(np.floor(f_cosine))
                    n_azimuth = int(np.floor(f_azimuth))
                    n_height = int(np.floor(f_height))
                    n_radial = int(np.floor(f_radial))
                    for u in range(2):
                        azimuth = (n_azimuth + u) % AZIMUTH_BINS
                        r_azimuth = f_azimuth - n_azimuth
                        w_azimuth = w * (r_azimuth if u == 1 else 1.0 - r_azimuth)
                        for v in range(2):
                            height = min(1, max(0, n_height + v))
                            r_height = f_height - n_height
                            w_height = w_azimuth * (r_height if v == 1 else 1.0 - r_height)
                            for t in range(2):
                                radial = min(1, max(0, n_radial + t))
                                r_radial = f_radial - n_radial
                                w_radial = w_height * (r_radial if t == 1 else 1.0 - r_radial)
                                base = (height * 2 + radial) * COSINE_BINS
                                r_cosine = f_cosine - n_cosine
                                low = max(0, n_cosine)
                                high = min(COSINE_BINS - 1, n_cosine + 1)
                                block[azimuth, base + low] += w_radial * (1.0 - r_cosine)
                                block[azimuth, base + high] += w_radial * r_cosine
        norm = np.sqrt((block * block).sum())
        if norm > 0.0:
            for u in range(AZIMUTH_BINS):
                for v in range(4 * COSINE_BINS):
                    out[q, u, v] = block[u, v] / norm
    return out


@numba.njit(cache=True, parallel=True)
def _covariances(positions, weights, starts, origin, shape, centers, radius):  # type: ignore[no-untyped-def]  # pragma: no cover  # noqa: PLR0913
    count = len(centers)
    covariance = np.zeros((count, 3, 3))
    mean = np.zeros((count, 3))
    size = origin[3]
    for q in numba.prange(count):
        p = centers[q]
        total = 0.0
        mass = 0.0
        d = np.empty(3)
        i0, i1 = _cell_range(p[0], origin[0], size, radius, shape[0])
        j0, j1 = _cell_range(p[1], origin[1], size, radius, shape[1])
        k0, k1 = _cell_range(p[2], origin[2], size, radius, shape[2])
        for i in range(i0, i1 + 1):
            for j in range(j0, j1 + 1):
                row = (i * shape[1] + j) * shape[2]
                for s in range(starts[row + k0], starts[row + k1 + 1]):
                    for axis in range(3):
                        d[axis] = positions[s, axis] - p[axis]
                    distance = np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
                    if distance > radius:
                        continue
                    w = weights[s] * (radius - distance)
                    total += w
                    mass += weights[s]
                    for u in range(3):
                        mean[q, u] += weights[s] * d[u]
                        for v in range(3):
                            covariance[q, u, v] += w * d[u] * d[v]
        if total > 0.0:
            for u in range(3):
                mean[q, u] /= mass
                for v in range(3):
                    covariance[q, u, v] /= total
    return covariance, mean
