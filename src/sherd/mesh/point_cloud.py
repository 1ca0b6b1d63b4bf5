"""PointCloud: a scan without faces, frozen."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from sherd.arrays import Floats, FrozenState, frozen
from sherd.errors import InvalidMeshError
from sherd.mesh.validate import checked_vertices

__all__ = ["PointCloud"]


@dataclass(frozen=True, eq=False, repr=False)
class PointCloud(FrozenState):
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
