"""How noisy the points of a scan are, and the same points with less noise."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from sherd.arrays import Floats, Ints
from sherd.mesh import gluing
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["noise_of_points", "smoothed_points"]


# A quadric has 6 coefficients; of two rings of neighbors (18 points) this many are almost always on
# one sheet, and leave 10 to tell noise by.
NEIGHBORS = 16
COEFFICIENTS = 6
# Fewer tell next to nothing beyond the quadric itself.
FEWEST = 9
# Where the surface is flattest against its sampling, residuals are noise alone: that is the tenth
# of the points with the least. Of deviations estimated from 10 residuals each, a tenth is below
# 0.70 of the true one (square root of the chi-squared quantile over 10).
CALMEST = 0.1
CALMEST_SHARE = 0.70
# In neighborhoods of 6 deviations the surface is seen through the noise; opposite sides of limbs
# stay apart if those are thicker. Nearer points count more, as a Gaussian of half of it.
RADIUS = 6.0
SHARPNESS = 2.0
# In a dense cloud more points fall in that radius than are needed for a tenth of the noise.
MOST_NEIGHBORS = 64
# Once with neighbors as noisy as the point itself, once with calmer ones; a third changes nothing.
ROUNDS = 2
# Errors beyond three deviations are rare; a longer way is a step to another sheet.
LONGEST_WAY = 3.0
# Bends up to 60 degrees count as smooth. Noise makes sharper ones, but rarely all around a face.
COS_SMOOTH = 0.5
# Regularizes quadrics of neighbors in a row, relative to their number.
RIDGE = 1e-9


def noise_of_points(points: Floats, surface: TriangleMesh) -> float:
    """Standard deviation of independent noise across the surface, in the points' unit.

    It is told from the residuals of quadrics through 16 neighbors. Thin limbs and creases have
    large ones on a clean surface too, so the calmest tenth of the points speaks for all.

    Parameters
    ----------
    points
        (n, 3).
    surface
        Triangles over them, or over smoother ones, as rough as they may be: they tell the other
        side of a thin sheet from noise. It looks the other way, or is another piece.
    """
    if len(points) <= NEIGHBORS:
        return 0.0
    tree: Any = cKDTree(points)
    near = tree.query(points, k=NEIGHBORS)[1]
    piece, normals = _pieces(surface), surface.vertex_normals
    side = np.einsum("ni,nki->nk", normals, normals[near])
    weight = ((piece[near] == piece[:, None]) & (side >= 0)).astype(np.float64)
    _, _, residual = _quadrics(points, near, weight)
    count = weight.sum(axis=1)
    told = count >= FEWEST
    if not told.any():
        return 0.0
    square = (weight * residual**2).sum(axis=1)[told] / (count[told] - COEFFICIENTS)
    return float(np.sqrt(np.quantile(square, CALMEST)) / CALMEST_SHARE)


def _pieces(surface: TriangleMesh) -> Ints:
    """Which smooth piece each vertex belongs to: single sharp faces may join two sheets."""
    pairs = gluing.face_pairs(surface.vertices, surface.faces) // 3
    one, two = surface.face_normals[pairs.T]
    pairs = pairs[np.einsum("ij,ij->i", one, two) > COS_SMOOTH]
    piece = np.full(surface.vertex_count, -1, dtype=np.int64)
    labels = gluing.components(pairs[:, 0], pairs[:, 1], surface.face_count)
    piece[surface.faces] = labels[:, None]
    return piece


def smoothed_points(points: Floats, noise: float) -> Floats:
    """The points moved onto quadrics through their neighbors, along the normal.

    Parameters
    ----------
    points
        (n, 3), more than 16.
    noise
        Standard deviation, as of :func:`noise_of_points`.

    References
    ----------
    Levin, *Mesh-independent surface interpolation*, 2003: moving least squares.
    """
    for _ in range(ROUNDS):
        tree: Any = cKDTree(points)
        distance, near = tree.query(points, k=min(MOST_NEIGHBORS, len(points)))
        radius = np.maximum(RADIUS * noise, distance[:, NEIGHBORS - 1])[:, None]
        inside = distance <= radius
        used = inside.sum(axis=1).max()  # in sparse clouds far fewer than could be
        distance, near, inside = distance[:, :used], near[:, :used], inside[:, :used]
        weight = inside * np.exp(-SHARPNESS * (distance / radius) ** 2)
        height, normal, _ = _quadrics(points, near, weight)
        most = LONGEST_WAY * noise
        points = points + np.clip(height, -most, most)[:, None] * normal
    return points


def _quadrics(points: Floats, near: Ints, weight: Floats) -> tuple[Floats, Floats, Floats]:
    """Fit a height over the plane of each point's neighbors, with weights (n, k).

    Returns
    -------
    height : (n,) of the quadric above the point
    normal : (n, 3)
    residual : (n, k) of the neighbors
    """
    places = points[near]
    total = weight.sum(axis=1)[:, None]
    middle = (places * weight[:, :, None]).sum(axis=1) / np.maximum(total, RIDGE)
    offset = places - middle[:, None]
    spread = np.einsum("nki,nkj,nk->nij", offset, offset, weight)
    axes = np.linalg.eigh(spread)[1]
    x, y, z = np.einsum("nki,nij->jnk", places - points[:, None], axes[:, :, ::-1])
    scale = np.sqrt((x**2 + y**2).max(axis=1))[:, None]
    scale = np.where(scale > 0, scale, 1.0)
    x, y = x / scale, y / scale
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=2)
    normal_matrix = np.einsum("nki,nkj,nk->nij", terms, terms, weight)
    normal_matrix += RIDGE * (1.0 + total[:, :, None]) * np.eye(COEFFICIENTS)
    right = np.einsum("nki,nk,nk->ni", terms, z, weight)
    solution = np.linalg.solve(normal_matrix, right[:, :, None])[:, :, 0]
    residual: Floats = z - np.einsum("nki,ni->nk", terms, solution)
    return solution[:, 0], axes[:, :, 0], residual
