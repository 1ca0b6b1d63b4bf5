"""A triangle mesh over the points of a scan."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from sherd.arrays import Floats, Ints
from sherd.errors import InvalidMeshError
from sherd.mesh import gluing
from sherd.mesh.geometry import edge_lengths, face_normals, vertex_normals
from sherd.mesh.point_cloud import PointCloud
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.scan.cloud_noise import noise_of_points, smoothed_points
from sherd.scan.delaunay_facets import Facets, delaunay_facets
from sherd.scan.front_kernel import Triangles, grown
from sherd.scan.outward import seen_from_outside, turned_outward

__all__ = ["surface_from_points"]


# Of the triangles of real meshes, coarse and uneven ones too, 99 % have no side longer than 2.5
# times the distance to the sixth neighbor, at the corner where that is largest. Beyond is a hole.
LONGEST_SIDE = 2.5
SIXTH = 6
# A stray point is far from all others: next to a surface ten times as dense, the spacing is three
# times as large, but most of the neighbors are then of the dense side.
LARGEST_STEP = 2.0
# Of half a dozen stray points in a clump the sixth neighbor is far away, the third is not; around a
# point of a surface the sixth is hardly ever three times as far.
THIRD, CLUMP = 3, 3.0
# Stray points far apart form triangles too, with random bends. Where the sampling has a tenth of
# the density of its surroundings real triangles are as large, but there the surface is smooth.
COARSE = 3.0
AROUND = 64
# Noise below a tenth of the spacing leaves the triangulation as it is; clean coarse surfaces bend
# so much that they seem to have a twentieth.
LEAST_NOISE = 0.1
# The triangles of noisy points tell only part of the noise, those of smoother points all of it. If
# that is hardly more, nothing would change.
ROUNDS, MORE_NOISE = 2, 1.2
# Sum of the cosines between a face and the known normals of its corners: 3 on a plane. Faces below
# bridge two sheets.
LEAST_AGREEMENT = 1.5
# A piece with fewer faces is no surface: two rings around a point have more.
LEAST_PIECE = 40
# Points on a line, up to this share of its length, have no surface.
LEAST_WIDTH = 1e-6
# Nothing is divided by less.
TINY = 1e-300


def surface_from_points(cloud: PointCloud) -> TriangleMesh:
    """A triangle mesh over all points of the cloud, numbered as they are.

    A surface grows over the Delaunay triangles of the points, small and smooth ones first. Holes
    stay open, and so do gaps between sheets that nearly touch. Where the points are noisy the
    triangles are found for smoothed points; the vertices are the points as given. Faces agree
    with their neighbors, and with the cloud's normals where it has some; without, they look to
    where they can be seen from, which for a bowl seen from inside is wrong.

    Raises
    ------
    InvalidMeshError
        If no triangle is found, as when all points coincide or lie on a line.

    Notes
    -----
    70,000 points take about 10 s, noisy ones twice that. Points that belong to no triangle, as
    stray ones, crumbs of fewer than 40 triangles and further points at the same place, are
    vertices without a face.

    Examples
    --------
    >>> from sherd.shapes.creature import creature
    >>> animal = creature(5000)
    >>> mesh = surface_from_points(PointCloud(animal.vertices))
    >>> mesh.vertex_count == animal.vertex_count, bool(abs(mesh.area / animal.area - 1) < 0.05)
    (True, True)

    References
    ----------
    Cohen-Steiner, Da, *A greedy Delaunay-based surface reconstruction algorithm*, 2004.
    """
    places, kept = np.unique(cloud.points, axis=0, return_index=True)
    normals = None if cloud.normals is None else cloud.normals[kept]
    places = places - places.mean(axis=0)
    places = places / max(np.abs(places).max(), TINY)  # no product of lengths overflows
    faces = np.empty((0, 3), dtype=np.int64)
    if _is_wide(places):
        faces = _without_crumbs(places, _surface_faces(places, normals))
    if not len(faces):
        raise InvalidMeshError(
            f"{cloud.name}: no surface runs through its {cloud.point_count} points; they coincide, "
            "lie on a line, or are too few"
        )
    return TriangleMesh(cloud.points, kept[faces], name=cloud.name)


def _is_wide(points: Floats) -> bool:
    """Whether four points or more span a plane."""
    if len(points) < 4:
        return False
    width = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(width[1] > LEAST_WIDTH * width[0])


def _surface_faces(points: Floats, normals: Floats | None) -> Ints:
    """Faces (m, 3) of the surface through distinct points, noisy or not."""
    faces, smooth = _grown_faces(points, normals), points
    lowered = LEAST_NOISE * float(np.median(_spacing(points)))
    for _ in range(ROUNDS):
        noise = noise_of_points(points, TriangleMesh(smooth, faces)) if len(faces) else 0.0
        if noise < lowered:
            break
        smooth, lowered = smoothed_points(points, noise), MORE_NOISE * noise
        faces = _grown_faces(smooth, normals)
    if not len(faces):
        return faces
    own = vertex_normals(smooth, faces)
    if normals is None:
        outside = seen_from_outside(smooth, own)
    else:
        outside = np.einsum("ij,ij->i", own, normals)
    return turned_outward(smooth, faces, outside)


def _grown_faces(points: Floats, normals: Floats | None) -> Ints:
    """Faces (m, 3) of the surface that grows over the Delaunay facets of distinct points."""
    spacing = _spacing(points)
    facets = delaunay_facets(points, spacing, LONGEST_SIDE)
    across = face_normals(points, facets.corners)
    if normals is not None:
        side = np.einsum("mx,mkx->mk", across, normals[facets.corners]).sum(axis=1)
        agree = np.abs(side) > LEAST_AGREEMENT
        facets, across = Facets(*(array[agree] for array in facets)), across[agree]
    corners = facets.corners
    if not len(corners):
        return corners
    usual = _usual_around(points, spacing)[corners].max(axis=1)
    large = edge_lengths(points, corners).max(axis=1) > COARSE * usual
    size = facets.radius / np.median(facets.radius)
    turn = grown(Triangles(points, corners, *_edges(corners, len(points)), across, size, large))
    faces: Ints = np.where((turn < 0)[:, None], corners[:, ::-1], corners)[turn != 0]
    return faces


def _spacing(points: Floats) -> Floats:
    """Distance (n,) of the sixth neighbor, less where points are alone or few."""
    tree: Any = cKDTree(points)
    count = min(SIXTH, len(points) - 1)
    distance, near = tree.query(points, k=count + 1)
    sixth = np.minimum(distance[:, count], CLUMP * distance[:, min(THIRD, count)])
    spacing: Floats = np.minimum(sixth, LARGEST_STEP * np.median(sixth[near[:, 1:]], axis=1))
    return spacing


def _usual_around(points: Floats, spacing: Floats) -> Floats:
    """Median spacing (n,) of the 64 points nearest to each."""
    tree: Any = cKDTree(points)
    near = tree.query(points, k=min(AROUND, len(points)))[1]
    usual: Floats = np.median(spacing[near], axis=1)
    return usual


def _edges(corners: Ints, count: int) -> tuple[Ints, Ints, Ints]:
    """Edges of triangles with ascending corners, as :func:`grown` wants them."""
    ends = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [0, 2]]])
    _, edge = np.unique(ends[:, 0] * count + ends[:, 1], return_inverse=True)
    order = np.argsort(edge, kind="stable")
    first = np.searchsorted(edge[order], np.arange(edge.max() + 2))
    return edge.reshape(3, -1).T.copy(), first, order % len(corners)


def _without_crumbs(points: Floats, faces: Ints) -> Ints:
    """The faces of pieces with LEAST_PIECE faces or more; all if there are none."""
    pairs = gluing.face_pairs(points, faces) // 3
    piece = gluing.components(pairs[:, 0], pairs[:, 1], len(faces))
    large = np.bincount(piece)[piece] >= LEAST_PIECE
    kept: Ints = faces[large] if large.any() else faces
    return kept
