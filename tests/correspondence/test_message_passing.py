"""Labels by message passing: exact on trees, costs as written."""

from __future__ import annotations

import itertools

import numpy as np

from sherd.correspondence.labels.labeling_data import Comparison, EdgeMeasures, FullGeometry
from sherd.correspondence.labels.message_passing_kernel import labeling_costs, pass_messages
from sherd.surface.counted import TURN, steps_of


def incidence(edges: np.ndarray, nodes: int) -> tuple[np.ndarray, np.ndarray]:
    ends = edges.T.ravel()
    order = np.argsort(ends, kind="stable")
    incident = np.tile(np.arange(len(edges)), 2)[order]
    return np.searchsorted(ends[order], np.arange(nodes + 1)), incident


def full_geometry(distances: np.ndarray, directions: np.ndarray) -> FullGeometry:
    steps = steps_of(directions)
    return FullGeometry(distances, directions, steps, np.ascontiguousarray(steps.T))


def total(
    edges: np.ndarray, costs: np.ndarray, unary: np.ndarray, labels: tuple[int, ...]
) -> float:
    pair = sum(costs[e, labels[i], labels[j]] for e, (i, j) in enumerate(edges))
    return float(pair + sum(unary[i, label] for i, label in enumerate(labels)))


def test_a_tree_is_solved_exactly() -> None:
    rng = np.random.default_rng(4)
    edges = np.array([[0, 1], [1, 2], [1, 3], [0, 4]])
    for _ in range(20):
        costs = rng.random((4, 3, 3)).astype(np.float32)
        unary = rng.random((5, 3)).astype(np.float32)
        found, energy = pass_messages(edges, costs, unary, *incidence(edges, 5), 8)
        best = min(
            total(edges, costs, unary, labels) for labels in itertools.product(range(3), repeat=5)
        )
        assert np.isclose(energy, best, atol=1e-5)
        assert np.isclose(total(edges, costs, unary, tuple(found)), energy, atol=1e-5)


def test_loops_are_solved_better_than_node_by_node() -> None:
    rng = np.random.default_rng(5)
    edges = np.array(list(itertools.combinations(range(7), 2)))
    gaps = []
    for _ in range(10):
        costs = rng.random((len(edges), 3, 3)).astype(np.float32)
        unary = (2 * rng.random((7, 3))).astype(np.float32)
        _, energy = pass_messages(edges, costs, unary, *incidence(edges, 7), 8)
        every = [total(edges, costs, unary, x) for x in itertools.product(range(3), repeat=7)]
        alone = total(edges, costs, unary, tuple(unary.argmin(axis=1)))
        gaps.append((energy - min(every)) / (alone - min(every) + 1e-9))
    assert np.mean(gaps) < 0.35


def test_pair_costs_follow_the_formula() -> None:
    distances = np.array([[0.0, 0.3], [0.3, 0.0]], dtype=np.float32)
    directions = np.array([[0.0, 0.5], [-1.0, 0.0]], dtype=np.float32)
    edges = np.array([[0, 1]])
    labels = np.array([[0, 1], [1, 0]])
    rotations = np.array([[0.1, 0.0], [0.2, 0.0]], dtype=np.float32)
    pairs = np.array([[0.9, -0.4]], dtype=np.float32)
    measures = EdgeMeasures(*np.array([[0.2, 0.2, 1.0, 2.0, 0.5]]).T)
    costs = labeling_costs(
        edges,
        measures,
        labels,
        rotations,
        pairs,
        full_geometry(distances, directions),
        Comparison(0.02, 0.1, 4.0, 1.0, 0.5),
    )

    def robust(x: float, limit: float = 4.0) -> float:
        return x / (1 + x / limit)

    def rounded(angle: float) -> float:
        step = 2 * np.pi / TURN
        return float(step * np.rint(angle / step))

    off = ((0.3 - 0.2) / 0.04) ** 2
    out = (2 - 2 * np.cos(rounded(0.9 - 0.1) - rounded(0.5))) / 0.25
    back = (2 - 2 * np.cos(rounded(-0.4 - 0.2) + rounded(1.0))) / 0.25
    assert np.isclose(
        costs[0, 0, 0], 2.0 * (robust(off, 1.0) + 0.5 * (robust(out) + robust(back))), atol=1e-4
    )
    # the same label twice: the length is missed, and there is no direction
    assert np.isclose(costs[0, 0, 1], 2.0 * (robust((0.2 / 0.04) ** 2) + 0.5 * 4.0), atol=1e-4)


def test_paths_along_the_cut_may_shrink_on_the_full_shape_but_not_grow() -> None:
    distances = np.array([[0.0, 0.2, 0.4], [0.2, 0.0, 0.3], [0.4, 0.3, 0.0]], dtype=np.float32)
    labels = np.array([[0, 0], [1, 2]])
    none = np.zeros((2, 2), dtype=np.float32)
    measures = EdgeMeasures(
        *np.array([[0.3, 0.15, 0.0, 1.0, 0.0]]).T
    )  # between 0.15 and 0.3 nothing is paid
    costs = labeling_costs(
        np.array([[0, 1]]),
        measures,
        labels,
        none,
        none[:1],
        full_geometry(distances, np.zeros((3, 3), dtype=np.float32)),
        Comparison(0.02, 0.1, 4.0, 4.0, 0.5),
    )
    assert costs[0, 0, 0] == 0.0
    assert costs[0, 0, 1] > 1.0
