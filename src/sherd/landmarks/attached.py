"""Landmarks on a template: the points of its surface that they stand for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sherd.arrays import Floats, FrozenState
from sherd.errors import InputError
from sherd.landmarks.landmark_list import Landmarks, Space
from sherd.mesh.surface_points import SurfacePoints, closest_points
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["FARTHEST", "AttachedLandmarks", "attached"]

# In sqrt(area) of the mesh. Landmarks set by hand on a skull lie 0.002 off the surface, those in
# the middle of an opening farther; what is as far away as answers count as near is meant for
# another mesh, another unit or other axes.
FARTHEST = 0.05
NAMED = 4


@dataclass(frozen=True, eq=False, repr=False)
class AttachedLandmarks(FrozenState):
    """Landmarks and where they stand on a mesh.

    Attributes
    ----------
    mesh
        The shape.
    landmarks
        In its coordinates.
    points
        The closest points of its surface; of a landmark without a position, face 0.
    distances
        (p,) how far off they lie, in the unit of the mesh; NaN without a position.
    """

    mesh: TriangleMesh
    landmarks: Landmarks
    points: SurfacePoints
    distances: Floats

    def __repr__(self) -> str:
        return f"AttachedLandmarks({len(self.landmarks)} points on {self.mesh.name!r})"


def attached(
    landmarks: Landmarks, mesh: TriangleMesh, *, mesh_space: Space | None = None
) -> AttachedLandmarks:
    """The points of `mesh` closest to the landmarks.

    Parameters
    ----------
    landmarks, mesh
        In one unit.
    mesh_space
        How the axes of the mesh's file run, where that is known: the landmarks are turned into it.
        None: the numbers of both files are of one space, whatever it is called. 3D Slicer writes
        both as LPS since version 5.

    Raises
    ------
    InputError
        If a landmark lies far from the surface; the message says whether other axes would explain
        it.
    """
    placed = landmarks if mesh_space is None else landmarks.in_space(mesh_space)
    points, distances = _closest(placed, mesh)
    if np.nanmax(distances, initial=0.0) > FARTHEST * mesh.length:
        raise InputError(_refusal(placed, mesh, distances))
    return AttachedLandmarks(mesh, placed, points, distances)


def _closest(landmarks: Landmarks, mesh: TriangleMesh) -> tuple[SurfacePoints, Floats]:
    known = landmarks.known
    positions = np.where(known[:, None], landmarks.positions, mesh.vertices[0])
    points = closest_points(mesh, positions)
    distances = np.linalg.norm(points.positions(mesh) - positions, axis=1)
    return points, np.where(known, distances, np.nan)


def _refusal(landmarks: Landmarks, mesh: TriangleMesh, distances: Floats) -> str:
    far = distances > FARTHEST * mesh.length
    names = [landmarks.names[k] for k in np.flatnonzero(far)[:NAMED]]
    more = ", ..." if far.sum() > NAMED else ""
    said = (
        f"{landmarks.source}: {int(far.sum())} of {len(landmarks)} landmarks ({', '.join(names)}"
        f"{more}) lie up to {np.nanmax(distances):.4g} from the surface of {mesh.name}, whose "
        f"sqrt(area) is {mesh.length:.4g}"
    )
    _, turned = _closest(landmarks.flipped(), mesh)
    if np.nanmax(turned) <= FARTHEST * mesh.length:
        space = f" is {landmarks.space} and" if landmarks.space else ""
        other = "RAS" if landmarks.space == "LPS" else "LPS"
        return (
            f"{said}; with x and y of the other sign they lie on it: the file{space} the mesh "
            f"{other} (--mesh-space {other}, in Python mesh_space={other!r})"
        )
    return f"{said}; are they of this mesh, and in its unit?"
