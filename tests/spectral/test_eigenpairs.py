"""Eigenpairs against analytic spectra, on components, flat faces, and moved meshes."""

import numpy as np
import pytest

from sherd.errors import OptionError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.basis import eigenbasis


def square(size):
    """Unit square of size x size cells, each cut along the same diagonal."""
    ticks = np.linspace(0.0, 1.0, size + 1)
    x, y = np.meshgrid(ticks, ticks, indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    corner = (np.arange(size)[:, None] * (size + 1) + np.arange(size)).ravel()
    up, right = corner + 1, corner + size + 1
    faces = np.concatenate(
        [np.stack([corner, right, right + 1], 1), np.stack([corner, right + 1, up], 1)]
    )
    return TriangleMesh(vertices, faces, name="square")


def test_square_spectrum_converges_with_rate_two():
    pairs = np.add.outer(np.arange(6) ** 2, np.arange(6) ** 2).ravel()
    truth = np.pi**2 * np.sort(pairs)[:12]
    errors = []
    for size in (10, 20, 40):
        found = eigenbasis(square(size), 12).eigenvalues
        errors.append(np.abs(found[1:] / truth[1:] - 1).max())
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert rates == pytest.approx([2, 2], abs=0.2)
    assert errors[-1] < 0.01


def test_sphere_spectrum_converges_with_rate_two(sphere):
    truth = np.repeat([2.0, 6.0, 12.0], [3, 5, 7])
    errors = []
    for levels in (3, 4, 5):
        found = eigenbasis(sphere(levels), 16).eigenvalues
        assert found[0] == pytest.approx(0, abs=1e-8)
        errors.append(np.abs(found[1:] / truth - 1).max())
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert rates == pytest.approx([2, 2], abs=0.25)


def test_basis_is_orthonormal_reproducible_and_proves_itself(sphere):
    mesh = sphere(4)
    basis = eigenbasis(mesh, 40)
    assert basis.residual < 1e-8
    assert basis.laplacian == "cotangent"
    assert basis.vertex_areas.sum() == pytest.approx(mesh.area, rel=1e-12)
    gram = basis.project(basis.eigenvectors)
    np.testing.assert_allclose(gram, np.eye(40), atol=1e-9)
    again = eigenbasis(mesh, 40)
    assert np.array_equal(basis.eigenvectors, again.eigenvectors)
    assert basis.truncated(7).eigenvectors.shape == (mesh.vertex_count, 7)


def test_one_zero_eigenvalue_per_component_and_none_for_a_lone_vertex(sphere):
    first, second = square(12), sphere(3)
    count = first.vertex_count
    vertices = np.concatenate([first.vertices, second.vertices + 5, [[9.0, 9, 9]]])
    faces = np.concatenate([first.faces, second.faces + count])
    basis = eigenbasis(TriangleMesh(vertices, faces), 8)
    assert (np.abs(basis.eigenvalues) < 1e-8).sum() == 2
    # the span of the two zero vectors holds the indicator of each component
    zero = basis.eigenvectors[:, :2]
    indicator = (np.arange(len(vertices)) < count).astype(float)
    shown = zero @ basis.project(indicator)[:2]
    np.testing.assert_allclose(shown, indicator, atol=1e-7)
    assert not basis.eigenvectors[-1].any()


def test_rigid_motion_scale_and_numbering_move_the_answer_along():
    mesh = square(14)
    stretched = mesh.with_vertices(mesh.vertices * [1.0, 1.37, 1.0])  # simple spectrum
    basis = eigenbasis(stretched, 6)
    rng = np.random.default_rng(1)
    frame = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    order = rng.permutation(mesh.vertex_count)
    renumber = np.argsort(order)
    moved = TriangleMesh(
        3.0 * (stretched.vertices @ frame.T + [4, 5, 6])[order], renumber[mesh.faces]
    )
    other = eigenbasis(moved, 6)
    np.testing.assert_allclose(other.eigenvalues * 9, basis.eigenvalues, atol=1e-7)
    overlap = 3 * other.project(basis.eigenvectors[order]) / 9
    np.testing.assert_allclose(np.abs(overlap), np.eye(6), atol=1e-6)


def test_flat_faces_are_answered_by_the_intrinsic_delaunay_laplacian():
    mesh = square(20)
    # a vertex in the middle of an edge gives one face at the edge no area
    vertices = np.concatenate([mesh.vertices, mesh.vertices[[0, 22]].mean(axis=0)[None]])
    start, end = 0, 22
    both = np.isin(mesh.faces, [start, end]).sum(axis=1) == 2
    row = int(np.flatnonzero(both)[0])
    apex = next(v for v in mesh.faces[row] if v not in (start, end))
    face = list(mesh.faces[row])
    middle = len(vertices) - 1
    halves = [
        [middle if v == start else v for v in face],
        [middle if v == end else v for v in face],
    ]
    faces = np.concatenate([np.delete(mesh.faces, row, axis=0), halves, [[start, middle, end]]])
    assert apex in faces[-2]
    basis = eigenbasis(TriangleMesh(vertices, faces), 6)
    assert basis.laplacian == "intrinsic Delaunay"
    truth = np.pi**2 * np.array([1, 1, 2, 4, 4])
    np.testing.assert_allclose(basis.eigenvalues[1:], truth, rtol=0.02)
    assert basis.residual < 1e-8


def test_tiny_meshes_and_wrong_sizes():
    triangle = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    assert eigenbasis(triangle, 100).size == 3
    with pytest.raises(OptionError, match="basis size is 0"):
        eigenbasis(triangle, 0)
