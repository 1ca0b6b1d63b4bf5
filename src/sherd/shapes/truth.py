"""Ground truth of a fragment: where its points lie on the full shape, and what it covers."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from sherd.arrays import Bools, Floats, Ints
from sherd.errors import InputError
from sherd.mesh.geometry import face_areas
from sherd.mesh.surface_points import SurfacePoints, closest_points
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["carried", "true_region"]


# Samples per vertex of the full shape, two for each of its faces.
SAMPLES_PER_VERTEX = 4
# One face of a part never needs more than 64^2 samples: it would span 256 vertices.
MOST_DIVISIONS = 64


def carried(
    full: TriangleMesh, truth: SurfacePoints, corners: Ints, weights: Floats
) -> SurfacePoints:
    """Where points of the part lie on the full shape, from where the part's vertices lie.

    A point is given by three vertices of the part (p, 3) and weights (p, 3). Where these
    vertices lie on one face of the full shape, as after any cut, the answer is exact; elsewhere
    (the part was remeshed) it is the point of the full shape closest to the weighted mean.

    Parameters
    ----------
    full
        The full shape in its own pose.
    truth
        (n_part,) points on `full`.
    corners, weights
        (p, 3) int, rows of `truth`, and (p, 3) float, rows sum to 1.
    """
    vertices = full.faces[truth.faces[corners]].reshape(-1, 9)
    shares = (weights[:, :, None] * truth.barycentric[corners]).reshape(-1, 9)
    support, merged = _merged(np.where(shares > 0, vertices, -1), shares)
    face = _faces_holding(full, support)
    found = face >= 0
    # the weight of corner c is that of the support vertex equal to it
    agree = full.faces[face][:, :, None] == support[:, None, :]
    barycentric = (agree * merged[:, None, :]).sum(axis=2)
    if not found.all():
        positions = np.einsum("pk,pkx->px", weights, truth.positions(full)[corners])[~found]
        closest = closest_points(full, positions)
        face[~found], barycentric[~found] = closest.faces, closest.barycentric
    return SurfacePoints(face, barycentric)


def true_region(
    full: TriangleMesh,
    part: TriangleMesh,
    truth: SurfacePoints,
    *,
    present: ArrayLike | None = None,
) -> Bools:
    """The vertices of the full shape of whose area the part covers at least half, (n_full,).

    A vertex's area is that of its hat function, a third of the faces around it. The part's faces
    are sampled densely, so the region has no holes between the images of the
    part's vertices, however coarse the part is.

    Parameters
    ----------
    full, part
        The full shape and the part.
    truth
        (n_part,) where the vertices of the part lie on `full`.
    present
        (n_part,) bool; faces with a corner that is not present are left out.

    Raises
    ------
    InputError
        If `truth` or `present` does not have one row per vertex of the part.
    """
    there = np.ones(part.vertex_count, dtype=bool) if present is None else np.asarray(present, bool)
    if len(truth) != part.vertex_count or there.shape != (part.vertex_count,):
        raise InputError(
            f"truth has {len(truth)} rows and present shape {there.shape}, "
            f"but the part has {part.vertex_count} vertices"
        )
    faces = part.faces[there[part.faces].all(axis=1)]
    positions = truth.positions(full)
    areas = face_areas(positions, faces)
    mean_area = full.area / full.vertex_count
    divisions = np.sqrt(SAMPLES_PER_VERTEX * areas / mean_area)
    divisions = np.clip(np.ceil(divisions), 1, MOST_DIVISIONS).astype(np.int64)
    covered = np.zeros(full.vertex_count)
    for division in np.unique(divisions):
        rows = np.flatnonzero(divisions == division)
        centers = _subtriangle_centers(int(division))
        corners = np.repeat(faces[rows], len(centers), axis=0)
        points = carried(full, truth, corners, np.tile(centers, (len(rows), 1)))
        share = np.repeat(areas[rows] / len(centers), len(centers))
        # each corner gets its hat function's share, which is exact on faces inside one of the full
        shares = share[:, None] * points.barycentric
        hit = full.faces[points.faces].ravel()
        covered += np.bincount(hit, shares.ravel(), minlength=len(covered))
    return (covered >= 0.5 * full.vertex_areas) & (full.vertex_areas > 0)


def _merged(vertices: Ints, shares: Floats) -> tuple[Ints, Floats]:
    """Per row the distinct vertices, descending, then -1, and the sums of their shares, (p, 9)."""
    order = np.argsort(-vertices, axis=1, kind="stable")
    ranked = np.take_along_axis(vertices, order, axis=1)
    values = np.take_along_axis(shares, order, axis=1)
    new = np.ones(ranked.shape, dtype=bool)
    new[:, 1:] = ranked[:, 1:] != ranked[:, :-1]
    slot = np.cumsum(new, axis=1) - 1
    rows = np.broadcast_to(np.arange(len(ranked))[:, None], ranked.shape)
    distinct = np.full(ranked.shape, -1, dtype=np.int64)
    distinct[rows, slot] = ranked
    total = np.zeros(values.shape)
    np.add.at(total, (rows, slot), np.where(ranked >= 0, values, 0.0))
    return distinct, total


def _faces_holding(full: TriangleMesh, support: Ints) -> Ints:
    """A face with all the vertices of each row (one to three of them, then -1), or -1, (p,)."""
    count = full.vertex_count
    size = (support >= 0).sum(axis=1)
    face = np.full(len(support), -1, dtype=np.int64)
    corners = -np.sort(-full.faces, axis=1)
    number = np.arange(full.face_count)
    for members in (1, 2, 3):
        rows = np.flatnonzero(size == members)
        if len(rows) == 0:
            continue
        # every choice of that many corners of every face, the vertices of a row being descending
        choices = {1: [[0], [1], [2]], 2: [[0, 1], [0, 2], [1, 2]], 3: [[0, 1, 2]]}[members]
        table = np.concatenate([corners[:, choice] for choice in choices])
        owner = np.tile(number, len(choices))
        both = np.concatenate([table, support[rows, :members]])
        key = both[:, 0]
        for column in range(1, members):
            # numbered anew each time, so that keys stay below n^2 and never overflow
            _, key = np.unique(key, return_inverse=True)
            key = key * count + both[:, column]
        known, wanted = key[: len(table)], key[len(table) :]
        order = np.argsort(known, kind="stable")
        place = np.minimum(np.searchsorted(known[order], wanted), len(known) - 1)
        hit = known[order][place] == wanted
        face[rows[hit]] = owner[order[place[hit]]]
    return face


def _subtriangle_centers(division: int) -> Floats:
    """Barycentric weights of the centers of the `division`^2 equal parts of a triangle."""
    i, j = np.meshgrid(np.arange(division), np.arange(division), indexing="ij")
    upright, hanging = i + j < division, i + j < division - 1
    u = np.concatenate([(i[upright] + 1 / 3), (i[hanging] + 2 / 3)]) / division
    v = np.concatenate([(j[upright] + 1 / 3), (j[hanging] + 2 / 3)]) / division
    return np.stack([1 - u - v, u, v], axis=1)
