"""Shapes with known answers."""

import numpy as np
import pytest

from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.subdivision import split_edges

OCTAHEDRON = [
    [0, 1, 2],
    [1, 3, 2],
    [3, 4, 2],
    [4, 0, 2],
    [1, 0, 5],
    [3, 1, 5],
    [4, 3, 5],
    [0, 4, 5],
]


def _sphere(levels):
    """Unit sphere of 4^(levels + 1) + 2 vertices."""
    # the corners +x, +y, +z, -x, -y, -z
    vertices = np.concatenate([np.eye(3), -np.eye(3)])
    faces = np.array(OCTAHEDRON)
    for _ in range(levels):
        faces, parents = split_edges(faces, len(vertices))
        middle = vertices[parents].sum(axis=1)
        middle /= np.linalg.norm(middle, axis=1, keepdims=True)
        vertices = np.concatenate([vertices, middle])
    return TriangleMesh(vertices, faces, name="sphere")


@pytest.fixture(name="sphere", scope="session")
def _sphere_maker():
    return _sphere
