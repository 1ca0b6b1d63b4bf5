"""What is shared ends where either shape does: elsewhere something is missing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from sherd.correspondence.labels.consistent import missing_area, node_areas
from sherd.correspondence.labels.labeling import (
    LIMIT,
    LOCAL_LENGTH,
    SIMILARITY_STEP,
    Labeling,
    Problem,
    labeling_problem,
    solve,
    unary_cost,
)
from sherd.correspondence.question import Question

SHIFTS = 16
# Two spacings of nodes.
AROUND = 0.1


def problem_of(question: Question) -> Problem:
    """Every node looks like every label: what is asked here is not who is who."""
    shape = (len(question.part.sparse), len(question.full.dense), SHIFTS)
    alike = np.full(shape, 0.5, dtype=np.float32)
    return labeling_problem(question, alike, np.random.default_rng(0))


@pytest.fixture(scope="module")
def there(planted) -> Problem:
    return problem_of(planted.question)


@pytest.fixture(scope="module")
def back(planted) -> Problem:
    """The blob, asked about a piece of it."""
    question = planted.question
    return problem_of(Question(question.part, question.full, question.comparison))


@pytest.fixture(scope="module")
def truth(planted) -> Labeling:
    return Labeling(planted.labels, planted.rotations, np.zeros(len(planted.labels)), 0.0)


@pytest.fixture(scope="module")
def truth_back(planted, back) -> Labeling:
    """The nodes of the blob that lie on the piece, at the label nearest to them."""
    full, part = planted.question.full, planted.question.part
    here = full.mesh.vertices[full.sparse.vertices]
    on_piece = np.isin(full.sparse.vertices, planted.kept)
    labels = cKDTree(full.mesh.vertices[planted.kept[part.dense.vertices]]).query(here)[1]
    return Labeling(labels, np.zeros(len(here)), np.zeros(len(here)), 0.0, on_piece)


def test_nothing_is_missing_where_the_whole_of_a_piece_is_found(there, truth) -> None:
    assert missing_area(there, truth) == 0.0


def test_nothing_is_missing_beyond_the_cut_of_the_other_shape(back, truth_back) -> None:
    areas = node_areas(back)
    assert areas[~truth_back.placed].sum() > 0.2
    # nodes at the cut, whose labels lie within a spacing of theirs
    assert missing_area(back, truth_back) < 0.03


def test_a_hole_where_both_shapes_go_on_is_missing(back, truth_back) -> None:
    depth = np.where(truth_back.placed, back.label_depth[truth_back.labels], 0.0)
    hole = truth_back.placed & (back.nodes.between[depth.argmax()] < AROUND)
    assert hole.sum() > 5
    spared = replace(truth_back, placed=truth_back.placed & ~hole)
    more = missing_area(back, spared) - missing_area(back, truth_back)
    areas = node_areas(back)
    assert more == pytest.approx(areas[hole].sum())


def test_where_nothing_is_kept_nothing_is_missing(there, truth) -> None:
    nothing = replace(truth, placed=np.zeros(len(truth.labels), dtype=bool))
    assert missing_area(there, nothing) == 0.0


def test_a_node_goes_nowhere_at_a_cut_rather_than_inside(planted, there) -> None:
    """One node is dearer than its price and its boundary: kept only where that costs more."""
    node = int(there.node_depth.argmax())
    at = (there.edges == node).any(axis=1) & (there.measures.length < LOCAL_LENGTH)
    boundary = float(there.measures.weight[at].sum())
    similarity = there.similarity.copy()
    other = int(there.labels.between[planted.labels[node]].argmax())
    similarity[node, other] = 1.5  # so its own label lacks 1
    labels, rotations = planted.labels[:, None], planted.rotations[:, None]
    unlike = replace(there, similarity=similarity)
    cost = unary_cost(unlike, labels, rotations, SIMILARITY_STEP)[node, 0]
    price = cost - 1.25 * boundary
    assert price > 0
    for inside, placed in ((1.0, False), (LIMIT, True)):
        found = solve(unlike.priced(price, inside=inside), labels, rotations)
        assert found.placed[node] == placed


def test_a_price_shares_what_was_computed(there) -> None:
    priced = there.priced(2.0, inside=LIMIT)
    assert (priced.price, priced.inside) == (2.0, LIMIT)
    assert priced.peaks is there.peaks
    assert priced.turns is there.turns
