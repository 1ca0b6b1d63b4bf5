"""Carry what lives on one shape over to the other through a point map.

Numbers (fields, colors) are interpolated inside triangles; labels are not, since the mean of two
labels is no label: the corner with the largest weight decides. What has no partner stays unknown.
"""

from __future__ import annotations

from typing import Protocol, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sherd.arrays import Bools, Floats, Ints
from sherd.errors import InvalidMeshError
from sherd.mesh.surface_points import SurfacePoints, closest_points
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = [
    "Labels",
    "Matched",
    "TransferMethods",
    "checked_vertices",
    "field_to_full",
    "field_to_part",
    "labels_to_full",
    "labels_to_part",
    "landmarks_to_full",
    "landmarks_to_part",
    "nearest_part_points",
]


# A point of the full shape has a partner on the part if the part's image passes within this many
# mean edges of it: the image of a part meshed as densely leaves no wider gaps inside the region.
REACH_IN_EDGES = 1.0
UNKNOWN_LABEL = -1
# A corner of a triangle with less than this share of a point does not make it unknown.
LEAST_WEIGHT = 1e-9

# (n,) whole numbers, of which -1 is unknown, or text, of which "" is.
Labels: TypeAlias = NDArray[np.int64] | NDArray[np.str_]


class Matched(Protocol):
    """What is needed of a match, see :class:`sherd.results.match_result.MatchResult`."""

    @property
    def full(self) -> TriangleMesh:
        """The full shape."""

    @property
    def part(self) -> TriangleMesh:
        """The part."""

    @property
    def points(self) -> SurfacePoints:
        """The partner of each vertex of the part."""

    @property
    def matched(self) -> Bools:
        """Which vertices of the part have one."""

    @property
    def scale(self) -> float:
        """Factor that the part was enlarged by."""


class TransferMethods:
    """The functions of this module as methods, for what is :class:`Matched`."""

    def field_to_part(self: Matched, values: ArrayLike) -> Floats:
        """Values (n_full,) or (n_full, c) at the part's vertices; NaN if unmatched."""
        return field_to_part(self, values)

    def field_to_full(self: Matched, values: ArrayLike) -> Floats:
        """Values (n_part,) or (n_part, c) at the full shape's vertices; NaN where nothing lies."""
        return field_to_full(self, values)

    def labels_to_part(self: Matched, labels: ArrayLike) -> Labels:
        """Labels (n_full,), whole numbers or text, at the part; unmatched: -1 or ""."""
        return labels_to_part(self, labels)

    def labels_to_full(self: Matched, labels: ArrayLike) -> Labels:
        """Labels (n_part,), whole numbers or text, at the full shape; elsewhere: -1 or ""."""
        return labels_to_full(self, labels)

    def landmarks_to_part(self: Matched, vertices: ArrayLike) -> tuple[SurfacePoints, Floats]:
        """Points of the part for vertices (p,) of the full shape, and how far each is missed.

        See :func:`sherd.results.transfer.landmarks_to_part`.
        """
        return landmarks_to_part(self, vertices)

    def landmarks_to_full(self: Matched, vertices: ArrayLike) -> SurfacePoints:
        """Points of the full shape where the given vertices (p,) of the part lie."""
        return landmarks_to_full(self, vertices)


def field_to_part(result: Matched, values: ArrayLike) -> Floats:
    """Values (n_full,) or (n_full, c) of the full shape at the part's vertices; NaN if unmatched.

    Raises
    ------
    InvalidMeshError
        If there is not one value per vertex of the full shape.
    """
    array = _checked(values, result.full, "full shape").astype(np.float64)
    carried = _interpolated(result.points, result.full, array)
    carried[~result.matched] = np.nan
    return carried


def labels_to_part(result: Matched, labels: ArrayLike) -> Labels:
    """Labels (n_full,), whole numbers or text, at the part's vertices; -1 or "" if unmatched."""
    array = _checked_labels(labels, result.full, "full shape")
    carried = array[result.points.nearest_vertices(result.full)]
    return np.where(result.matched, carried, _unknown(array))


def field_to_full(result: Matched, values: ArrayLike) -> Floats:
    """Values (n_part,) or (n_part, c) of the part at the full shape's vertices; NaN outside."""
    array = _checked(values, result.part, "part").astype(np.float64)
    points, found = nearest_part_points(result)
    carried = _interpolated(points, result.part, array)
    carried[~found] = np.nan
    return carried


def labels_to_full(result: Matched, labels: ArrayLike) -> Labels:
    """Labels (n_part,), whole numbers or text, at the full shape's vertices; -1 or "" outside."""
    array = _checked_labels(labels, result.part, "part")
    points, found = nearest_part_points(result)
    return np.where(found, array[points.nearest_vertices(result.part)], _unknown(array))


