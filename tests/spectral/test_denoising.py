"""The noise of a scan is measured and lowered; a clean mesh stays itself."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes.creature import creature
from sherd.shapes.fragment import cut_by_ball, noisy, remeshed, whole
from sherd.spectral.denoising import denoised, noise_level


@pytest.fixture(scope="module")
def clean():
    full = creature(5000)
    return remeshed(cut_by_ball(whole(full, full), 0, 0.5), 1.1)


@pytest.mark.parametrize("sigma", [0.002, 0.004])
def test_noise_is_measured_and_lowered(clean, sigma):
    spoiled = noisy(clean, sigma, rng=np.random.default_rng(0)).mesh
    length = clean.full.length
    assert noise_level(spoiled) == pytest.approx(sigma * length, rel=0.15)
    smooth = denoised(spoiled)
    normals = clean.mesh.vertex_normals
    inner = np.setdiff1d(np.arange(clean.mesh.vertex_count), clean.mesh.boundary_vertices)

    def off(mesh: TriangleMesh) -> float:
        return float(np.std(((mesh.vertices - clean.mesh.vertices) * normals).sum(axis=1)[inner]))

    assert off(smooth) < 0.85 * off(spoiled)
    border = clean.mesh.boundary_vertices
    np.testing.assert_allclose(smooth.vertices[border], spoiled.vertices[border], atol=1e-9)


def test_a_clean_mesh_and_one_without_an_inside_stay_themselves(clean):
    assert denoised(clean.mesh) is clean.mesh
    single = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    assert noise_level(single) == 0
    assert denoised(single) is single
