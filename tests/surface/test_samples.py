"""Samples: distances among them, cells around them, and how far apart the first ones are."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.surface.counted import TURN
from sherd.surface.described import NO_CUT, DescribedSurface
from sherd.surface.samples import (
    DENSE_COUNT,
    SPARSE_COUNT,
    Samples,
    coarse_labels,
    dense_samples,
)
from sherd.surface.template import Template
from sherd.surface.working import WorkingSurface, working_surface


@pytest.fixture(scope="module")
def open_part(template: Template) -> DescribedSurface:
    """The upper two thirds of the egg and, apart, a patch of its foot."""
    mesh = template.placed
    height = mesh.vertices[mesh.faces, 0].mean(axis=1)
    kept = (height > np.quantile(height, 0.4)) | (height < np.quantile(height, 0.1))
    part, _ = mesh.submesh(kept)
    return DescribedSurface(working_surface(part))


def is_ascending(values: np.ndarray) -> bool:
    return bool((values[1:] >= values[:-1]).all())


def samples_of(
    template: Template, part: DescribedSurface
) -> list[tuple[DescribedSurface, Samples]]:
    return [(template, template.dense), (template, template.sparse), (part, part.sparse)]


def test_there_are_as_many_as_promised(template: Template, open_part: DescribedSurface) -> None:
    # edges that were split add no places to be: samples are vertices of the shape itself
    assert len(template.dense) == min(DENSE_COUNT, template.placed.vertex_count)
    assert len(template.sparse) == len(open_part.sparse) == SPARSE_COUNT
    assert len(np.unique(template.sparse.vertices)) == SPARSE_COUNT


def test_distances_between_are_symmetric_and_those_to_the_vertices(
    template: Template, open_part: DescribedSurface
) -> None:
    for surface, samples in samples_of(template, open_part):
        between = samples.between
        np.testing.assert_array_equal(between, between.T)
        assert (np.diag(between) == 0).all()
        to_vertices = samples.distances[:, samples.vertices]
        assert (between <= to_vertices + 1e-6).all()
        connected = np.isfinite(between)
        # the heat method is not quite symmetric
        assert np.abs(between[connected] - to_vertices[connected]).max() < 0.05
        straight = surface.mesh.vertices[samples.vertices]
        straight = np.linalg.norm(straight[:, None] - straight, axis=2)
        assert (between >= 0.9 * straight - 0.01).all()


def test_samples_of_other_components_are_infinitely_far(open_part: DescribedSurface) -> None:
    samples = open_part.sparse
    labels = open_part.mesh.component_labels[samples.vertices]
    assert len(np.unique(labels)) == 2
    same = labels[:, None] == labels
    assert np.isfinite(samples.between[same]).all()
    assert np.isinf(samples.between[~same]).all()


def test_cells_are_those_of_the_nearest_sample(
    template: Template, open_part: DescribedSurface
) -> None:
    for surface, samples in samples_of(template, open_part):
        assert samples.cells.shape == (surface.mesh.vertex_count,)
        np.testing.assert_array_equal(samples.cells[samples.vertices], np.arange(len(samples)))
        others = np.setdiff1d(np.arange(surface.mesh.vertex_count), samples.vertices)
        nearest = samples.distances[:, others].min(axis=0)
        np.testing.assert_array_equal(samples.distances[samples.cells[others], others], nearest)


def test_a_sample_has_a_cell_of_its_own_though_another_is_as_near() -> None:
    """Two samples at no distance from each other, as on faces without area."""
    distances = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 2.0]], dtype=np.float32)
    none = np.zeros((2, 2), dtype=np.float32)
    samples = Samples.of(np.array([0, 1]), distances, none)
    assert samples.cells.tolist() == [0, 1, 0]
    assert samples.farthest_first.tolist() == [0, 1]


def test_coarse_labels_are_fewer_dense_samples_without_their_distances(
    template: Template,
) -> None:
    coarse = coarse_labels(template.working, template.frames, 300)
    dense = dense_samples(template.working, template.frames, 300)
    np.testing.assert_array_equal(coarse.vertices, dense.vertices)
    np.testing.assert_allclose(coarse.between, dense.between, atol=1e-4)  # those are rounded
    turned = np.angle(np.exp(1j * (coarse.directions - dense.directions)))
    assert np.abs(turned[~np.eye(300, dtype=bool)]).max() < 1e-3
    assert (coarse.cells == dense.cells).mean() > 0.99


def test_samples_are_spread_and_the_first_ones_farthest_apart(
    template: Template, open_part: DescribedSurface
) -> None:
    for _, samples in samples_of(template, open_part):
        assert sorted(samples.farthest_first) == list(range(len(samples)))
        spacing = []
        for count in (10, 40, 100):
            first = samples.farthest_first[:count]
            apart = samples.between[np.ix_(first, first)] + 9.0 * np.eye(count)
            reach = samples.distances[first].min(axis=0)
            spacing.append(apart.min())
            # no vertex is farther from all of them than two of them are from each other, up to
            # the error of distances on so coarse a mesh
            assert reach.max() <= 1.5 * apart.min()
        assert np.all(np.diff(spacing) < 0)
        some = np.random.default_rng(0).permutation(len(samples))[:40]
        at_random = samples.between[np.ix_(some, some)] + 9.0 * np.eye(40)
        assert spacing[1] > 1.5 * at_random.min()


def test_sparse_samples_are_sorted_from_the_deepest_one(open_part: DescribedSurface) -> None:
    samples = open_part.sparse
    assert is_ascending(samples.distances[0, samples.vertices])
    assert open_part.cut_distance[samples.vertices[0]] == open_part.cut_distance.max()
    assert samples.farthest_first[0] == 0


def test_wanted_vertices_are_among_the_sparse_samples(open_part: DescribedSurface) -> None:
    wanted = np.setdiff1d(np.unique(open_part.mesh.faces), open_part.sparse.vertices)[[5, 50]]
    asked = DescribedSurface(open_part.working, sampled_at=wanted)
    assert set(wanted) <= set(asked.sparse.vertices)
    assert len(asked.sparse) == SPARSE_COUNT + 2
    assert is_ascending(asked.sparse.distances[0, asked.sparse.vertices])
    row = int(np.flatnonzero(asked.sparse.vertices == wanted[0])[0])
    assert asked.sparse.distances[row, wanted[0]] == 0


def test_directions_point_from_sample_to_sample(template: Template) -> None:
    """Near ones, by the chord: in the frame of the first, up to the angle of the geodesic."""
    samples, mesh = template.dense, template.mesh
    x_axes, z_axes = template.frames(samples.vertices)
    places = mesh.vertices[samples.vertices]
    first, second = np.nonzero((samples.between > 0) & (samples.between < 0.2))
    chord = places[second] - places[first]
    x, y = x_axes[first], np.cross(z_axes, x_axes)[first]
    angle = np.arctan2((chord * y).sum(axis=1), (chord * x).sum(axis=1))
    off = np.abs(np.angle(np.exp(1j * (angle - samples.directions[first, second]))))
    assert np.median(off) < 0.05
    assert np.quantile(off, 0.99) < 0.3
    rounded = np.exp(2j * np.pi / TURN * samples.leaving)
    half = 1.01 * np.pi / TURN
    assert np.abs(np.angle(rounded * np.exp(-1j * samples.directions))).max() < half
    np.testing.assert_array_equal(samples.arriving, samples.leaving.T)


def test_the_distance_to_the_cut_is_that_to_the_border(
    template: Template, open_part: DescribedSurface
) -> None:
    assert (template.cut_distance == NO_CUT).all()
    depth, border = open_part.cut_distance, open_part.mesh.boundary_vertices
    assert depth[border].max() < 1e-3
    assert 0.2 < depth.max() < 1.0
    sheet, _ = template.mesh.submesh(np.arange(template.mesh.face_count) > 0)
    opened = DescribedSurface(WorkingSurface(sheet, sheet, None)).cut_distance
    assert np.isfinite(opened).all()
