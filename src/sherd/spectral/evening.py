"""Better triangles on the same surface: flip edges to Delaunay, move vertices between neighbors."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.mesh import topology
from sherd.mesh.geometry import face_cross, face_normals, vertex_normals
from sherd.spectral.operators import corner_cotangents

__all__ = ["evened", "flipped_to_delaunay"]


# Cosine of the sharpest bend (45 degrees) across which an edge may be flipped: over a sharper one
# the other diagonal would leave the surface.
SHARPEST_BEND = 0.7
# The sweeps end when they flip hardly any edge, at the latest after a dozen.
FEW_FLIPS = 1e-3
MAX_SWEEPS = 12


def evened(vertices: Floats, faces: Ints, *, steps: int) -> Floats:
    """Inner vertices moved toward the middle of their neighbors, within the tangent plane.

    Vertices at a border or at an edge with more than two faces stay, and so do the corners of
    a face that would turn over.

    Parameters
    ----------
    vertices, faces
        (n, 3) float, l, and (m, 3) int.
    steps
        Number of half steps; the surface drifts off by a second-order amount at each.
    """
    neighbors = topology.adjacency(faces, len(vertices))
    degree = np.maximum(neighbors.sum(axis=1), 1.0)[:, None]
    edges, uses = topology.unique_edges(faces)
    fixed = np.unique(edges[uses != 2])
    for _ in range(steps):
        normals = vertex_normals(vertices, faces)
        move = 0.5 * (neighbors @ vertices / degree - vertices)
        move -= np.einsum("nc,nc->n", move, normals)[:, None] * normals
        move[fixed] = 0.0
        moved = vertices + move
        # outward at the corners; a face that is turned over already is free to turn back
        outward = normals[faces].sum(axis=1)
        before = np.einsum("mc,mc->m", face_cross(vertices, faces), outward) > 0
        after = np.einsum("mc,mc->m", face_cross(moved, faces), outward) > 0
        turned = faces[before & ~after]
        moved[turned] = vertices[turned]
        vertices = moved
    return vertices


def flipped_to_delaunay(vertices: Floats, faces: Ints) -> Ints:
    """The faces (m, 3) after flipping edges whose opposite angles sum to more than 180 degrees.

    Borders, non-manifold edges and sharp bends stay. Each sweep flips edges that share no face,
    the worst first.
    """
    faces = faces.copy()
    for _ in range(MAX_SWEEPS):
        pairs = _flippable(vertices, faces)
        if len(pairs[0][0]) <= FEW_FLIPS * len(faces):
            break
        (left, left_corner), (right, right_corner) = pairs
        near, far = faces[left, left_corner], faces[right, right_corner]
        start, end = faces[left, (left_corner + 1) % 3], faces[left, (left_corner + 2) % 3]
        faces[left] = np.stack([near, start, far], axis=1)
        faces[right] = np.stack([near, far, end], axis=1)
    return faces


def _flippable(vertices: Floats, faces: Ints) -> tuple[tuple[Ints, Ints], tuple[Ints, Ints]]:
    """Faces left and right of the edges to flip, each with its corner opposite the edge."""
    count = len(vertices)
    # half edge 3 f + c is the one opposite corner c of face f
    sides = np.sort(faces[:, [1, 2, 2, 0, 0, 1]].reshape(-1, 2), axis=1)
    keys = sides[:, 0] * count + sides[:, 1]
    order = np.argsort(keys, kind="stable")
    ranked = keys[order]
    first = np.flatnonzero(np.r_[True, ranked[1:] != ranked[:-1]])
    uses = np.diff(np.r_[first, len(ranked)])
    one, two = order[first[uses == 2]], order[first[uses == 2] + 1]
    cotangents = corner_cotangents(vertices, faces).ravel()
    excess = cotangents[one] + cotangents[two]
    normals = face_normals(vertices, faces)
    smooth = np.einsum("ec,ec->e", normals[one // 3], normals[two // 3]) > SHARPEST_BEND
    # both faces must run along the edge in opposite directions, or the pair is not oriented
    opposed = faces.ravel()[_next(one)] == faces.ravel()[_next(_next(two))]
    wanted = (excess < -1e-9) & smooth & opposed
    one, two, excess = one[wanted], two[wanted], excess[wanted]
    corners = np.sort(np.stack([faces.ravel()[one], faces.ravel()[two]], axis=1), axis=1)
    diagonal = corners[:, 0] * count + corners[:, 1]
    new = ~np.isin(diagonal, ranked[first]) & (corners[:, 0] != corners[:, 1])
    one, two, excess, diagonal = one[new], two[new], excess[new], diagonal[new]
    worst_first = np.argsort(excess, kind="stable")
    one, two, diagonal = one[worst_first], two[worst_first], diagonal[worst_first]
    place = np.arange(len(one))
    best = np.full(len(faces), len(one), dtype=np.int64)
    np.minimum.at(best, one // 3, place)
    np.minimum.at(best, two // 3, place)
    _, leading = np.unique(diagonal, return_index=True)
    chosen = (best[one // 3] == place) & (best[two // 3] == place)
    chosen &= np.isin(place, leading)
    one, two = one[chosen], two[chosen]
    return (one // 3, one % 3), (two // 3, two % 3)


def _next(half_edges: Ints) -> Ints:
    """The following corner of the same face, as 3 f + c."""
    following: Ints = half_edges - half_edges % 3 + (half_edges + 1) % 3
    return following
