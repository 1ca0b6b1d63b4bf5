"""PointCloud: a scan without faces, frozen; and a triangle mesh over its points."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import cKDTree

from sherd.errors import InvalidMeshError
from sherd.mesh import gluing
from sherd.mesh.geometry import face_normals
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.mesh.umbrella_kernel import umbrellas
from sherd.mesh.validate import checked_vertices, frozen

__all__ = ["PointCloud", "surface_of"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Two rings of neighbors on an even sampling: the Delaunay triangles at the middle point are then
# bounded by points that are all there.
NEIGHBORS = 18
# Even samplings have edges up to twice the distance of the sixth neighbor; longer ones span holes.
LONGEST = 2.5
# Sum of the cosines between a face and the normals of its corners: 3 on a plane. Faces below bridge
# two sheets.
LEAST_AGREEMENT = 1.5
# On a perfect grid both diagonals of a square are Delaunay. A random weight for each point decides,
# the same for all that see the square: in squares of lengths, above rounding, below any noise.
TIE = 1e-9
# A piece with fewer faces is no surface: two rings around a point have more.
LEAST_PIECE = 40


@dataclass(frozen=True, eq=False, repr=False)
class PointCloud:
    """Points of a surface, and their normals where the scanner gave them; arrays are read-only.

    Parameters
    ----------
    points
        (n, 3) float, l, finite, n >= 4.
    normals
        (n, 3) float toward the outside, of any length but 0; None if unknown.
    name
        What messages and reports call it.

    Raises
    ------
    InvalidMeshError
        If an array does not describe points; the message names the first bad element.

    Examples
    --------
    >>> PointCloud([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    PointCloud('points', 4 points)
    """

    points: Floats
    normals: Floats | None = None
    name: str = field(default="points", kw_only=True)

    def __init__(
        self, points: ArrayLike, normals: ArrayLike | None = None, *, name: str = "points"
    ) -> None:
        checked = checked_vertices(points)
        if len(checked) < 4:
            raise InvalidMeshError(f"there are {len(checked)} points, but a surface needs 4")
        object.__setattr__(self, "points", checked)
        object.__setattr__(self, "normals", _checked_normals(normals, len(checked)))
        object.__setattr__(self, "name", name)

    def __repr__(self) -> str:
        return f"PointCloud({self.name!r}, {self.point_count} points)"

    @property
    def point_count(self) -> int:
        """N."""
        return len(self.points)


def surface_of(cloud: PointCloud) -> TriangleMesh:
    """A triangle mesh over all points of the cloud, numbered as they are.

    Each point is triangulated with its neighbors in its tangent plane; a triangle is taken if two
    of its corners agree on it, or if it fills a gap between such. Holes stay open. Faces agree
    with their neighbors, and with the cloud's normals where it has some; without, an open surface
    may be inside out.

    Raises
    ------
    InvalidMeshError
        If no triangle is found, as when all points coincide or lie on a line.

    Notes
    -----
    70,000 points take about 4 s. Points that belong to no triangle, as stray ones and crumbs of
    fewer than 40 triangles, are vertices without a face.

    References
    ----------
    Sharp, Crane, *A Laplacian for nonmanifold triangle meshes*, 2020, section 5.7: local
    triangulations. Taking triangles by agreement of their corners is our own.
    """
    points = cloud.points
    count = min(NEIGHBORS + 1, len(points))
    tree: Any = cKDTree(points)
    distance, near = tree.query(points, k=count)
    frames = _frames(points, near)
    reach = LONGEST * distance[:, min(6, count - 1)]
    found = _umbrellas(points, near, frames[:, :2], reach)
    faces, agreed = np.unique(np.sort(found, axis=1), axis=0, return_counts=True)
    normals = _oriented(frames[:, 2], near) if cloud.normals is None else cloud.normals
    faces, kept = _facing(points, faces, normals)
    faces = _manifold(points, faces, agreed[kept] >= 2)
    if not len(faces):
        raise InvalidMeshError(
            f"{cloud.name}: no surface runs through its {len(points)} points; they coincide, lie "
            "on a line, or are too few"
        )
    return TriangleMesh(points, _without_crumbs(points, faces), name=cloud.name)


def _checked_normals(normals: ArrayLike | None, count: int) -> Floats | None:
    if normals is None:
        return None
    array = np.array(normals, dtype=np.float64)
    if array.shape != (count, 3):
        raise InvalidMeshError(f"normals has shape {array.shape}, but {(count, 3)} is needed")
    length = np.linalg.norm(array, axis=1)
    bad = ~(np.isfinite(length) & (length > 0))
    if bad.any():
        row = int(np.argmax(bad))
        raise InvalidMeshError(f"normals[{row}] = {array[row]}, but a direction is needed")
    unit: Floats = frozen(array / length[:, None]).astype(np.float64, copy=False)
    return unit


def _frames(points: Floats, near: Ints) -> Floats:
    """Two tangents and the normal of each point, rows of (n, 3, 3), from its neighbors."""
    offset = points[near] - points[near].mean(axis=1, keepdims=True)
    axes = np.linalg.eigh(np.einsum("nki,nkj->nij", offset, offset))[1]
    frames: Floats = axes[:, :, ::-1].transpose(0, 2, 1)
    return frames


def _umbrellas(points: Floats, near: Ints, tangents: Floats, reach: Floats) -> Ints:
    """Delaunay triangles (t, 3) at each point among its neighbors, in its tangent plane."""
    count = len(points)
    offset = np.einsum("nkj,nij->nki", points[near] - points[:, None], tangents)
    weight = np.random.default_rng(0).random(count)
    weight = TIE * np.median(reach) ** 2 * (weight[near] - weight[:, None])
    pairs = umbrellas(offset, weight, reach)
    point, rank = np.nonzero(pairs[:, :, 0] >= 0)
    ends = near[point[:, None], pairs[point, rank]]
    triangles: Ints = np.concatenate([point[:, None], ends], axis=1)
    return triangles


def _oriented(normals: Floats, near: Ints) -> Floats:
    """The normals with signs that agree from neighbor to neighbor, most parallel ones first.

    Hoppe and others, *Surface reconstruction from unorganized points*, 1992, section 3.3.
    """
    count = len(normals)
    rows, columns = np.repeat(np.arange(count), near.shape[1] - 1), near[:, 1:].ravel()
    bend = 1.001 - np.abs((normals[rows] * normals[columns]).sum(axis=1))
    graph = sparse.csr_array((bend, (rows, columns)), shape=(count, count))
    tree = csgraph.minimum_spanning_tree(graph.maximum(graph.T))
    signed = normals.copy()
    seen = np.zeros(count, dtype=bool)
    for start in range(count):
        if seen[start]:
            continue
        order, before = csgraph.breadth_first_order(tree, start, directed=False)
        seen[order] = True
        for point in order[1:].tolist():
            if signed[point] @ signed[before[point]] < 0:
                signed[point] = -signed[point]
    return signed


def _facing(points: Floats, faces: Ints, normals: Floats) -> tuple[Ints, NDArray[np.bool_]]:
    """Faces turned to the side of their corners' normals, and which were kept.

    Those that stand across the normals are left out.
    """
    across = face_normals(points, faces)
    side = np.einsum("mx,mkx->mk", across, normals[faces]).sum(axis=1)
    kept = np.abs(side) > LEAST_AGREEMENT
    turned = np.where((side < 0)[:, None], faces[:, ::-1], faces)
    return turned[kept], kept


def _without_crumbs(points: Floats, faces: Ints) -> Ints:
    """The faces of pieces with LEAST_PIECE faces or more; all if there are none."""
    pairs = gluing.face_pairs(points, faces) // 3
    piece = gluing.components(pairs[:, 0], pairs[:, 1], len(faces))
    large = np.bincount(piece)[piece] >= LEAST_PIECE
    kept: Ints = faces[large] if large.any() else faces
    return kept


def _manifold(points: Floats, faces: Ints, agreed: NDArray[np.bool_]) -> Ints:
    """The `agreed` faces, the smallest first, and others that close gaps between them.

    No edge gets more than two. Noise makes neighbors draw different diagonals, on which nobody
    agrees; a face closes a gap if it shares two sides or more with faces that are there.
    """
    corners = points[faces]
    size = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    order = np.argsort(size, kind="stable").tolist()
    ordered = np.sort(faces, axis=1).tolist()
    uses: dict[tuple[int, int], int] = {}
    kept: list[int] = []
    waiting = [face for face in order if agreed[face]]
    others = [face for face in order if not agreed[face]]
    least, before = 0, -1
    while len(kept) > before:
        before, left = len(kept), []
        for face in waiting:
            a, b, c = ordered[face]
            sides = ((a, b), (b, c), (a, c))
            there = [uses.get(side, 0) for side in sides]
            if max(there) < 2 and sum(there) >= least:
                kept.append(face)
                uses.update(zip(sides, (count + 1 for count in there), strict=True))
            else:
                left.append(face)
        waiting, least = others if least == 0 else left, 2
    manifold: Ints = faces[np.sort(np.array(kept, dtype=np.int64))]
    return manifold
