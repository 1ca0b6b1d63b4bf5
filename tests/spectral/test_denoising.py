"""The noise of a scan is measured and lowered; clean meshes stay themselves."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import spearmanr

from sherd.descriptors.relief import relief
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes.creature import creature
from sherd.shapes.fragment import cut_by_ball, noisy, remeshed, whole
from sherd.spectral.denoising import denoised, noise_level, smoothed_alike


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


def test_clean_pieces_stay_themselves(clean):
    found = smoothed_alike([clean.mesh, clean.full], clean.full.length)
    assert found.meshes == (clean.mesh, clean.full)
    assert found.width == 0
    assert found.notices == ((), ())


@pytest.mark.parametrize("sigma", [0.001, 0.0015])
def test_two_noisy_scans_of_one_surface_have_one_relief(clean, sigma):
    length = clean.full.length
    scans = [noisy(clean, sigma, rng=np.random.default_rng(seed)).mesh for seed in (0, 1)]
    found = smoothed_alike(scans, length)
    away = np.linalg.norm(
        clean.mesh.vertices[:, None] - clean.mesh.vertices[clean.mesh.boundary_vertices], axis=2
    )
    inner = away.min(axis=1) > 0.05 * length

    def alike(one: TriangleMesh, other: TriangleMesh) -> float:
        both = [relief(mesh.with_vertices(mesh.vertices / length))[inner] for mesh in (one, other)]
        return float(spearmanr(*both)[0])

    assert alike(*found.meshes) > max(0.85, alike(*scans) + 0.1)
    # borders are smooth as well
    border = clean.mesh.boundary_vertices
    apart, before = (
        float(np.linalg.norm((one.vertices - other.vertices)[border], axis=1).mean())
        for one, other in (found.meshes, scans)
    )
    assert apart < 0.6 * before
    assert "noisy" in found.notices[0][0]


def test_a_noisy_piece_is_compared_with_clean_ones_that_are_as_smooth(clean):
    length = clean.full.length
    scan = noisy(clean, 0.003, rng=np.random.default_rng(0)).mesh
    found = smoothed_alike([clean.full, scan], length)
    assert 0.005 * length < found.width < 0.03 * length
    assert found.meshes[0] is not clean.full
    assert [mesh.vertex_count for mesh in found.meshes] == [
        clean.full.vertex_count,
        scan.vertex_count,
    ]
    assert noise_level(found.meshes[1]) < 0.3 * found.noise[1]
    assert found.notices[0][0].startswith("others are noisy")
    assert found.notices[1][0].startswith("its vertices are noisy")


def test_corners_of_a_machine_part_stay_where_they_are():
    corners = np.array([[x, y, z] for x in (0, 4) for y in (0, 1) for z in (0, 0.2)], dtype=float)
    faces = [
        [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
        [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
    ]  # fmt: skip
    part = TriangleMesh(corners, faces)
    (found,) = smoothed_alike([part], part.length).meshes
    assert np.linalg.norm(found.vertices - corners, axis=1).max() < 0.1 * part.length
