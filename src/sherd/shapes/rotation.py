"""Random rotations."""

from __future__ import annotations

import numpy as np

from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["rotated"]


def rotated(mesh: TriangleMesh, rng: np.random.Generator) -> TriangleMesh:
    """The mesh turned about the origin by a random rotation, uniform over all."""
    frame, triangular = np.linalg.qr(rng.normal(size=(3, 3)))
    frame = frame * np.sign(np.diag(triangular))
    if np.linalg.det(frame) < 0:
        frame[:, 0] = -frame[:, 0]
    return mesh.with_vertices(mesh.vertices @ frame.T)
