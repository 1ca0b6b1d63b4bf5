"""Compiled message passing: a label for each node, given pair costs.

Kernels on plain arrays; :mod:`sherd.correspondence.labels.labeling` says what the costs mean.
"""

from __future__ import annotations

import math

import numpy as np

from sherd.arrays import Ints, Singles
from sherd.compiled import compiled
from sherd.correspondence.labels.labeling_data import (
    Comparison,
    EdgeMeasures,
    FullGeometry,
    turn_costs,
)
from sherd.threads import over_rows

__all__ = ["labeling_costs", "pass_messages", "turn_steps"]


# Labels on other components are infinitely far; this far costs the limit as well.
FAR = np.float32(1e6)


@compiled(inline="always")
def _robust(squared, limit):
    """Geman-McClure: like `squared` near zero, never above `limit`."""
    return squared / (np.float32(1.0) + squared / limit)


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
    labels = np.ascontiguousarray(labels)  # another layout would be compiled for apart
    over_rows(
        _labeling_costs, len(edges), edges, measures, labels, rotations, directions, full,
        comparison, turn_costs(comparison), costs,
    )  # fmt: skip
    return costs


@compiled()
def _labeling_costs(  # noqa: PLR0913
    rows, edges, measures, labels, rotations, directions, full, comparison, turned, costs
):
    # what lies scattered in memory is gathered first: then the loops run in vector lanes
    count, steps = labels.shape[1], len(turned)
    off, fit = np.empty(count, np.float32), np.empty(count, np.float32)
    back = np.empty(count, np.int64)
    for edge in range(rows[0], rows[1]):
        first, second = edges[edge]
        length, lower = measures.length[edge], measures.lower[edge]
        turn = np.float32(measures.turn[edge])
        scale = np.float32(1.0 / (comparison.length_sigma + comparison.stretch_sigma * length))
        bound = np.float32((length - lower) * scale)
        weight = np.float32(measures.weight[edge])
        for b in range(count):
            back[b] = turn_steps(directions[edge, 1] - rotations[second, b], steps)
        for a in range(count):
            at = labels[first, a]
            for b in range(count):
                distance = full.between[at, labels[second, b]]
                off[b] = (min(distance, FAR) - np.float32(length)) * scale
            _length_costs(off, measures.equality[edge], bound, comparison, fit)
            if turn > 0.0:
                ahead = turn_steps(directions[edge, 0] - rotations[first, a], steps)
                for b in range(count):
                    to = labels[second, b]
                    there = turned[(full.leaving[at, to] - ahead) & (steps - 1)]
                    home = turned[(full.arriving[at, to] - back[b]) & (steps - 1)]
                    # at one and the same place there is no direction: wrong, but wrong once
                    fit[b] += turn * (np.float32(comparison.limit) if at == to else there + home)
            for b in range(count):
                costs[edge, a, b] = weight * fit[b]


@compiled(inline="always")
def turn_steps(angle, turn):
    """An angle in steps, of which a turn has so many, a power of two; by its last bits only."""
    return math.floor(angle * (turn / (2.0 * math.pi)) + 0.5)


@compiled()
def _length_costs(off, equality, bound, comparison, fit):
    """Write what lengths cost that are longer by `off` sigmas; `bound` below it they cost twice."""
    zero = np.float32(0.0)
    shorter, longer = np.float32(comparison.limit), np.float32(comparison.longer_limit)
    if equality >= 1.0:
        for b in range(len(off)):
            limit = longer if off[b] > zero else shorter
            fit[b] = _robust(off[b] * off[b], limit)
        return
    # a path along the cut may be longer than on the full shape, never shorter
    equal, rest = np.float32(equality), np.float32(1.0 - equality)
    for b in range(len(off)):
        limit = longer if off[b] > zero else shorter
        below = -bound - off[b]
        beyond = (off[b] if off[b] > zero else zero) + (below if below > zero else zero)
        fit[b] = equal * _robust(off[b] * off[b], limit) + rest * _robust(beyond * beyond, limit)


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
    forward = np.zeros((len(edges), count), np.float32)  # into the second node of an edge
    backward = np.zeros((len(edges), count), np.float32)  # into the first
    share = np.ones(nodes, np.float32)
    for node in range(nodes):
        later = 0
        for entry in range(pointers[node], pointers[node + 1]):
            later += 1 if edges[incident[entry], 0] == node else 0
        earlier = pointers[node + 1] - pointers[node] - later
        share[node] = 1.0 / max(later, earlier, 1)
    total, rest = np.empty(count, np.float32), np.empty(count, np.float32)
    for sweep in range(2 * rounds):
        ahead = sweep % 2 == 0
        for step in range(nodes):
            node = step if ahead else nodes - 1 - step
            _gather(node, edges, unary, pointers, incident, (forward, backward), total)
            for entry in range(pointers[node], pointers[node + 1]):
                edge = incident[entry]
                if ahead and edges[edge, 0] == node:
                    _remaining(total, share[node], backward[edge], rest)
                    _send(costs[edge], rest, forward[edge])
                elif not ahead and edges[edge, 1] == node:
                    _remaining(total, share[node], forward[edge], rest)
                    _send_back(costs[edge], rest, backward[edge])
    return _decode(edges, costs, unary, pointers, incident, backward)


