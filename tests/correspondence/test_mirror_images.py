"""Mirror images of both shapes have the same answers as the shapes themselves."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.correspondence.labels.anchors import find_anchors
from sherd.correspondence.labels.labeling import SAME_SCALE, Labeling
from sherd.correspondence.placements import anchor_problem, mirrored_placement
from sherd.correspondence.question import Question
from sherd.correspondence.working_placement import (
    Queries,
    mirrored_queries,
    part_queries,
    placement_from_labeling,
)
from sherd.surface.transformed import mirrored


@pytest.fixture(scope="module")
def image(planted) -> Question:
    return Question(mirrored(planted.question.full), mirrored(planted.question.part), SAME_SCALE)


@pytest.fixture(scope="module")
def labelings(planted, image) -> tuple[Labeling, Labeling]:
    here = find_anchors(anchor_problem(planted.question, np.random.default_rng(0)))
    return here, find_anchors(anchor_problem(image, np.random.default_rng(0)))


@pytest.fixture(scope="module")
def queries(planted) -> Queries:
    return part_queries(planted.question, np.random.default_rng(0))


def test_labels_of_mirror_images_are_the_same(planted, image, labelings) -> None:
    here, there = labelings
    np.testing.assert_array_equal(image.full.dense.vertices, planted.question.full.dense.vertices)
    assert (here.labels == there.labels).mean() > 0.99
    turn = np.angle(np.exp(1j * (here.rotations + there.rotations)))
    assert np.median(np.abs(turn)) < 1e-4  # counted the other way around
    assert there.energy == pytest.approx(here.energy, rel=1e-4)
    assert (here.labels == planted.labels).mean() > 0.99


def test_placements_of_mirror_images_are_mirror_images(planted, image, labelings, queries) -> None:
    question = planted.question
    here = placement_from_labeling(question, labelings[0], queries)
    there = placement_from_labeling(image, labelings[1], mirrored_queries(queries))
    places = here.points.positions(question.full.mesh)
    gap = places * [-1, 1, 1] - there.points.positions(image.full.mesh)
    assert np.linalg.norm(gap, axis=1).mean() < 1e-4
    assert there.score == pytest.approx(here.score, abs=1e-4)
    assert (here.mask == there.mask).mean() > 0.999


def test_the_twin_of_a_mirror_image_is_the_shape_itself(planted, image, queries) -> None:
    """A blob without symmetry has no twin, but the image of a piece has: the piece."""
    question, rng = planted.question, np.random.default_rng
    twin = mirrored_placement(question, queries, rng(0))
    assert twin.score < 0.8
    mixed = question.with_part(image.part)
    itself = mirrored_placement(mixed, mirrored_queries(queries), rng(0))
    assert itself.score > 0.95
    gap = itself.points.positions(question.full.mesh) - question.full.mesh.vertices[planted.kept]
    assert np.linalg.norm(gap, axis=1).mean() < 0.003
