"""Where its labeled neighbors place a node: on exact data at its own label, in its own frame."""

from __future__ import annotations

import numpy as np

from sherd.correspondence.labels.guided_kernel import best_placed, guided_turns
from sherd.correspondence.labels.labeling import SAME_SCALE
from sherd.correspondence.labels.labeling_data import FullGeometry, PartGeometry, State
from sherd.surface.counted import TURN

NODES, GUIDES = 150, 10


def exact_data(full) -> tuple[PartGeometry, FullGeometry, State]:
    """Nodes are labels in another order, each in a frame turned by an angle of its own."""
    rng = np.random.default_rng(0)
    labels = full.dense
    true = rng.permutation(len(labels))[:NODES]
    step = 2 * np.pi / TURN  # directions are compared in such steps
    rotations = step * rng.integers(0, TURN, NODES)
    pairs = np.ix_(true, true)
    rounded = (step * labels.leaving).astype(np.float32)
    directions = rounded[pairs].astype(np.float64) + rotations[:, None]
    part = PartGeometry(labels.between[pairs], directions)
    geometry = FullGeometry(labels.between, rounded, labels.leaving, labels.arriving)
    return part, geometry, State(true, rotations)


def nearest_guides(part: PartGeometry) -> np.ndarray:
    return np.argsort(part.between, axis=1, kind="stable")[:, 1 : 1 + GUIDES]


def test_a_node_is_placed_at_its_true_label_at_no_cost(full) -> None:
    part, shape, state = exact_data(full)
    labels, costs = best_placed(
        np.arange(NODES), nearest_guides(part), part, shape, state, SAME_SCALE, 4
    )
    np.testing.assert_array_equal(labels[:, 0], state.labels)
    assert costs[:, 0].max() < 1e-6
    assert (np.diff(costs, axis=1) >= 0).all()
    assert costs[:, 1].min() > 1e-3
    # the runners-up are around it
    assert np.median(shape.between[labels[:, 0], labels[:, 1]]) < 0.05


def test_its_rotation_is_the_known_one(full) -> None:
    part, shape, state = exact_data(full)
    nodes = np.arange(NODES)
    turns = guided_turns(nodes, nearest_guides(part), state.labels[:, None], part, shape, state)
    assert np.abs(np.angle(np.exp(1j * (turns[:, 0] - state.rotations)))).max() < 1e-5


def test_guides_may_be_few_unconnected_or_wrong(full) -> None:
    part, shape, state = exact_data(full)
    guides = nearest_guides(part)
    nodes = np.arange(NODES)
    short = guides.copy()
    short[:, 7:] = -1
    labels, _ = best_placed(nodes, short, part, shape, state, SAME_SCALE, 1)
    np.testing.assert_array_equal(labels[:, 0], state.labels)
    # neither the padding, which would mean the last node, nor what follows it is read
    lost = state.labels.copy()
    lost[[0, -1]] = (lost[[0, -1]] + 600) % len(full.dense)
    short[:, 8:] = 0
    nodes = np.flatnonzero(~np.isin(guides[:, :7], [0, NODES - 1]).any(axis=1))
    lies = State(lost, state.rotations)
    labels, costs = best_placed(nodes, short[nodes], part, shape, lies, SAME_SCALE, 1)
    np.testing.assert_array_equal(labels[:, 0], state.labels[nodes])
    assert costs.max() < 1e-6
    turns = guided_turns(nodes, short[nodes], labels, part, shape, lies)[:, 0]
    assert np.abs(np.angle(np.exp(1j * (turns - state.rotations[nodes])))).max() < 1e-5

    between = part.between.copy()
    between[0, guides[0, :3]] = np.inf
    apart = PartGeometry(between, part.directions)
    labels, costs = best_placed(np.array([0]), guides[:1], apart, shape, state, SAME_SCALE, 1)
    assert labels[0, 0] == state.labels[0]
    assert costs[0, 0] < 1e-6

    # two of ten guides at random labels: a robust cost outvotes them
    wrong = state.labels.copy()
    wrong[guides[5, :2]] = (wrong[guides[5, :2]] + 600) % len(full.dense)
    labels, costs = best_placed(
        nodes[5:6], guides[5:6], part, shape, State(wrong, state.rotations), SAME_SCALE, 1
    )
    assert labels[0, 0] == state.labels[5]
    assert costs[0, 0] > 0.5
