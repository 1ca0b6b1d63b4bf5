"""Which side of a rough surface is outside, patch by patch, and faces that agree on it.

A surface grown over points may turn over on the way: one sharp triangle through a thin limb joins
the outside of one wall to the inside of the other.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull

from sherd.arrays import Floats, Ints
from sherd.mesh import gluing
from sherd.mesh.geometry import face_cross
from sherd.mesh.minimum_cut import minimum_cut

__all__ = ["seen_from_outside", "turned_outward"]


# Directions all around, 30 degrees apart, and points enough to tell limbs apart.
VIEWS = 40
MOST_POINTS = 5000
# Eyes stand three radii from the middle. The points are flipped over a sphere of twice the distance
# of the farthest. The smaller it is, the more points count as hidden; with a hundred, eyes look
# through coarse surfaces, and the inside of legs is seen.
DISTANCE = 3.0
SPHERE = 2.0
# The mean cosine at which the points of a ball are seen, 0 from where they are hidden.
OPEN = 0.15
# A cut along an edge between two faces in a plane costs as much as so many faces that are seen by
# all. Bowls are seen from inside, so patches should not turn for little. From 6 to 15, halves of
# animals have the fewest faces turned wrongly: 0.6 % of the area, and 1.4 % with 1.
SEAM = 8.0
# Nothing is divided by less.
TINY = 1e-300


def seen_from_outside(points: Floats, normals: Floats) -> Floats:
    """How far points are seen from in front, less how far from behind: about 1 to -1, 0 if hidden.

    Parameters
    ----------
    points
        (n, 3).
    normals
        (n, 3), zero where unknown.

    References
    ----------
    Katz, Tal, Basri, *Direct visibility of point sets*, 2007: points are visible if they are on the
    convex hull after flipping them over a sphere around the eye.
    """
    chosen = np.arange(len(points))
    if len(points) > MOST_POINTS:
        chosen = np.sort(np.random.default_rng(0).permutation(len(points))[:MOST_POINTS])
    places = points[chosen] - points[chosen].mean(axis=0)
    reach = np.linalg.norm(places, axis=1).max()
    seen = np.zeros(len(points))
    for direction in _directions(VIEWS):
        ray = places - DISTANCE * reach * direction
        length = np.linalg.norm(ray, axis=1)[:, None]
        ray = ray / length
        flipped = (2.0 * SPHERE * length.max() - length) * ray
        # joggled, as points in a plane with the eye have no hull
        hull = ConvexHull(np.concatenate([flipped, np.zeros((1, 3))]), qhull_options="QJ").vertices
        visible = hull[hull < len(places)]
        seen[chosen[visible]] -= np.einsum("ij,ij->i", normals[chosen[visible]], ray[visible])
    return seen / (OPEN * VIEWS)


def turned_outward(points: Floats, faces: Ints, outside: Floats) -> Ints:
    """The faces, patches that look inward turned over; some at the seams are left out.

    What is seen decides, weighed against cutting: a seam costs its length, less where the surface
    bends. The best choice for all faces is a minimum cut.

    Parameters
    ----------
    points, faces
        (n, 3) and (m, 3), neighbors agreeing on their side.
    outside
        (n,) about 1 to -1, as of :func:`seen_from_outside`.
    """
    cross = face_cross(points, faces)
    double = np.linalg.norm(cross, axis=1)
    side = outside[faces].mean(axis=1) * double
    pairs = gluing.face_pairs(points, faces)
    one, two = pairs.T // 3
    start, end = faces.ravel()[pairs[:, 0]], faces.ravel()[gluing.end_corners(pairs[:, 0])]
    size = np.maximum(double[one] * double[two], TINY)
    bend = np.einsum("ij,ij->i", cross[one], cross[two]) / size
    seam = np.linalg.norm(points[start] - points[end], axis=1) * np.maximum(bend, 0.0) ** 2
    seam *= SEAM * np.sqrt(double.mean())
    # those with negative `side` are turned over, unless the seams around cost more
    turned = minimum_cut(side, (one, two), seam)
    facing = np.where(turned[:, None], faces[:, ::-1], faces)
    torn = turned[one] != turned[two]
    unsure = np.where(np.abs(side[one]) < np.abs(side[two]), one, two)[torn]
    kept: Ints = np.delete(facing, unsure, axis=0)
    return kept


def _directions(count: int) -> Floats:
    """Unit vectors spread evenly: a spiral over the sphere."""
    place = np.arange(count) + 0.5
    height, around = 1.0 - 2.0 * place / count, np.pi * (1.0 + np.sqrt(5.0)) * place
    width = np.sqrt(1.0 - height**2)
    return np.stack([width * np.cos(around), width * np.sin(around), height], axis=1)
