"""Facets of the Delaunay tetrahedra of points: a surface through the points consists of some."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import Delaunay

from sherd.arrays import Floats, Ints
from sherd.mesh.geometry import edge_lengths, face_areas, face_normals

__all__ = ["Facets", "delaunay_facets"]


# Grids have many points on one sphere, for which Qhull's triangles do not fit together. Points
# moved by this share of their distance have none; it is far above rounding and far below noise.
JOGGLE = 1e-7
# Of a triangle's area to its longest side squared. Three points in a row make no surface.
SLIVER = 1e-4
# Below the smallest positive numbers that matter, so that nothing is divided by zero.
TINY = 1e-300
# Corners of a tetrahedron without one.
TRIPLES = ((1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2))


class Facets(NamedTuple):
    """Triangles and the radii of the smallest balls through their corners without a point inside.

    `corners` (m, 3), ascending; `radius` (m,) l.
    """

    corners: Ints
    radius: Floats


def delaunay_facets(points: Floats, reach: Floats, longest: float) -> Facets:
    """Facets of the Delaunay tetrahedra whose sides are at most `longest` times their reach.

    Parameters
    ----------
    points
        (n, 3), distinct and not on a line.
    reach
        (n,) local spacing at each point; the largest of its corners counts for a triangle.
    longest
        In units of the reach.

    References
    ----------
    Cohen-Steiner, Da, *A greedy Delaunay-based surface reconstruction algorithm*, 2004: the centers
    of the empty balls through a triangle form its dual Voronoi edge.
    """
    moved = points + _joggle(points)
    tetrahedra = Delaunay(moved).simplices.astype(np.int64)
    centers = _ball_centers(moved, tetrahedra)
    found = np.sort(np.concatenate([tetrahedra[:, triple] for triple in TRIPLES]), axis=1)
    owner = np.tile(np.arange(len(tetrahedra)), 4)
    apex = tetrahedra.T.ravel()
    relative = edge_lengths(points, found).max(axis=1) / reach[found].max(axis=1)
    near = np.flatnonzero(relative <= longest)
    order = near[np.lexsort(found[near].T[::-1])]
    found, owner, apex = found[order], owner[order], apex[order]
    new = np.ones(len(found), dtype=bool)
    new[1:] = (found[1:] != found[:-1]).any(axis=1)
    start = np.flatnonzero(new)
    twin = np.minimum(start + 1, len(found) - 1)
    inner = ~new[twin]  # the other facets are on the hull of all points
    corners = found[start]
    flat = face_areas(points, corners) < SLIVER * edge_lengths(points, corners).max(axis=1) ** 2
    start, twin, inner, corners = start[~flat], twin[~flat], inner[~flat], corners[~flat]
    center, radius = _circles(moved, corners)
    normal = face_normals(moved, corners)
    one = _height(centers[owner[start]], center, normal)
    two = _height(centers[owner[twin]], center, normal)
    beyond = -np.sign(_height(moved[apex[start]], moved[corners[:, 0]], normal))
    two = np.where(inner, two, beyond * np.inf)
    # the dual edge passes through the triangle's own circle, or ends on one side of it
    low = np.where(np.sign(one) * np.sign(two) <= 0, 0.0, np.minimum(np.abs(one), np.abs(two)))
    return Facets(corners, np.hypot(radius, low))


def _joggle(points: Floats) -> Floats:
    spacing = np.ptp(points, axis=0).max() / np.sqrt(len(points))
    move = np.random.default_rng(0).uniform(-1.0, 1.0, points.shape)
    joggle: Floats = JOGGLE * spacing * move
    return joggle


def _ball_centers(points: Floats, tetrahedra: Ints) -> Floats:
    """Centers (t, 3) of the balls through four points."""
    origin = points[tetrahedra[:, 0]]
    a, b, c = (points[tetrahedra[:, k]] - origin for k in (1, 2, 3))
    bc, ca, ab = np.cross(b, c), np.cross(c, a), np.cross(a, b)
    volume = _dot(a, bc)
    volume = np.where(np.abs(volume) < TINY, TINY, volume)
    sum_: Floats = _dot(a, a)[:, None] * bc + _dot(b, b)[:, None] * ca + _dot(c, c)[:, None] * ab
    return origin + sum_ / (2.0 * volume)[:, None]


def _circles(points: Floats, corners: Ints) -> tuple[Floats, Floats]:
    """Center (m, 3) and radius (m,) of the circles through three points."""
    origin = points[corners[:, 0]]
    a, b = points[corners[:, 1]] - origin, points[corners[:, 2]] - origin
    normal = np.cross(a, b)
    square = np.maximum(_dot(normal, normal), TINY)[:, None]
    arm = _dot(b, b)[:, None] * np.cross(normal, a) + _dot(a, a)[:, None] * np.cross(b, normal)
    arm = arm / (2.0 * square)
    return origin + arm, np.sqrt(_dot(arm, arm))


def _height(places: Floats, origin: Floats, normal: Floats) -> Floats:
    return _dot(places - origin, normal)


def _dot(a: Floats, b: Floats) -> Floats:
    product: Floats = np.einsum("ij,ij->i", a, b)
    return product
