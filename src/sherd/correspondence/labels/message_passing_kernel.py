"""Compiled message passing: a label for each node, given pair costs.

Kernels on plain arrays; :mod:`sherd.correspondence.labels.labeling` says what the costs mean.
"""

from __future__ import annotations

import math

import numpy as np

from sherd.arrays import Ints, Singles
from sherd.compiled import compiled
from sherd.correspondence.labels.labeling_data import Comparison, EdgeMeasures, FullGeometry
from sherd.threads import over_rows

__all__ = ["labeling_costs", "pass_messages"]


@compiled(inline="always")
def _robust(squared, limit):
    """Geman-McClure: like `squared` near zero, never above `limit`."""
    return squared / (1.0 + squared / limit)


def labeling_costs(
    edges: Ints,
    measures: EdgeMeasures,
    labels: Ints,
    rotations: Singles,
    directions: Singles,
    full: FullGeometry,
    comparison: Comparison,
) -> Singles:
    """Cost (e, k, k) float32 of each pair of labels on each edge.

    Parameters
    ----------
    edges
        (e, 2) nodes, first below second.
    measures
        Of the edges.
    labels, rotations
        (nodes, k) candidates of each node.
    directions
        (e, 2) angle on the part from first to second, and back.
    full
        Distances and directions between labels.
    comparison
        How lengths and directions are compared.
    """
    count = labels.shape[1]
    costs = np.empty((len(edges), count, count), dtype=np.float32)
    over_rows(
        _labeling_costs, len(edges), edges, measures, labels, rotations, directions, full,
        comparison, costs,
    )  # fmt: skip
    return costs


@compiled(nogil=True)
def _labeling_costs(  # noqa: PLR0913
    rows, edges, measures, labels, rotations, directions, full, comparison, costs
):
    distances, headings = full
    limit = comparison.limit
    factor = 1.0 / (comparison.angle_sigma * comparison.angle_sigma)
    count = labels.shape[1]
    for edge in range(rows[0], rows[1]):
        first, second = edges[edge]
        length, lower = measures.length[edge], measures.lower[edge]
        equality, weight = measures.equality[edge], measures.weight[edge]
        turn = measures.turn[edge]
        scale = 1.0 / (comparison.length_sigma + comparison.stretch_sigma * length)
        back_x = np.cos(directions[edge, 1] - rotations[second])
        back_y = np.sin(directions[edge, 1] - rotations[second])
        for a in range(count):
            at = labels[first, a]
            out = directions[edge, 0] - rotations[first, a]
            out_x, out_y = math.cos(out), math.sin(out)
            for b in range(count):
                to = labels[second, b]
                distance = distances[at, to]
                off = (distance - length) * scale
                length_limit = comparison.longer_limit if off > 0.0 else limit
                cost = _robust(off * off, length_limit)
                if equality < 1.0:
                    # a path along the cut may be longer than on the full shape, never shorter
                    beyond = max(off, 0.0) + max((lower - distance) * scale, 0.0)
                    bounded = _robust(beyond * beyond, length_limit)
                    cost = equality * cost + (1.0 - equality) * bounded
                if turn > 0.0:
                    if at == to:
                        cost += turn * limit
                    else:
                        u = out_x * headings[at, to, 0] + out_y * headings[at, to, 1]
                        v = back_x[b] * headings[to, at, 0] + back_y[b] * headings[to, at, 1]
                        u, v = 2.0 - 2.0 * u, 2.0 - 2.0 * v
                        cost += turn * (_robust(u * factor, limit) + _robust(v * factor, limit))
                costs[edge, a, b] = weight * cost


@compiled()
def pass_messages(edges, costs, unary, pointers, incident, rounds):
    """Labels (nodes,) of low total cost by tree-reweighted message passing, and the cost.

    `incident[pointers[i]:pointers[i + 1]]` are the edges at node i. Nodes are swept forward and
    backward `rounds` times; labels are then fixed in order, each given those before it.

    References
    ----------
    Kolmogorov, *Convergent tree-reweighted message passing for energy minimization*, 2006,
    figure 3 with monotonic chains.
    """
    nodes, count = unary.shape
    turned = costs.transpose(0, 2, 1).copy()  # rows are then read in order in both directions
    forward = np.zeros((len(edges), count), np.float32)  # into the second node of an edge
    backward = np.zeros((len(edges), count), np.float32)  # into the first
    share = np.ones(nodes, np.float32)
    for node in range(nodes):
        later = 0
        for entry in range(pointers[node], pointers[node + 1]):
            later += 1 if edges[incident[entry], 0] == node else 0
        earlier = pointers[node + 1] - pointers[node] - later
        share[node] = 1.0 / max(later, earlier, 1)
    total = np.empty(count, np.float32)
    for sweep in range(2 * rounds):
        ahead = sweep % 2 == 0
        for step in range(nodes):
            node = step if ahead else nodes - 1 - step
            _gather(node, edges, unary, pointers, incident, (forward, backward), total)
            for entry in range(pointers[node], pointers[node + 1]):
                edge = incident[entry]
                if ahead and edges[edge, 0] == node:
                    _send(costs[edge], share[node] * total - backward[edge], forward[edge])
                elif not ahead and edges[edge, 1] == node:
                    _send(turned[edge], share[node] * total - forward[edge], backward[edge])
    return _decode(edges, costs, unary, pointers, incident, backward)


@compiled()
def _gather(node, edges, unary, pointers, incident, messages, total):
    forward, backward = messages
    total[:] = unary[node]
    for entry in range(pointers[node], pointers[node + 1]):
        edge = incident[entry]
        if edges[edge, 0] == node:
            total += backward[edge]
        else:
            total += forward[edge]


@compiled()
def _send(cost, rest, message):
    """`message[b] = min over a of rest[a] + cost[a, b]`, shifted so that its minimum is 0."""
    message[:] = np.inf
    for a in range(cost.shape[0]):
        for b in range(cost.shape[1]):
            message[b] = min(message[b], rest[a] + cost[a, b])
    message -= message.min()


@compiled()
def _decode(edges, costs, unary, pointers, incident, backward):
    nodes = len(unary)
    chosen = np.zeros(nodes, np.int64)
    energy = 0.0
    for node in range(nodes):
        total = unary[node].copy()
        fixed = unary[node].copy()
        for entry in range(pointers[node], pointers[node + 1]):
            edge = incident[entry]
            if edges[edge, 0] == node:
                total += backward[edge]
            else:
                total += costs[edge, chosen[edges[edge, 0]]]
                fixed += costs[edge, chosen[edges[edge, 0]]]
        chosen[node] = np.argmin(total)
        energy += fixed[chosen[node]]
    return chosen, energy
