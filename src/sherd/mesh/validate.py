"""The one door through which arrays come in.

Every array from outside passes here once; behind the door nobody checks again. Messages name
the first bad element, what was wanted and what to do.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sherd.arrays import Floats, Ints, frozen
from sherd.errors import InvalidMeshError

__all__ = ["checked_faces", "checked_field", "checked_vertices"]

# Squared areas are fourth powers of lengths, and (1e70)^4 = 1e280 is still a float64.
LARGEST_COORDINATE = 1e70
# Below, squared areas of edges 1e-10 times as long as the mesh would lose digits.
SMALLEST_EXTENT = 1e-60


def checked_vertices(vertices: ArrayLike) -> Floats:
    """Return `vertices` as a read-only (n, 3) float64 array of finite coordinates.

    Raises
    ------
    InvalidMeshError
        If the shape is not (n, 3), a coordinate is NaN, infinite or beyond 1e70, or all lie
        within 1e-60 of each other without being equal.
    """
    array = _as_array(vertices, np.float64, "vertices")
    if array.ndim != 2 or array.shape[1] != 3:
        raise InvalidMeshError(f"vertices has shape {array.shape}, but (n, 3) is needed")
    bad = ~(np.abs(array) <= LARGEST_COORDINATE)
    if bad.any():
        row, column = (int(index) for index in np.argwhere(bad)[0])
        raise InvalidMeshError(
            f"vertices[{row}, {column}] = {array[row, column]}, but coordinates must be finite "
            f"({int(bad.any(axis=1).sum())} of {len(array)} vertices are not); "
            "export the mesh again or remove these vertices"
        )
    extent = float(np.ptp(array, axis=0).max()) if len(array) else 0.0
    if 0 < extent < SMALLEST_EXTENT:
        raise InvalidMeshError(
            f"all {len(array)} vertices lie within {extent:.2g} of each other, and such numbers "
            "lose their digits in areas; give the mesh a larger unit"
        )
    return _private(array, vertices)


def checked_faces(faces: ArrayLike, vertex_count: int) -> Ints:
    """Return `faces` as a read-only (m, 3) int64 array of indices below `vertex_count`.

    Raises
    ------
    InvalidMeshError
        If the shape is not (m, 3), there is no face, or an index is out of range.
    """
    raw = np.asarray(faces)
    if raw.dtype.kind == "f" and raw.size and not np.array_equal(raw, np.round(raw)):
        raise InvalidMeshError("faces holds fractions, but vertex indices are whole numbers")
    array: Ints = _as_array(raw, np.int64, "faces").astype(np.int64, copy=False)
    if array.ndim != 2 or array.shape[1] != 3:
        if array.size == 0:
            raise InvalidMeshError(_NO_FACES)
        raise InvalidMeshError(f"faces has shape {array.shape}, but (m, 3) is needed")
    if len(array) == 0:
        raise InvalidMeshError(_NO_FACES)
    bad = (array < 0) | (array >= vertex_count)
    if bad.any():
        row, column = (int(index) for index in np.argwhere(bad)[0])
        raise InvalidMeshError(
            f"faces[{row}, {column}] = {array[row, column]}, but there are {vertex_count} vertices "
            f"(0..{vertex_count - 1}); the file is damaged or counts vertices from 1"
        )
    return _private(array, faces)


def checked_field(name: str, values: ArrayLike, vertex_count: int) -> Floats:
    """Return one vertex field as a read-only (n,) or (n, c) float64 array; NaN means unknown.

    Raises
    ------
    InvalidMeshError
        If the first dimension is not the number of vertices.
    """
    array = _as_array(values, np.float64, f"field {name!r}")
    if array.ndim not in (1, 2) or len(array) != vertex_count:
        raise InvalidMeshError(
            f"field {name!r} has shape {array.shape}, but its first length must be {vertex_count}"
        )
    return _private(array, values)


_NO_FACES = (
    "there are no faces, only points; give triangles, or make them over the points of a part by "
    "sherd.surface_from_points(sherd.PointCloud(points))"
)


def _as_array(values: ArrayLike, kind: type, name: str) -> NDArray[np.generic]:
    try:
        return np.asarray(values).astype(kind, copy=False)
    except (TypeError, ValueError, OverflowError) as error:
        raise InvalidMeshError(f"{name} cannot be read as numbers: {error}") from error


def _private(array: NDArray[np.generic], source: ArrayLike) -> NDArray:  # type: ignore[type-arg]
    """Read-only, and never sharing memory with a caller who could still write to it."""
    shared = array is source or np.may_share_memory(array, np.asarray(source))
    if shared and (array.flags.writeable or array.base is not None):
        array = array.copy()
    return frozen(array)
