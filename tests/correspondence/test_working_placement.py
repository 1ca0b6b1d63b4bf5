"""From a labeling to points: a true labeling puts every vertex where it came from."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.correspondence import working_placement
from sherd.correspondence.labels.labeling import Labeling
from sherd.correspondence.working_placement import (
    WorkingPlacement,
    part_queries,
    placement_from_labeling,
    rough_placement_from_labeling,
)
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.surface.described import DescribedSurface
from sherd.surface.working import WorkingSurface


def placed(planted, labels: np.ndarray, *, rough: bool = False) -> WorkingPlacement:
    labeling = Labeling(labels, planted.rotations, np.zeros(len(labels)), 0.0)
    queries = part_queries(planted.question, np.random.default_rng(0))
    if rough:
        return rough_placement_from_labeling(planted.question, labeling, queries)
    return placement_from_labeling(planted.question, labeling, queries)


def errors(planted, found: WorkingPlacement) -> np.ndarray:
    mesh = planted.question.full.mesh
    return np.linalg.norm(found.points.positions(mesh) - mesh.vertices[planted.kept], axis=1)


@pytest.fixture(scope="module")
def true(planted) -> WorkingPlacement:
    return placed(planted, planted.labels)


def test_every_vertex_is_where_it_came_from(planted, true: WorkingPlacement) -> None:
    assert errors(planted, true).mean() < 0.001
    assert errors(planted, true).max() < 0.02
    assert true.score > 0.95
    assert np.median(true.similarity) > 0.98
    assert true.strain.mean() < 0.03


def test_the_region_is_that_of_the_piece(planted, true: WorkingPlacement) -> None:
    full, part = planted.question.full.mesh, planted.question.part.mesh
    expected = np.zeros(full.vertex_count, dtype=bool)
    expected[planted.kept] = True
    inner = expected.copy()
    inner[planted.kept[part.boundary_vertices]] = False
    assert true.mask[inner].mean() > 0.995
    assert not true.mask[~expected].any()


def test_one_look_is_rougher_but_near(planted, true: WorkingPlacement) -> None:
    rough = placed(planted, planted.labels, rough=True)
    assert errors(planted, true).mean() < errors(planted, rough).mean() < 0.005
    assert rough.score <= true.score + 1e-3


def test_the_second_slide_inside_the_region_brings_it_nearer(
    planted, true: WorkingPlacement, monkeypatch
) -> None:
    monkeypatch.setattr(working_placement, "SECOND_REACHES", ())
    once = placed(planted, planted.labels)
    assert errors(planted, true).mean() < 0.85 * errors(planted, once).mean()  # measured: 0.73


def test_the_wrong_place_scores_low(planted, true: WorkingPlacement) -> None:
    """Every node at the label opposite to its own: at that distance the blob is another."""
    labels = planted.question.full.dense
    places = planted.question.full.mesh.vertices[labels.vertices]
    turned = places[planted.labels] * [-1.0, -1.0, 1.0]
    wrong = np.linalg.norm(places - turned[:, None], axis=2).argmin(axis=1)
    found = placed(planted, wrong)
    assert errors(planted, found).mean() > 0.2
    assert found.score < true.score - 0.2


def test_large_parts_ask_at_some_vertices_and_never_at_those_without_a_face(
    planted, blob, monkeypatch
) -> None:
    loose = blob.vertices[blob.faces].mean(axis=1)
    count = blob.vertex_count
    mesh = TriangleMesh(np.concatenate([blob.vertices, loose]), blob.faces)
    surface = DescribedSurface(WorkingSurface(mesh, mesh, None))
    queries = part_queries(planted.question.with_part(surface), np.random.default_rng(0))
    assert queries.vertices.tolist() == list(range(count))
    monkeypatch.setattr(working_placement, "QUERY_COUNT", 500)
    few = part_queries(planted.question.with_part(surface), np.random.default_rng(0))
    assert len(few.vertices) == 500
    assert (np.diff(few.vertices) > 0).all()
    assert few.vertices.max() < count
    # single precision, summed in another order on some machines
    np.testing.assert_allclose(few.plain, queries.plain[:, few.vertices], rtol=0, atol=1e-6)
