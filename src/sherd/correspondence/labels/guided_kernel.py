"""Compiled: where the labeled neighbors of a node, its guides, place it.

Kernels on plain arrays; :mod:`sherd.correspondence.labels.labeling` says what labels and
rotations mean. Guides are an array (k, g), padded with -1; the other arguments are those of
:mod:`sherd.correspondence.labels.labeling_data`.
"""

from __future__ import annotations

import math

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.compiled import compiled
from sherd.correspondence.labels.labeling_data import (
    Comparison,
    FullGeometry,
    PartGeometry,
    State,
    turn_costs,
)
from sherd.correspondence.labels.message_passing_kernel import turn_steps
from sherd.threads import over_rows

__all__ = ["best_placed", "guided_turns"]


# Geodesics longer than a limb's width say little about one point.
GUIDE_LENGTH = 0.15
# Farther than anything, and its square is still a number.
FAR = np.float32(1e6)


def best_placed(
    nodes: Ints,
    guides: Ints,
    part: PartGeometry,
    full: FullGeometry,
    state: State,
    comparison: Comparison,
    count: int,
) -> tuple[Ints, Floats]:
    """Labels (k, count) that agree best with the guides of `nodes` (k,), and their costs.

    Equal costs are in the order of the labels.
    """
    labels, costs = np.empty((len(nodes), count), dtype=np.int64), np.empty((len(nodes), count))
    over_rows(
        _best_placed, len(nodes), nodes, guides, part, full, state, comparison,
        turn_costs(comparison), labels, costs,
    )  # fmt: skip
    return labels, costs


def guided_turns(
    nodes: Ints, guides: Ints, at: Ints, part: PartGeometry, full: FullGeometry, state: State
) -> Floats:
    """Rotation (k, c) of each of `nodes` (k,) at labels `at` (k, c) that its guides agree on."""
    turns = np.empty(at.shape)
    over_rows(_guided_turns, len(nodes), nodes, guides, at, part, full, state, turns)
    return turns


@compiled()
def _best_placed(  # noqa: PLR0913
    rows, nodes, guides, part, full, state, comparison, turned, labels, costs
):
    for row in range(rows[0], rows[1]):
        misfit = np.empty(full.between.shape[0], np.float32)
        _misfits(nodes[row], guides[row], part, full, state, comparison, turned, misfit)
        for rank in range(labels.shape[1]):
            best = np.argmin(misfit)
            labels[row, rank], costs[row, rank] = best, misfit[best]
            misfit[best] = np.inf


@compiled()
def _misfits(node, guides, part, full, state, comparison, turned, misfit):
    """Write the cost (s,) of every label for one node: length and direction from each guide."""
    between, directions = part
    labels, rotations = state
    one, zero, half = np.float32(1.0), np.float32(0.0), np.float32(0.5)
    shorter, longer = np.float32(comparison.limit), np.float32(comparison.longer_limit)
    misfit[:] = 0.0
    for guide in guides:
        if guide < 0:
            break
        length = np.float32(between[node, guide])
        if length == np.inf:
            continue
        near = np.float32(1.0 / (1.0 + (length / GUIDE_LENGTH) ** 2))
        scale = np.float32(1.0 / (comparison.length_sigma + comparison.stretch_sigma * length))
        distances, leaving = full.between[labels[guide]], full.leaving[labels[guide]]
        ahead = turn_steps(directions[guide, node] - rotations[guide], len(turned))
        for label in range(len(misfit)):
            # labels on other components are infinitely far
            distance = distances[label] if distances[label] < FAR else FAR
            off = (distance - length) * scale
            limit = longer if off > zero else shorter
            cost = off * off / (one + off * off / limit)
            cost += half * turned[(leaving[label] - ahead) & (len(turned) - 1)]
            misfit[label] += near * cost


@compiled()
def _guided_turns(rows, nodes, guides, at, part, full, state, turns):
    between, directions = part
    labels = state.labels
    for row in range(rows[0], rows[1]):
        node = nodes[row]
        for rank in range(at.shape[1]):
            here = at[row, rank]
            along, across = 0.0, 0.0
            for guide in guides[row]:
                if guide < 0:
                    break
                near = 1.0 / (1.0 + (between[node, guide] / GUIDE_LENGTH) ** 2)
                turn = directions[node, guide] - full.directions[here, labels[guide]]
                along += near * math.cos(turn)
                across += near * math.sin(turn)
            turns[row, rank] = math.atan2(across, along)
