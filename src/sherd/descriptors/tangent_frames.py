"""Tangent frames of a surface, and the direction in which geodesics leave a point.

A frame is a unit axis `z` (the smoothed normal) and a unit axis `x` perpendicular to it; the
angle of a tangent direction is counted from `x` towards `z cross x`, seen from outside.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from sherd.arrays import Floats, Ints, Singles
from sherd.mesh.geometry import face_cross
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.diffusion import diffused
from sherd.threads import over_rows

__all__ = ["Compass", "smoothed_normals", "tangent_axes"]


def smoothed_normals(mesh: TriangleMesh, width: float) -> Floats:
    """Unit vertex normals (n, 3) after heat flow of standard deviation `width` (mesh length).

    Inside the cone of the normals that it averages; two meshings of one surface get the same.
    """
    smooth = diffused(mesh, mesh.vertex_normals, width)
    length = np.linalg.norm(smooth, axis=1, keepdims=True)
    upright = np.array([0.0, 0.0, 1.0])  # any axis will do where no face gives a normal
    return np.where(length > 0, smooth / np.where(length > 0, length, 1.0), upright)


def tangent_axes(normals: Floats, reference: Floats) -> Floats:
    """Unit vectors (n, 3) perpendicular to `normals` and closest to `reference` (n, 3).

    Where the reference is nearly parallel to the normal, the coordinate axis most perpendicular
    to the normal takes its place.
    """
    flat = reference - (reference * normals).sum(axis=1, keepdims=True) * normals
    length = np.linalg.norm(flat, axis=1, keepdims=True)
    spare = np.cross(normals, np.eye(3)[np.abs(normals).argmin(axis=1)])
    chosen = np.where(length < 1e-3, spare, flat)
    result: Floats = chosen / np.linalg.norm(chosen, axis=1, keepdims=True)
    return result


class Compass:
    """Tells in which directions geodesics leave samples.

    A direction is minus the gradient of the distance to the target, averaged over the faces at
    the sample. Closer than `near` (mesh length), where the gradient of a distance is poor, the
    chord takes its place.

    Parameters
    ----------
    mesh
        The surface.
    samples
        (s,) vertices.
    x_axes, z_axes
        (s, 3) tangent frame at each sample.
    near
        Below this distance the chord is used.
    """

    def __init__(
        self, mesh: TriangleMesh, samples: Ints, *, x_axes: Floats, z_axes: Floats, near: float
    ) -> None:
        from sherd.descriptors.direction_kernel import Slopes  # loads slowly  # noqa: PLC0415

        self._mesh, self._samples, self._near = mesh, samples, near
        side = np.cross(z_axes, x_axes)
        along = _sample_gradient(mesh, samples, x_axes)
        across = _sample_gradient(mesh, samples, side)
        self._slopes = Slopes(
            along.indptr.astype(np.int64), along.indices.astype(np.int64), along.data, across.data
        )
        self._axes = np.ascontiguousarray(x_axes), np.ascontiguousarray(side)

    def toward(self, targets: Ints, distances: NDArray[np.floating]) -> Singles:
        """Angle (s, t) in radians at which the geodesic to each target leaves each sample.

        Parameters
        ----------
        targets
            (t,) vertices.
        distances
            (t, n) geodesic distance from each of them; infinite entries give meaningless angles.
        """
        from sherd.descriptors.direction_kernel import directions  # as above  # noqa: PLC0415

        places = self._mesh.vertices
        angles = np.empty((len(self._samples), len(targets)), dtype=np.float32)
        over_rows(
            directions, len(targets), places[self._samples], places[targets], self._samples,
            distances, self._slopes, *self._axes, self._near, angles,
        )  # fmt: skip
        return angles


def _sample_gradient(mesh: TriangleMesh, samples: Ints, axes: Floats) -> sparse.csr_array:
    """Area-weighted derivative along `axes` at each sample, up to a positive factor per sample."""
    row_of = np.full(mesh.vertex_count, -1, dtype=np.int64)
    row_of[samples] = np.arange(len(samples))
    normals = face_cross(mesh.vertices, mesh.faces)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    rows, columns, values = [], [], []
    for at in range(3):
        faces = np.flatnonzero(row_of[mesh.faces[:, at]] >= 0)
        row = row_of[mesh.faces[faces, at]]
        corners = mesh.faces[faces]
        for corner in range(3):
            tail, head = corners[:, (corner + 1) % 3], corners[:, (corner + 2) % 3]
            slope = np.cross(normals[faces], mesh.vertices[head] - mesh.vertices[tail])
            rows.append(row)
            columns.append(corners[:, corner])
            values.append((slope * axes[row]).sum(axis=1))
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return sparse.coo_array(entries, shape=(len(samples), mesh.vertex_count)).tocsr()
