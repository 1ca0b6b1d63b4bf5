"""PointMap: for every vertex of the part a point of the full shape, and how sure it is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sherd.arrays import Bools, Floats, Ints, frozen
from sherd.errors import InvalidMeshError
from sherd.mesh.surface_points import SurfacePoints

__all__ = ["PointMap"]


@dataclass(frozen=True, eq=False)
class PointMap:
    """Where each vertex of the part lies on the full shape; every vertex has an answer.

    Attributes
    ----------
    faces
        (n_part,) int, face of the full shape.
    barycentric
        (n_part, 3) float, weights of its corners.
    matched
        (n_part,) bool, False where the full shape seems to have no such point; the answer there
        is the best guess.
    confidence
        (n_part,) float in [0, 1], chance that the error is below 0.05 sqrt(area of full).

    Raises
    ------
    InvalidMeshError
        If the arrays do not have one row per vertex, or a confidence is outside [0, 1].
    """

    faces: Ints
    barycentric: Floats
    matched: Bools
    confidence: Floats

    def __post_init__(self) -> None:
        points = SurfacePoints(self.faces, self.barycentric)
        matched = np.array(self.matched, dtype=bool)
        confidence = np.array(self.confidence, dtype=np.float64)
        if matched.shape != (len(points),) or confidence.shape != (len(points),):
            raise InvalidMeshError(
                f"matched has shape {matched.shape} and confidence {confidence.shape}, but there "
                f"are {len(points)} points"
            )
        if not ((confidence >= 0) & (confidence <= 1)).all():
            raise InvalidMeshError("confidence must lie in [0, 1]")
        object.__setattr__(self, "faces", points.faces)
        object.__setattr__(self, "barycentric", points.barycentric)
        object.__setattr__(self, "matched", frozen(matched))
        object.__setattr__(self, "confidence", frozen(confidence))

    def __len__(self) -> int:
        return len(self.faces)

    @property
    def points(self) -> SurfacePoints:
        """The answers as points on the full shape."""
        return SurfacePoints(self.faces, self.barycentric)