def landmarks_to_full(result: Matched, vertices: ArrayLike) -> SurfacePoints:
    """Points of the full shape where the given vertices (p,) of the part lie.

    Raises
    ------
    InvalidMeshError
        If a vertex does not exist.
    """
    return result.points[checked_vertices(vertices, result.part, "part")]


def landmarks_to_part(result: Matched, vertices: ArrayLike) -> tuple[SurfacePoints, Floats]:
    """Points of the part nearest to the given vertices (p,) of the full shape, and how near.

    The second array (p,) is the distance on the full shape between the landmark and the image of
    the answer, in units of sqrt(area of the full shape): large where the part lacks the landmark.
    """
    wanted = checked_vertices(vertices, result.full, "full shape")
    points, distances = _on_image(result, result.full.vertices[wanted])
    return points, distances / result.full.length


def nearest_part_points(result: Matched) -> tuple[SurfacePoints, Bools]:
    """For each vertex of the full shape the point of the part whose image is nearest.

    The second array (n_full,) is True where that image is near enough to be a partner.
    """
    points, distances = _on_image(result, result.full.vertices)
    corners = result.matched[result.part.faces[points.faces]]
    near = distances <= REACH_IN_EDGES * result.full.mean_edge_length
    return points, near & corners.all(axis=1)


def _on_image(result: Matched, positions: Floats) -> tuple[SurfacePoints, Floats]:
    """Nearest points of the part's image on the full shape, and their distances, l."""
    image = result.part.with_vertices(result.points.positions(result.full))
    # a face that the map tears apart spans places it does not belong to
    whole = result.matched[image.faces].all(axis=1) & ~_torn(result, image)
    usable = np.flatnonzero(whole if whole.any() else np.ones_like(whole))
    kept = TriangleMesh(image.vertices, image.faces[usable], name=image.name)
    points = closest_points(kept, positions)
    found = points.positions(kept)
    distances = np.linalg.norm(found - positions, axis=1)
    return SurfacePoints(usable[points.faces], points.barycentric), distances


# A mapped edge this many times longer than it was has been torn, not stretched.
TEAR = 3.0


def _torn(result: Matched, image: TriangleMesh) -> Bools:
    def longest(mesh: TriangleMesh) -> Floats:
        corners = mesh.vertices[mesh.faces]
        sides: Floats = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
        lengths: Floats = sides.max(axis=1)
        return lengths

    before = np.maximum(longest(result.part) * result.scale, 0.25 * image.mean_edge_length)
    torn: Bools = longest(image) > TEAR * before
    return torn


def _checked(values: ArrayLike, mesh: TriangleMesh, shape: str) -> NDArray[np.generic]:
    array = np.asarray(values)
    if array.ndim not in (1, 2) or len(array) != mesh.vertex_count:
        raise InvalidMeshError(
            f"values has shape {array.shape}, but the {shape} has {mesh.vertex_count} vertices"
        )
    return array


def _interpolated(points: SurfacePoints, mesh: TriangleMesh, values: Floats) -> Floats:
    """Values (n,) or (n, c) at points; NaN where a corner that counts is NaN."""
    known = np.isfinite(values)
    carried = points.interpolate(mesh, np.where(known, values, 0.0))
    if not known.all():
        share = points.interpolate(mesh, known.astype(np.float64))
        carried[share < 1 - LEAST_WEIGHT] = np.nan
    return carried


def _unknown(labels: Labels) -> int | str:
    return "" if labels.dtype.kind == "U" else UNKNOWN_LABEL


def _checked_labels(labels: ArrayLike, mesh: TriangleMesh, shape: str) -> Labels:
    array = _checked(labels, mesh, shape)
    if array.dtype.kind == "U" and array.ndim == 1:
        return array.astype(np.str_)
    if array.dtype.kind not in "biuf":
        raise InvalidMeshError("labels must be whole numbers or text, one per vertex")
    whole = array.astype(np.int64)
    if array.ndim != 1 or not np.array_equal(whole, array):
        raise InvalidMeshError("labels must be whole numbers or text, one per vertex")
    return whole


def checked_vertices(vertices: ArrayLike, mesh: TriangleMesh, shape: str) -> Ints:
    """Vertices (p,) that exist in `mesh`, which messages call `shape`.

    Raises
    ------
    InvalidMeshError
        If one does not.
    """
    wanted = np.atleast_1d(np.asarray(vertices, dtype=np.int64))
    bad = (wanted < 0) | (wanted >= mesh.vertex_count)
    if bad.any():
        raise InvalidMeshError(
            f"vertex {wanted[np.argmax(bad)]} does not exist; the {shape} has "
            f"0..{mesh.vertex_count - 1}"
        )
    return wanted
