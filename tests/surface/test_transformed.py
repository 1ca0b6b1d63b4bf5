"""Mirrored and enlarged surfaces: what is carried over is what would have been computed."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.surface.described import RADII, DescribedSurface
from sherd.surface.template import Template
from sherd.surface.transformed import FLIP, enlarged, mirrored
from sherd.surface.working import working_surface


@pytest.fixture(scope="module")
def piece(template: Template) -> DescribedSurface:
    """An open piece whose long edges were split."""
    mesh = template.placed
    height = mesh.vertices[mesh.faces, 0].mean(axis=1)
    return DescribedSurface(working_surface(mesh.submesh(height > np.median(height))[0]))


def angle(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return np.abs(np.angle(np.exp(1j * (first.astype(float) - second))))


def test_mirrored_twice_it_is_itself(piece: DescribedSurface) -> None:
    back = mirrored(mirrored(piece))
    for one, other in ((piece.mesh, back.mesh), (piece.placed, back.placed)):
        np.testing.assert_array_equal(one.vertices, other.vertices)
        np.testing.assert_array_equal(one.faces, other.faces)
    np.testing.assert_array_equal(piece.own_vertices.barycentric, back.own_vertices.barycentric)
    np.testing.assert_array_equal(piece.reference, back.reference)
    np.testing.assert_array_equal(piece.normals, back.normals)
    np.testing.assert_array_equal(piece.cut_distance, back.cut_distance)
    for name in ("vertices", "distances", "between", "directions", "farthest_first"):
        np.testing.assert_array_equal(getattr(piece.sparse, name), getattr(back.sparse, name))
    some = piece.sparse.vertices[:50]
    np.testing.assert_array_equal(piece.spectra_at(some), back.spectra_at(some))


def test_what_a_mirror_image_takes_over_is_what_it_would_compute(piece: DescribedSurface) -> None:
    image = mirrored(piece)
    plain = DescribedSurface(image.working, reference=piece.reference * FLIP)
    np.testing.assert_allclose(image.normals, plain.normals, atol=1e-9)
    assert np.abs(image.cut_distance - plain.cut_distance).max() < 1e-6
    np.testing.assert_array_equal(image.sparse.vertices, plain.sparse.vertices)
    assert np.abs(image.sparse.between - plain.sparse.between).max() < 1e-5
    assert np.quantile(angle(image.sparse.directions, plain.sparse.directions), 0.99) < 1e-3
    some = np.arange(0, image.mesh.vertex_count, 9)
    for here, there in zip(piece.frames(some), image.frames(some), strict=True):
        np.testing.assert_allclose(there, here * FLIP, atol=1e-12)
    assert image.mesh.area == pytest.approx(piece.mesh.area)
    # its faces look outward
    assert (image.mesh.vertex_normals * image.normals).sum(axis=1).min() > 0
    # the given vertices lie where they lay
    places = image.own_vertices.positions(image.mesh)
    np.testing.assert_allclose(places, image.placed.vertices, atol=1e-9)
    np.testing.assert_allclose(places, piece.placed.vertices * FLIP, atol=1e-9)


def test_enlarged_twice_is_enlarged_by_the_product(piece: DescribedSurface) -> None:
    twice, once = enlarged(enlarged(piece, 1.5), 0.8), enlarged(piece, 1.2)
    np.testing.assert_allclose(twice.mesh.vertices, once.mesh.vertices, rtol=1e-12)
    np.testing.assert_allclose(twice.placed.vertices, once.placed.vertices, rtol=1e-12)
    np.testing.assert_allclose(twice.cut_distance, once.cut_distance, rtol=1e-12)
    for name in ("distances", "between"):
        one, other = getattr(twice.sparse, name), getattr(once.sparse, name)
        np.testing.assert_allclose(one, other, rtol=1e-6)
    for name in ("vertices", "directions", "farthest_first"):
        one, other = getattr(twice.sparse, name), getattr(once.sparse, name)
        np.testing.assert_array_equal(one, other)


def test_what_an_enlarged_surface_takes_over_is_what_it_would_compute(
    piece: DescribedSurface,
) -> None:
    factor = 1.3
    large = enlarged(piece, factor)
    assert large.mesh.area == pytest.approx(factor**2 * piece.mesh.area)
    assert large.placed.area == pytest.approx(factor**2 * piece.placed.area)
    plain = DescribedSurface(large.working)
    assert np.abs(large.cut_distance - plain.cut_distance).max() < 1e-6
    np.testing.assert_array_equal(large.sparse.vertices, plain.sparse.vertices)
    assert np.abs(large.sparse.between - plain.sparse.between).max() < 1e-5
    # neighborhoods are not enlarged, so they are described anew
    some = piece.sparse.vertices[:20]
    assert large.spectra_at(some).shape[0] == 5
    assert len(RADII) == 3
    assert not np.allclose(large.spectra_at(some), piece.spectra_at(some), atol=1e-3)


def test_a_closed_surface_has_no_cut_at_any_size(template: Template) -> None:
    np.testing.assert_array_equal(enlarged(template, 2.0).cut_distance, template.cut_distance)
