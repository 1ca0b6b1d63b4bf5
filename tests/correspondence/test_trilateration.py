"""Trilateration: with exact distances to the labels every vertex is itself."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from sherd.arrays import Ints
from sherd.correspondence.labels.labeling import SAME_SCALE, Labeling
from sherd.correspondence.question import Question
from sherd.correspondence.trilateration import trilaterated_vertices
from sherd.surface.described import DescribedSurface
from sherd.surface.samples import Samples


def asked(full: DescribedSurface, labels: Ints) -> Question:
    """The full shape on itself, its nodes exactly on the given labels."""
    dense = full.dense
    pairs = np.ix_(labels, labels)
    nodes = Samples.of(dense.vertices[labels], dense.distances[labels], dense.directions[pairs])
    part = SimpleNamespace(mesh=full.mesh, sparse=nodes)
    return Question(full, part, SAME_SCALE)


def labeling(labels: Ints) -> Labeling:
    count = len(labels)
    return Labeling(labels, np.zeros(count), np.zeros(count), 0.0)


def test_every_vertex_is_itself(full) -> None:
    labels = np.arange(0, len(full.dense), 6)
    found = trilaterated_vertices(asked(full, labels), labeling(labels))
    np.testing.assert_array_equal(found, np.arange(full.mesh.vertex_count))


def test_a_node_that_disagrees_with_its_neighbors_is_not_asked(full) -> None:
    labels = np.arange(0, len(full.dense), 6)
    question = asked(full, labels)
    honest = labeling(labels)
    wrong = labels.copy()
    cost = np.zeros(len(labels))
    liars = np.arange(0, len(labels), 5)
    wrong[liars] = np.roll(labels, 40)[liars]
    cost[liars] = 3.0
    found = trilaterated_vertices(question, Labeling(wrong, honest.rotations, cost, 0.0))
    np.testing.assert_array_equal(found, np.arange(full.mesh.vertex_count))


def test_when_too_few_nodes_agree_all_are_asked(full) -> None:
    """Five would leave most vertices without an anchor nearby."""
    labels = np.arange(0, len(full.dense), 6)
    cost = np.where(np.arange(len(labels)) < 5, 0.0, 9.0)
    poor = Labeling(labels, np.zeros(len(labels)), cost, 0.0)
    found = trilaterated_vertices(asked(full, labels), poor)
    np.testing.assert_array_equal(found, np.arange(full.mesh.vertex_count))


def test_a_component_without_a_reliable_node_asks_its_own(full) -> None:
    """Two copies of the blob as a part; all nodes of the second one are unreliable."""
    labels = np.arange(0, len(full.dense), 6)
    question = asked(full, labels)
    one, count = question.part.sparse, full.mesh.vertex_count
    nowhere = np.full_like(one.distances, np.inf)
    distances = np.block([[one.distances, nowhere], [nowhere, one.distances]])
    vertices = np.concatenate([one.vertices, one.vertices + count])
    twice = Samples.of(vertices, distances, np.zeros((len(vertices),) * 2, dtype=np.float32))
    part = SimpleNamespace(mesh=None, sparse=twice)
    both = np.concatenate([labels, labels])
    cost = np.where(np.arange(len(both)) < len(labels), 0.0, 9.0)
    found = trilaterated_vertices(
        Question(full, part, SAME_SCALE),
        Labeling(both, np.zeros(len(both)), cost, 0.0),
    )
    np.testing.assert_array_equal(found, np.tile(np.arange(count), 2))
