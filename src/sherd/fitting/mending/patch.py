"""Patch: a few faces of a deformation, deformed apart from the rest and put back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sherd.arrays import Bools
from sherd.fitting.as_rigid_as_possible import Elasticity
from sherd.fitting.deformation import Deformation
from sherd.mesh.topology import renumbered
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["Patch"]


class Patch:
    """The faces around vertices that may move, as a mesh of its own.

    Parameters
    ----------
    elasticity
        Of the full shape, n vertices.
    found
        Its deformation.
    free
        (n,) the vertices that may move; they and their neighbors are of the patch.

    Attributes
    ----------
    faces, vertices
        Their numbers in the full shape.
    elasticity, start, free
        As given, of the patch alone.
    """

    def __init__(self, elasticity: Elasticity, found: Deformation, free: Bools) -> None:
        faces = elasticity.mesh.faces
        self.faces = np.flatnonzero(free[faces].any(axis=1))
        self.vertices, corners = renumbered(faces[self.faces])
        self.elasticity = Elasticity(TriangleMesh(elasticity.rest[self.vertices], corners))
        self.start = Deformation(
            found.positions[self.vertices],
            found.rotations[self.vertices],
            found.sizes[self.vertices],
        )
        self.free: Bools = free[self.vertices]

    def put_back(self, found: Deformation, now: Deformation) -> Deformation:
        """The deformation of the full shape with that of the patch in its place."""
        positions, rotations = found.positions.copy(), found.rotations.copy()
        positions[self.vertices], rotations[self.vertices] = now.positions, now.rotations
        return replace(found, positions=positions, rotations=rotations)