@compiled()
def _gather(node, edges, unary, pointers, incident, messages, total):
    forward, backward = messages
    for a in range(len(total)):
        total[a] = unary[node, a]
    for entry in range(pointers[node], pointers[node + 1]):
        edge = incident[entry]
        message = backward[edge] if edges[edge, 0] == node else forward[edge]
        for a in range(len(total)):
            total[a] += message[a]


@compiled()
def _remaining(total, share, message, rest):
    for a in range(len(total)):
        rest[a] = share * total[a] - message[a]


@compiled()
def _send(cost, rest, message):
    """`message[b] = min over a of rest[a] + cost[a, b]`, shifted so that its minimum is 0."""
    count = len(message)
    for b in range(count):
        message[b] = rest[0] + cost[0, b]
    # four rows at a time: to read and write the message takes longer than to compare; and not
    # `min`, whose care for NaN keeps it out of vector lanes
    for a in range(1, count - 3, 4):
        p, q, r, s = cost[a], cost[a + 1], cost[a + 2], cost[a + 3]
        at_p, at_q, at_r, at_s = rest[a], rest[a + 1], rest[a + 2], rest[a + 3]
        for b in range(count):
            first, second = at_p + p[b], at_q + q[b]
            third, fourth = at_r + r[b], at_s + s[b]
            first = second if second < first else first
            third = fourth if fourth < third else third
            first = third if third < first else first
            message[b] = first if first < message[b] else message[b]
    for a in range(1 + 4 * ((count - 1) // 4), count):
        own = rest[a]
        for b in range(count):
            value = own + cost[a, b]
            message[b] = value if value < message[b] else message[b]
    _lower(message)


# no cost is NaN: told so, the compiler looks for the least of a row in vector lanes
@compiled(fastmath={"nnan", "nsz"})
def _send_back(cost, rest, message):
    """`message[a] = min over b of rest[b] + cost[a, b]`, shifted so that its minimum is 0."""
    for a in range(len(message)):
        row = cost[a]
        least = rest[0] + row[0]
        for b in range(1, len(rest)):
            value = rest[b] + row[b]
            least = value if value < least else least
        message[a] = least
    _lower(message)


@compiled()
def _lower(message):
    least = message[0]
    for b in range(len(message)):
        least = message[b] if message[b] < least else least
    for b in range(len(message)):
        message[b] -= least


@compiled()
def _decode(edges, costs, unary, pointers, incident, backward):
    nodes, count = unary.shape
    chosen = np.zeros(nodes, np.int64)
    total, fixed = np.empty(count, np.float32), np.empty(count, np.float32)
    energy = 0.0
    for node in range(nodes):
        for a in range(count):
            total[a] = fixed[a] = unary[node, a]
        for entry in range(pointers[node], pointers[node + 1]):
            edge = incident[entry]
            if edges[edge, 0] == node:
                for a in range(count):
                    total[a] += backward[edge, a]
            else:
                other = chosen[edges[edge, 0]]
                for a in range(count):
                    total[a] += costs[edge, other, a]
                    fixed[a] += costs[edge, other, a]
        best = 0
        for a in range(1, count):
            best = a if total[a] < total[best] else best
        chosen[node] = best
        energy += fixed[best]
    return chosen, energy
