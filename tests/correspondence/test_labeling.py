"""Labels and rotations that were planted come back, though distractors look as similar."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sherd.arrays import Singles
from sherd.correspondence.labels.anchors import find_anchors, first_labeling, grown
from sherd.correspondence.labels.labeling import (
    SIMILARITY_STEP,
    UNARY_WEIGHT,
    Labeling,
    Problem,
    labeling_problem,
    solve,
    unary_cost,
)

SHIFTS = 16
DISTRACTORS = 10


def planted_similarity(planted, rng: np.random.Generator, *, lying: float = 0.0) -> Singles:
    """High at the true label and rotation, and at ten others; of a share `lying` at others only."""
    nodes, labels = len(planted.labels), len(planted.question.full.dense)
    similarity = rng.uniform(0.0, 0.4, (nodes, labels, SHIFTS))
    grid = 2 * np.pi * np.arange(SHIFTS) / SHIFTS
    honest = np.flatnonzero(rng.permutation(nodes) >= lying * nodes)
    true = grid - planted.rotations[honest, None]
    similarity[honest, planted.labels[honest]] = 0.5 + 0.35 * np.cos(true)
    for node in range(nodes):
        others = np.setdiff1d(np.arange(labels), planted.labels[node])
        others = rng.choice(others, DISTRACTORS, replace=False)
        turns = rng.uniform(0, 2 * np.pi, DISTRACTORS)
        similarity[node, others] = 0.5 + 0.35 * np.cos(grid - turns[:, None])
    return similarity.astype(np.float32)


def problem_of(planted, *, lying: float = 0.0, draw: int = 1) -> Problem:
    similarity = planted_similarity(planted, np.random.default_rng(draw), lying=lying)
    return labeling_problem(planted.question, similarity, np.random.default_rng(draw + 1))


def gaps(planted, labeling: Labeling) -> tuple[np.ndarray, np.ndarray]:
    """(k,) distance from the true label, and from the true rotation in radians."""
    apart = planted.question.full.dense.between[labeling.labels, planted.labels]
    turn = np.abs(np.angle(np.exp(1j * (labeling.rotations - planted.rotations))))
    return apart, turn


def test_a_planted_labeling_comes_back(planted) -> None:
    labeling = find_anchors(problem_of(planted))
    apart, turn = gaps(planted, labeling)
    assert (apart == 0).all()
    assert turn.max() < 0.2
    assert labeling.local_cost.max() < 0.5


def test_a_planted_labeling_comes_back_where_a_quarter_lies(planted) -> None:
    """Of 210 nodes one may be left beside its place: where all its neighbors lie, it has no say."""
    right, wrong = [], []
    for draw in range(1, 6):
        labeling = find_anchors(problem_of(planted, lying=0.25, draw=draw))
        apart, turn = gaps(planted, labeling)
        right.append((apart == 0).mean())
        wrong.append(((apart >= 0.04) | (turn >= 0.2) | (labeling.local_cost >= 0.5)).sum())
        assert apart.max() < 0.06  # the second next label, though the blob is two long
    assert min(right) >= 0.97
    assert np.mean(right) >= 0.99
    assert max(wrong) <= 2
    assert np.mean(wrong) <= 1


def test_rotations_are_read_between_the_grid_of_sixteen(planted) -> None:
    """Before neighbors have a say: similarity's peak is at the vertex of a parabola."""
    labeling = find_anchors(problem_of(planted), rounds=1)
    apart, turn = gaps(planted, labeling)
    assert turn[apart == 0].max() < 0.01  # the grid is 0.39 wide
    assert (apart == 0).mean() > 0.95


def test_of_wrong_labels_most_similar_ones_only_neighbors_tell(planted) -> None:
    """Where a quarter of the nodes lie, similarity alone is wrong for at least as many."""
    problem = problem_of(planted, lying=0.25)
    alone = problem.similarity.max(axis=2).argmax(axis=1)
    assert (alone != planted.labels).mean() > 0.25
    labels = np.stack([alone, planted.labels], axis=1)
    rotations = np.tile(planted.rotations[:, None], (1, 2))
    labeling = solve(problem, labels, rotations, step=SIMILARITY_STEP)
    assert (labeling.labels == planted.labels).mean() > 0.97


def test_labels_grow_from_those_that_are_kept(planted) -> None:
    """A quarter of the nodes, around the first, is kept; the others lose labels and rotations."""
    problem = problem_of(planted, lying=0.25)
    rng = np.random.default_rng(3)
    count = len(planted.labels)
    kept = problem.nodes.between[0] < np.quantile(problem.nodes.between[0], 0.25)
    labels = np.where(kept, planted.labels, rng.integers(len(problem.labels), size=count))
    rotations = np.where(kept, planted.rotations, 0.0)
    start = Labeling(labels, rotations, np.zeros(count), np.inf)
    found = grown(problem, start, kept)
    apart, turn = gaps(planted, found)
    assert (apart == 0).mean() > 0.95
    assert turn.max() < 0.3
    assert grown(problem, start, np.ones(count, dtype=bool)) is start
    assert grown(problem, start, np.zeros(count, dtype=bool)) is start


def test_lack_of_similarity_costs_by_the_step_and_forbidden_labels_cost_most(planted) -> None:
    problem = problem_of(planted)
    labels = planted.labels[:, None]
    best = problem.similarity.max(axis=(1, 2))
    deep = problem.node_depth > 0.1
    on_grid = np.round(planted.rotations / (2 * np.pi) * SHIFTS).astype(int) % SHIFTS
    here = problem.similarity[np.arange(len(labels)), planted.labels, on_grid]
    rotations = (on_grid / SHIFTS * 2 * np.pi)[:, None]
    lack = (best - here) / 0.1
    cost = unary_cost(problem, labels, rotations, 0.1)[:, 0]
    np.testing.assert_allclose(
        cost[deep], (UNARY_WEIGHT * lack / (1 + lack / 3.0))[deep], rtol=1e-4, atol=1e-4
    )
    assert (cost[~deep] <= UNARY_WEIGHT * (lack / (1 + lack / 3.0))[~deep] + 1e-4).all()
    problem.forbidden[0, labels[0, 0]] = True
    assert unary_cost(problem, labels, rotations, 0.1)[0, 0] == 1e3


def test_nodes_that_look_as_others_do_share_what_was_computed(planted) -> None:
    problem = problem_of(planted)
    problem.forbidden[3, 7] = True
    order = np.random.default_rng(5).permutation(len(problem.nodes))
    mixed = problem.mixed(order)
    apart = replace(
        problem, similarity=problem.similarity[order], forbidden=problem.forbidden[order]
    )
    assert mixed.similarity is problem.similarity
    one, other = first_labeling(mixed), first_labeling(apart)
    assert one.energy == other.energy > first_labeling(problem).energy
    np.testing.assert_array_equal(one.labels, other.labels)
    np.testing.assert_array_equal(mixed.mixed(order).peaks, apart.peaks[order])
    np.testing.assert_array_equal(grown_again(mixed, one), grown_again(apart, other))


def grown_again(problem: Problem, labeling: Labeling) -> np.ndarray:
    kept = np.zeros(len(problem.nodes), dtype=bool)
    kept[:50] = True
    return grown(problem, labeling, kept).labels
