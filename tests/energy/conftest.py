"""A small region problem: a bumpy sphere, smooth descriptors, a cap as the part."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from sherd.energy.problem import EnergyWeights, RegionProblem, region_problem
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.basis import EigenBasis, eigenbasis


@pytest.fixture(scope="session")
def bumpy_sphere() -> TriangleMesh:
    ball = trimesh.creation.icosphere(subdivisions=3)
    x, y, z = ball.vertices.T
    radius = 1 + 0.2 * x + 0.15 * y * z + 0.1 * np.cos(3 * x) * y
    return TriangleMesh(ball.vertices * radius[:, None], ball.faces, name="bumpy sphere")


@pytest.fixture(scope="session")
def cap(bumpy_sphere: TriangleMesh) -> np.ndarray:
    return (bumpy_sphere.vertices[:, 2] > 0.55).astype(float)


@pytest.fixture(scope="session")
def sphere_basis(bumpy_sphere: TriangleMesh) -> EigenBasis:
    return eigenbasis(bumpy_sphere, 60)


@pytest.fixture(scope="session")
def cap_problem(bumpy_sphere: TriangleMesh, cap: np.ndarray) -> RegionProblem:
    centers = np.random.default_rng(3).standard_normal((12, 3))
    centers /= np.linalg.norm(centers, axis=1, keepdims=True)
    descriptors = np.exp(3 * (bumpy_sphere.vertices @ centers.T - 1))
    areas = bumpy_sphere.vertex_areas
    return region_problem(
        bumpy_sphere,
        full_descriptors=descriptors,
        part_integral=descriptors.T @ (areas * cap),
        part_area=float(areas @ cap),
        weights=EnergyWeights(regularity=0.002, phase_width=0.3),
    )
