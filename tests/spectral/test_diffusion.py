"""Heat flow of values: what it keeps, and what it averages over."""

import numpy as np
import pytest

from sherd.mesh.geometry import angle_defects
from sherd.spectral.diffusion import diffused


def test_heat_is_kept_and_a_constant_stays(sphere) -> None:
    mesh = sphere(3)
    values = np.random.default_rng(0).normal(size=(mesh.vertex_count, 2))
    values[:, 1] = 3.0
    smooth = diffused(mesh, values, 0.2)
    np.testing.assert_allclose(smooth[:, 1], 3.0, rtol=1e-12)
    assert mesh.vertex_areas @ smooth[:, 0] == pytest.approx(mesh.vertex_areas @ values[:, 0])
    assert np.ptp(smooth[:, 0]) < 0.6 * np.ptp(values[:, 0])


def test_the_first_harmonic_of_a_sphere_falls_by_its_eigenvalue(sphere) -> None:
    mesh, width = sphere(4), 0.3
    height = mesh.vertices[:, 2:]
    expected = height / (1.0 + 2.0 * 0.5 * width**2)  # eigenvalue 2, one implicit step
    np.testing.assert_allclose(diffused(mesh, height, width), expected, atol=3e-3)


def test_defects_sum_to_four_pi_and_vanish_where_a_plane_is_only_bent(sphere) -> None:
    mesh = sphere(2)
    total = angle_defects(mesh.vertices, mesh.faces).sum()
    assert total == pytest.approx(4 * np.pi, rel=1e-12)
    # a strip folded along its middle: six faces around one inner vertex on the fold
    flat = np.array([[-1.0, -1], [0, -1], [1, 0], [1, 1], [0, 1], [-1, 0], [0, 0]])
    folded = np.column_stack([np.abs(flat[:, 0]) * 0.6, flat[:, 1], flat[:, 0] * 0.8])
    faces = np.array([[6, i, (i + 1) % 6] for i in range(6)])
    assert angle_defects(folded, faces)[6] == pytest.approx(0.0, abs=1e-12)
