"""SHOT: invariant under motion and meshing, but not under mirroring; soft words."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.descriptors.field import SpectralSurface
from sherd.descriptors.rotation_shot import mirrored_spectra, rotation_spectra, similarity
from sherd.descriptors.shot import Shot, shot
from sherd.descriptors.tangent_frames import smoothed_normals, tangent_axes
from sherd.descriptors.vocabulary import Vocabulary, learn_vocabulary
from sherd.errors import OptionError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes.creature import creature
from sherd.spectral.basis import eigenbasis


@pytest.fixture(scope="module")
def animal() -> TriangleMesh:
    return creature(5000)


def rotation(seed: int) -> np.ndarray:
    frame, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return frame * np.sign(np.linalg.det(frame))


def mirrored(mesh: TriangleMesh) -> TriangleMesh:
    return TriangleMesh(mesh.vertices * [-1, 1, 1], mesh.faces[:, ::-1])


def turning_spectra(mesh: TriangleMesh, vertices: np.ndarray, reference: np.ndarray) -> np.ndarray:
    normals = smoothed_normals(mesh, 0.02 * mesh.length)
    axes = normals[vertices]
    return rotation_spectra(
        mesh.vertices, normals, mesh.vertex_areas, vertices,
        x_axes=tangent_axes(axes, np.tile(reference, (len(vertices), 1))), z_axes=axes,
        radii=(0.08 * mesh.length, 0.12 * mesh.length),
    )  # fmt: skip


def test_motion_and_unit_do_not_matter(animal) -> None:
    queries = np.arange(0, animal.vertex_count, 97)
    moved = animal.with_vertices(5 * animal.vertices @ rotation(1).T + [3.0, -7.0, 1.0])
    first = shot(animal, 0.1 * animal.length, queries=queries)
    second = shot(moved, 0.1 * moved.length, queries=queries)
    np.testing.assert_allclose(first, second, atol=1e-4)
    np.testing.assert_allclose(np.linalg.norm(first, axis=1), 1, atol=1e-5)


def test_mirroring_matters(animal) -> None:
    queries = np.arange(0, animal.vertex_count, 97)
    first = shot(animal, 0.1 * animal.length, queries=queries)
    second = shot(mirrored(animal), 0.1 * animal.length, queries=queries)
    assert np.median(np.einsum("qd,qd->q", first, second)) < 0.9


def test_hidden_vertices_say_nothing(animal) -> None:
    """Zero weight for far vertices changes nothing; for all it gives zero."""
    near = np.linalg.norm(animal.vertices - animal.vertices[0], axis=1) < 0.2 * animal.length
    radius = 0.1 * animal.length
    whole = shot(animal, radius, queries=[0])
    hidden = shot(animal, radius, queries=[0], weights=animal.vertex_areas * near)
    np.testing.assert_array_equal(whole, hidden)
    assert not shot(animal, radius, queries=[0], weights=0 * animal.vertex_areas).any()


def test_rotation_search_finds_itself_in_any_frame(animal) -> None:
    queries = np.arange(0, animal.vertex_count, 211)
    here = turning_spectra(animal, queries, np.array([1.0, 0.3, 0.2]))
    there = turning_spectra(animal, queries, np.array([-0.4, 0.8, 0.5]))
    found = similarity(here, there)
    # 16 rotations of 8 soft azimuth bins: the best one is at most 11.25 degrees off
    assert np.diagonal(found).min() > 0.985 * 2 / 2
    best = found.argmax(axis=1)
    assert (best == np.arange(len(queries))).mean() > 0.9


def test_mirrored_spectra_are_those_of_the_mirror_image(animal) -> None:
    queries = np.arange(0, animal.vertex_count, 211)
    reference = np.array([0.0, 1.0, 0.1])
    image = turning_spectra(mirrored(animal), queries, reference)
    turned = mirrored_spectra(turning_spectra(animal, queries, reference))
    assert np.diagonal(similarity(image, turned)).min() > 0.985


def test_fields_mark_what_the_cut_spoils(animal) -> None:
    distance = np.linspace(0, 0.3, animal.vertex_count)
    surface = SpectralSurface(animal, eigenbasis(animal, 2), animal.length, distance)
    field = Shot((0.07,)).describe(surface)
    np.testing.assert_array_equal(field.interior, distance >= 0.07)


def test_radius_must_be_positive(animal) -> None:
    with pytest.raises(OptionError, match="radius is -1"):
        shot(animal, -1.0)


def test_histograms_are_soft_and_sum_to_one() -> None:
    words = Vocabulary(np.array([[0.0], [1.0]]), softness=0.5)
    histogram = words.histograms(np.array([[0.0], [0.5], [1.0], [50.0]]))
    np.testing.assert_allclose(histogram.sum(axis=1), 1)
    np.testing.assert_allclose(histogram[1], [0.5, 0.5])
    assert histogram[0, 0] == pytest.approx(1 / (1 + np.exp(-2)))
    assert histogram[3, 1] == pytest.approx(1)


def test_vocabulary_finds_clusters_and_repeats() -> None:
    rng = np.random.default_rng(3)
    points = np.concatenate([rng.normal(c, 0.01, size=(50, 2)) for c in ([0, 0], [1, 0], [0, 1])])
    first = learn_vocabulary(points, 3, rng=np.random.default_rng(0))
    second = learn_vocabulary(points, 3, rng=np.random.default_rng(0))
    np.testing.assert_array_equal(first.words, second.words)
    order = np.lexsort(np.round(first.words.T))
    np.testing.assert_allclose(first.words[order], [[0, 0], [1, 0], [0, 1]], atol=0.02)
    with pytest.raises(OptionError, match="vocabulary size is 0"):
        learn_vocabulary(points, 0, rng=rng)
