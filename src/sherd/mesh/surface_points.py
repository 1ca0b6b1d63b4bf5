"""SurfacePoints: points on a mesh, said as face and barycentric weights."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import cKDTree

from sherd.arrays import Floats, FrozenState, Ints, frozen
from sherd.errors import InvalidMeshError
from sherd.mesh.geometry import face_balls
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.threads import search_threads

__all__ = ["SurfacePoints", "closest_points", "points_at_vertices"]

# Weights come from files with about seven digits; larger sums of errors are a damaged file.
WEIGHT_TOLERANCE = 1e-3
# Points searched at once: 12 neighbors of each take 20 MB.
BLOCK = 100_000


@dataclass(frozen=True, eq=False, repr=False)
class SurfacePoints(FrozenState):
    """Points on the surface of one mesh.

    Parameters
    ----------
    faces
        (p,) int, the face that each point lies on.
    barycentric
        (p, 3) float in [0, 1], weight of each corner of that face; rows sum to 1.

    Raises
    ------
    InvalidMeshError
        If the shapes differ, a weight is outside [0, 1] or a row does not sum to 1.

    Examples
    --------
    >>> middle = SurfacePoints([0], [[0.5, 0.5, 0.0]])
    >>> triangle = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> middle.positions(triangle).tolist()
    [[0.5, 0.0, 0.0]]
    """

    faces: Ints
    barycentric: Floats

    def __post_init__(self) -> None:
        faces = np.array(self.faces, dtype=np.int64)
        weights = np.array(self.barycentric, dtype=np.float64)
        if faces.ndim != 1 or weights.shape != (len(faces), 3):
            raise InvalidMeshError(
                f"faces has shape {faces.shape} and barycentric {weights.shape}, "
                "but (p,) and (p, 3) are needed"
            )
        bad = ~(np.abs(weights.sum(axis=1) - 1) <= WEIGHT_TOLERANCE)
        bad |= ~(weights.min(axis=1, initial=0) >= -WEIGHT_TOLERANCE)
        if bad.any():
            row = int(np.argmax(bad))
            raise InvalidMeshError(
                f"barycentric[{row}] = {weights[row]}, but weights lie in [0, 1] and sum to 1"
            )
        weights = np.clip(weights, 0.0, 1.0)
        weights /= weights.sum(axis=1, keepdims=True)
        object.__setattr__(self, "faces", frozen(faces))
        object.__setattr__(self, "barycentric", frozen(weights))

    def __repr__(self) -> str:
        return f"SurfacePoints({len(self)} points)"

    def __len__(self) -> int:
        return len(self.faces)

    def __getitem__(self, index: ArrayLike) -> SurfacePoints:
        rows = np.atleast_1d(np.asarray(index))
        return SurfacePoints(self.faces[rows], self.barycentric[rows])

    def interpolate(self, mesh: TriangleMesh, values: ArrayLike) -> Floats:
        """Vertex values (n,) or (n, c) of `mesh` at the points, (p,) or (p, c)."""
        corners = np.asarray(values, dtype=np.float64)[mesh.faces[self.faces]]
        result: Floats = np.einsum("pk,pk...->p...", self.barycentric, corners)
        return result

    def positions(self, mesh: TriangleMesh) -> Floats:
        """Coordinates of the points, (p, 3) l."""
        return self.interpolate(mesh, mesh.vertices)

    def nearest_vertices(self, mesh: TriangleMesh) -> Ints:
        """The corner with the largest weight, (p,)."""
        corners = mesh.faces[self.faces]
        nearest: Ints = corners[np.arange(len(self)), self.barycentric.argmax(axis=1)]
        return nearest


def points_at_vertices(mesh: TriangleMesh, vertices: ArrayLike) -> SurfacePoints:
    """The given vertices (p,) of `mesh` as surface points, each on one of its faces.

    Raises
    ------
    InvalidMeshError
        If a vertex is out of range or belongs to no face.
    """
    wanted = np.atleast_1d(np.asarray(vertices, dtype=np.int64))
    face_of = np.full(mesh.vertex_count, -1, dtype=np.int64)
    corner_of = np.zeros(mesh.vertex_count, dtype=np.int64)
    for corner in range(3):
        face_of[mesh.faces[:, corner]] = np.arange(mesh.face_count)
        corner_of[mesh.faces[:, corner]] = corner
    outside = (wanted < 0) | (wanted >= mesh.vertex_count)
    if outside.any():
        row = int(np.argmax(outside))
        raise InvalidMeshError(
            f"vertices[{row}] = {wanted[row]}, but {mesh.name} has vertices "
            f"0..{mesh.vertex_count - 1}"
        )
    if (face_of[wanted] < 0).any():
        row = int(np.argmax(face_of[wanted] < 0))
        raise InvalidMeshError(f"vertex {wanted[row]} of {mesh.name} belongs to no face")
    weights = np.zeros((len(wanted), 3))
    weights[np.arange(len(wanted)), corner_of[wanted]] = 1.0
    return SurfacePoints(face_of[wanted], weights)


def closest_points(
    mesh: TriangleMesh, positions: ArrayLike, *, neighbors: int = 12
) -> SurfacePoints:
    """The point of `mesh` closest to each position (p, 3), among the faces at near vertices.

    Faces around the `neighbors` nearest face centers are searched, which is exact wherever
    triangles are not much longer than wide and the positions lie near the surface; it costs
    O(p * neighbors). Ericson, *Real-Time Collision Detection*, 2005, section 5.1.5.
    """
    from sherd.mesh.closest_kernel import closest_on_faces  # numba loads slowly  # noqa: PLC0415

    points = np.ascontiguousarray(np.atleast_2d(np.asarray(positions, dtype=np.float64)))
    corners = np.ascontiguousarray(mesh.vertices[mesh.faces])
    balls = face_balls(corners)
    count = min(neighbors, mesh.face_count)
    tree = cKDTree(balls[:, :3], balanced_tree=False)
    faces, weights = np.empty(len(points), dtype=np.int64), np.empty((len(points), 3))
    for start in range(0, len(points), BLOCK):  # the neighbors of all points at once fill memory
        block = slice(start, start + BLOCK)
        here = points[block]
        found = tree.query(here, k=count, workers=search_threads(len(here)))[1]
        near = found.reshape(-1, count)
        faces[block], weights[block] = closest_on_faces(
            here, near, corners, balls, np.zeros(near.shape)
        )
    return SurfacePoints(faces, weights)
