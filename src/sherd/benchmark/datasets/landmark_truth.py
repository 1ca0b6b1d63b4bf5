"""A map between two meshes from landmarks that are rounded to vertices on both."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from sherd.arrays import Ints
from sherd.errors import InputError
from sherd.mesh.surface_points import SurfacePoints, closest_points
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["landmark_map"]


# Vertices with landmarks that a similarity is fitted to: three are needed, twice as many are never
# all on a line.
FEWEST = 6
# Steps over edges in which the landmarks around a vertex are gathered. Two steps reach 19 vertices:
# enough to average the rounding away, and few enough for bodies to bend and stretch beyond.
STEPS = 2
# Where landmarks are sparse, more steps are taken, up to this many.
MOST_STEPS = 8


def landmark_map(
    source: TriangleMesh, target: TriangleMesh, landmarks: tuple[Ints, Ints], *, mirrored: bool
) -> SurfacePoints:
    """Where each vertex of `source` lies on `target`, (n,) surface points.

    Landmarks are rounded to the nearest vertex on both meshes, half an edge on each. For every
    vertex the similarity (rotation, scale, shift) is fitted that carries the landmarks around it
    to their places on `target`; the answer is the point of `target` closest to the vertex carried
    so. Averaging over some twenty landmarks leaves about a quarter of the rounding.

    Parameters
    ----------
    source, target
        Two meshes of similar shapes.
    landmarks
        (k,) vertices of `source` and (k,) vertices of `target` that correspond. Several landmarks
        may share a vertex.
    mirrored
        Whether they correspond by a left/right mirror map: then the similarity turns over.

    Raises
    ------
    InputError
        If the two lists differ in length, or a vertex has fewer than six vertices with landmarks
        within eight edges.

    References
    ----------
    Umeyama, *Least-squares estimation of transformation parameters between two point patterns*,
    1991, equations 40 to 42, weighted, for all vertices at once.
    """
    if len(landmarks[0]) != len(landmarks[1]):
        raise InputError(
            f"{source.name} has {len(landmarks[0])} landmarks, {target.name} {len(landmarks[1])}"
        )
    weights = _weights(source, landmarks[0])
    start, end = source.vertices[landmarks[0]], target.vertices[landmarks[1]]
    # about the mean of all, so that differences of moments lose no digits
    origin, goal = start.mean(axis=0), end.mean(axis=0)
    start, end = start - origin, end - goal
    from_mean, to_mean = weights @ start, weights @ end
    products = (end[:, :, None] * start[:, None, :]).reshape(-1, 9)
    covariance = (weights @ products).reshape(-1, 3, 3)
    covariance -= to_mean[:, :, None] * from_mean[:, None, :]
    variance = weights @ (start**2).sum(axis=1) - (from_mean**2).sum(axis=1)
    left, stretch, right = np.linalg.svd(covariance)
    sign = np.sign(np.linalg.det(left) * np.linalg.det(right)) * (-1.0 if mirrored else 1.0)
    stretch[:, 2] *= sign
    left[:, :, 2] *= sign[:, None]
    scale = stretch.sum(axis=1) / variance
    offset = source.vertices - origin - from_mean
    carried = np.einsum("n,nij,njk,nk->ni", scale, left, right, offset, optimize=True)
    return closest_points(target, carried + to_mean + goal)


def _weights(source: TriangleMesh, vertices: Ints) -> sparse.csr_array:
    """Weight of each landmark around each vertex, (n, k); rows sum to 1."""
    count = source.vertex_count
    first, second = source.edges.T
    ends = (np.concatenate([first, second]), np.concatenate([second, first]))
    ones = np.ones(2 * len(source.edges))
    edge = sparse.csr_array((ones, ends), shape=(count, count))
    step = sparse.csr_array(sparse.eye_array(count) + edge)
    marked = (np.bincount(vertices, minlength=count) > 0).astype(np.float64)
    ways = step  # the number of walks of so many steps, each along an edge or on the spot
    chosen = sparse.csr_array((count, count))
    waiting = np.ones(count, dtype=bool)
    for _ in range(STEPS, MOST_STEPS + 1):
        ways = sparse.csr_array(ways @ step)
        enough = waiting & ((ways > 0) @ marked >= FEWEST)
        chosen = chosen + sparse.diags_array(enough.astype(np.float64)) @ ways
        waiting &= ~enough
        if not waiting.any():
            break
    else:
        raise InputError(
            f"vertex {int(waiting.argmax())} of {source.name} has fewer than {FEWEST} landmarks "
            f"within {MOST_STEPS} edges"
        )
    ones = np.ones(len(vertices))
    at = sparse.csr_array((ones, (vertices, np.arange(len(vertices)))), (count, len(vertices)))
    weights = sparse.csr_array(chosen @ at)
    return sparse.csr_array(sparse.diags_array(1.0 / weights.sum(axis=1)) @ weights)
