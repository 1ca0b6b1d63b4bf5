"""Groups of neighbors that agree with each other: what a labeling knows, whatever the rest says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sherd.correspondence.labels.anchors import candidates_around
from sherd.correspondence.labels.consistent import consistent_groups, node_areas
from sherd.correspondence.labels.labeling import Labeling, Problem, labeling_problem

SHIFTS = 16
# Wider than groups reach.
GAP = 0.15
# Labels lie about this far from each other.
CLOSE = 0.05
CHANCE = 20.0


@pytest.fixture(scope="module")
def problem(planted) -> Problem:
    """Every node looks like every label: what is asked here is who is where."""
    shape = (len(planted.labels), len(planted.question.full.dense), SHIFTS)
    alike = np.full(shape, 0.5, dtype=np.float32)
    return labeling_problem(planted.question, alike, np.random.default_rng(0))


@pytest.fixture(scope="module")
def truth(planted) -> Labeling:
    return Labeling(planted.labels, planted.rotations, np.zeros(len(planted.labels)), 0.0)


@pytest.fixture(scope="module")
def sides(planted) -> tuple[np.ndarray, np.ndarray]:
    """(k,) bool twice: the nodes around one of them, and those that lie well beyond."""
    part = planted.question.part
    height = part.mesh.vertices[part.sparse.vertices][:, 2]
    low = height < np.quantile(height, 0.3)
    return low, ~low & (part.sparse.between[:, low].min(axis=1) > GAP)


def test_right_labels_are_one_group(problem, truth) -> None:
    groups = consistent_groups(problem, truth, CHANCE)
    assert groups[0].mean() > 0.95


def test_two_patches_that_are_apart_are_two_groups(problem, truth, sides) -> None:
    low, high = sides
    groups = consistent_groups(problem, replace(truth, placed=low | high), CHANCE)
    larger, smaller = sorted(sides, key=lambda side: -node_areas(problem)[side].sum())
    assert (groups[0] & ~larger).sum() == 0
    assert groups[0].sum() > 0.9 * larger.sum()
    assert (groups[1] & ~smaller).sum() == 0
    assert groups[1].sum() > 0.9 * smaller.sum()


def test_a_patch_among_nodes_that_lie_anywhere_is_the_first_group(problem, truth, sides) -> None:
    low, _ = sides
    anywhere = np.random.default_rng(1).permutation(truth.labels)
    labels = np.where(low, truth.labels, anywhere)
    groups = consistent_groups(problem, replace(truth, labels=labels), CHANCE)
    assert groups[0][low].mean() > 0.9
    assert groups[0][~low].mean() < 0.1


def test_where_nothing_is_placed_there_is_no_group(problem, truth) -> None:
    nothing = replace(truth, placed=np.zeros(len(truth.labels), dtype=bool))
    assert consistent_groups(problem, nothing, CHANCE) == []


def test_what_grows_from_a_group_forgets_where_the_rest_lay(problem, truth, sides) -> None:
    low, _ = sides
    between = problem.labels.between
    wrong = between[truth.labels].argmax(axis=1)  # as far from the truth as can be
    labeling = replace(truth, labels=np.where(low, truth.labels, wrong), placed=low)
    nothing_else = np.repeat(truth.labels[np.flatnonzero(low)[0]], len(low))[:, None]
    labels, rotations = candidates_around(problem, labeling, nothing_else)
    assert labels.shape == rotations.shape
    assert (labels[low, 0] == truth.labels[low]).all()
    # those beside the group are brought to their places by it
    near = ~low & (problem.nodes.between[:, low].min(axis=1) < GAP / 2)
    assert not (labels[near] == wrong[near, None]).any()
    off = between[labels[near], truth.labels[near, None]].min(axis=1)
    assert np.median(off) < CLOSE
