"""Completion: the scan where there was one, the fitted surface where there was none."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sherd.arrays import FrozenState, Ints, frozen
from sherd.errors import InvalidMeshError
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["FITTED", "Completion"]

# Origin of a vertex of the fitted surface; others have the number of their piece.
FITTED = -1


@dataclass(frozen=True, eq=False, repr=False)
class Completion(FrozenState):
    """A scan whose missing surface was filled in from the fit.

    Attributes
    ----------
    mesh
        In the coordinates and unit of the pieces.
    origin
        (n,) number of the piece that each vertex was taken from as it is; -1 for the fit.
    watertight
        Whether every edge has two faces that agree on what is outside.
    stitched
        True: the vertices and faces of the pieces as they are, a strip of faces, and the fit beyond
        it. False: the vertices and faces of the full shape, those that were seen moved to the
        closest point of the pieces.
    reason
        Why it is not stitched, or not watertight; empty if it is both.
    """

    mesh: TriangleMesh
    origin: Ints
    watertight: bool
    stitched: bool
    reason: str = ""

    def __post_init__(self) -> None:
        origin = np.array(self.origin, dtype=np.int64)
        if origin.shape != (self.mesh.vertex_count,):
            raise InvalidMeshError(
                f"origin has shape {origin.shape}, but the mesh has {self.mesh.vertex_count} "
                "vertices"
            )
        object.__setattr__(self, "origin", frozen(origin))

    def __repr__(self) -> str:
        kind = "stitched" if self.stitched else "moved to the scan"
        return f"Completion({self.mesh.vertex_count} vertices, {kind})"
