"""Heat and wave kernels against what is known of spheres and planes."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.descriptors.field import SpectralSurface
from sherd.descriptors.heat_kernel_signature import (
    HeatKernel,
    automatic_times,
    boundary_affected,
    heat_kernel_signature,
)
from sherd.descriptors.wave_kernel_signature import WaveKernel, wave_kernel_signature
from sherd.errors import OptionError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.basis import eigenbasis
from sherd.spectral.geodesics import Geodesics


def grid(count: int) -> TriangleMesh:
    """Unit square with right triangles."""
    ticks = np.linspace(0, 1, count)
    x, y = np.meshgrid(ticks, ticks, indexing="ij")
    index = np.arange(count * count).reshape(count, count)
    a, b, c, d = (
        index[i : count - 1 + i, j : count - 1 + j].ravel() for i in (0, 1) for j in (0, 1)
    )
    faces = np.concatenate([np.stack([a, c, d], 1), np.stack([a, d, b], 1)])
    return TriangleMesh(np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], 1), faces, name="square")


@pytest.fixture(scope="module")
def square() -> TriangleMesh:
    return grid(41)


@pytest.fixture(scope="module")
def basis(square):
    return eigenbasis(square, 200)


def test_heat_in_the_middle_of_a_plane(square, basis) -> None:
    """4 pi t k_t(x, x) is 1 on a plane, as long as the edge is far."""
    middle = int(np.argmin(np.linalg.norm(square.vertices - [0.5, 0.5, 0], axis=1)))
    times = np.array([0.006, 0.01])  # at shorter times the mesh width of 0.025 is felt
    signature = heat_kernel_signature(basis, times)[middle]
    assert 4 * np.pi * times * signature == pytest.approx([1.0, 1.0], abs=0.02)


def test_total_heat_is_the_trace(square, basis) -> None:
    """Integral of k_t(x, x) = sum of exp(-lambda t)."""
    total = square.vertex_areas @ heat_kernel_signature(basis, 0.01)[:, 0]
    assert total == pytest.approx(np.exp(-basis.eigenvalues * 0.01).sum(), rel=1e-9)


def test_edge_is_felt_where_it_is_said_to_be(square, basis) -> None:
    """A straight reflecting edge adds exp(-d^2 / t); beyond 2 sqrt(t) less than 2 %."""
    t = 0.01
    distance = Geodesics(square).distances_to_set(square.boundary_vertices)
    excess = np.abs(4 * np.pi * t * heat_kernel_signature(basis, t)[:, 0] - 1)
    affected = boundary_affected(distance, [t])[:, 0]
    corner = np.linalg.norm(np.abs(square.vertices[:, :2] - 0.5) - 0.5, axis=1) < 0.25
    # two edges at 2 sqrt(t) add 3.7 % near a corner
    assert excess[~affected & ~corner].max() < 0.04
    side = affected & ~corner & (distance < 0.5 * np.sqrt(t))
    assert excess[side].min() > 0.5


def test_heat_kernel_has_no_unit(square) -> None:
    times = (0.005, 0.02)
    fields = []
    for factor in (1.0, 1000.0):
        mesh = square.with_vertices(square.vertices * factor)
        surface = SpectralSurface(
            mesh, eigenbasis(mesh, 60), mesh.length, np.full(mesh.vertex_count, 1.0)
        )
        fields.append(HeatKernel(times).describe(surface).values)
    np.testing.assert_allclose(fields[0], fields[1], rtol=1e-6)


def test_automatic_times_leave_half_of_the_part(square, basis) -> None:
    distance = Geodesics(square).distances_to_set(square.boundary_vertices)
    surface = SpectralSurface(square, basis, square.length, distance)
    times = automatic_times([surface], 6)
    assert np.all(np.diff(times) > 0)
    assert np.exp(-basis.eigenvalues[-1] * times[0]) < 0.02
    valid = ~boundary_affected(distance, times)
    assert square.vertex_areas[valid[:, -1]].sum() == pytest.approx(0.5, abs=0.05)


def test_wave_kernel_weights_sum_to_one(square, basis) -> None:
    """Each energy's signature integrates to the weighted mean of phi^2, which is 1."""
    signature = wave_kernel_signature(basis, np.log([50.0, 500.0]), 0.3)
    assert square.vertex_areas @ signature == pytest.approx([1.0, 1.0])


def test_wave_kernel_field_marks_the_edge(square, basis) -> None:
    distance = Geodesics(square).distances_to_set(square.boundary_vertices)
    field = WaveKernel.between(100.0, 1000.0, 5).describe(
        SpectralSurface(square, basis, square.length, distance)
    )
    assert field.values.shape == (square.vertex_count, 5)
    assert not field.valid[square.boundary_vertices].any()
    assert field.valid[:, -1].sum() > field.valid[:, 0].sum()  # short waves reach less far


def test_wrong_parameters(basis) -> None:
    with pytest.raises(OptionError, match="must be positive"):
        heat_kernel_signature(basis, [0.1, 0.0])
    with pytest.raises(OptionError, match="width is 0"):
        wave_kernel_signature(basis, [1.0], 0)
