"""Joint labeling: every node of the part gets a label of the full shape and a tangent rotation.

Cost of a labeling = sum over nodes of (lack of similarity) + sum over edges of (disagreement of
geodesic length and of geodesic direction). Lengths count as equal where the path on the part
cannot have met the cut, that is `d(i, j) <= b_i + b_j` with b the distance to the cut (Bracha,
Dages, Kimmel, *Wormhole loss for partial shape matching*, 2024, use the same criterion);
elsewhere the full shape may have a shorter path, not shorter than b_i + b_j and not longer
than the part's. Directions are compared in the tangent frames, which rules mirrored answers out.
Components of the part are tied by straight lines, taken as lower bounds of the lengths on the full
shape, and as a hint of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sherd.arrays import Bools, Floats, Ints, Singles
from sherd.correspondence.message_passing_kernel import labeling_costs, pass_messages
from sherd.correspondence.part_data import PartData
from sherd.template import Template

__all__ = ["Labeling", "Problem", "make_problem", "solve", "unary_cost"]


# Each node is tied to its near neighbors, which carry the shape, and to some farther away, which
# carry the layout; all pairs would be twenty times as many.
NEAR_NEIGHBORS, MIDDLE_NEIGHBORS, FAR_NEIGHBORS = 10, 6, 6
MIDDLE_REACH = 0.35
# A length may be off by half the spacing of labels at both ends, and by a tenth through stretch.
LENGTH_SIGMA, STRETCH_SIGMA = 0.02, 0.1
# Beyond two sigma a pair says "wrong" and not more.
LIMIT = 4.0
# Skin that touches skin is joined by a scanner, and by any surface through points, so paths on the
# part may be shortcuts: one sigma beyond the part's length a longer one says no more.
LONGER_LIMIT = 1.0
# Short lengths are more reliable and there are more far pairs than near ones.
LENGTH_HALF = 0.3
# Between components of the part no geodesic is known, but the straight line is not longer than the
# one on the full shape, and on animals and people three geodesics in four are not longer than
# 1.35 straight lines (limbs that touch make the others, so beyond one sigma a length says no more).
# Neighbors across the gap say what continues where; nodes at all distances, which limb is which.
BRIDGES_NEAR, BRIDGES_FAR = 4, 6
DETOUR, DETOUR_LIMIT, BRIDGE_WEIGHT = 1.35, 1.0, 1.0
# Directions: 16 rotations are 22 degrees apart, and geodesics bend; useless beyond a limb's length.
ANGLE_SIGMA = float(np.radians(30.0))
ANGLE_REACH = 0.3
ANGLE_WEIGHT = 0.5
# What compares lengths and directions gets these together. Where the scale is unknown, all lengths
# may be too short by some percent, and longer ones must count as much as shorter ones: they tell
# left from right.
SETTINGS = (LENGTH_SIGMA, STRETCH_SIGMA, LIMIT, LONGER_LIMIT, ANGLE_SIGMA)
EVEN_SETTINGS = (LENGTH_SIGMA, STRETCH_SIGMA, LIMIT, LIMIT, ANGLE_SIGMA)
# How fast the belief in equal length fades once the path may have met the cut.
CUT_FADE = 0.15
CUT_SHARE = 0.6
# A similarity 0.1 below the best is one unit of cost; three units say "unlike" and not more.
SIMILARITY_STEP, SIMILARITY_LIMIT = 0.1, 3.0
# One node's similarity weighs as much as its dozen weighted edges.
UNARY_WEIGHT = 8.0
# Close to the cut a neighborhood says less: down to 0.4 within the middle radius.
CUT_TRUST, CUT_LEAST = 0.06, 0.4
ROUNDS = 8
# A pinned vertex may move by the spacing of labels, and lengths from it stretch by a fifth.
PIN_SLACK, PIN_STRETCH = 0.04, 1.2


@dataclass(frozen=True, eq=False)
class Problem:
    """A labeling problem.

    Attributes
    ----------
    template, part
        The two shapes.
    similarity
        (k, s, r) float32 similarity of node and label at each of r rotations.
    edges, measures
        (e, 2) and (e, 5), see
        :func:`sherd.correspondence.message_passing_kernel.labeling_costs`; the length of an edge
        between components is infinite.
    forbidden
        (k, s) bool, labels that a hint rules out.
    settings
        How lengths and directions are compared, see the same.
    """

    template: Template
    part: PartData
    similarity: Singles
    edges: Ints
    measures: Floats
    forbidden: Bools
    settings: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Labeling:
    """A label and a rotation for each node.

    Attributes
    ----------
    labels, rotations
        (k,) label and rotation in radians of each node.
    local_cost
        (k,) mean cost of the short edges at each node, 0 is perfect, above 2 is poor.
    energy
        Total cost per node.
    """

    labels: Ints
    rotations: Floats
    local_cost: Floats
    energy: float


def make_problem(
    template: Template,
    part: PartData,
    similarity: Singles,
    rng: np.random.Generator,
    *,
    settings: tuple[float, ...] = SETTINGS,
) -> Problem:
    """Choose the edges and their weights; labels that contradict the pins are forbidden."""
    edges = _edges(part, rng)
    measures = _measures(edges, part)
    forbidden = _contradicting(template, part)
    return Problem(template, part, similarity, edges, measures, forbidden, settings)


def unary_cost(problem: Problem, labels: Ints, rotations: Floats, step: float) -> Floats:
    """Cost (k, c) of candidates (k, c): how much less similar than the best of the node."""
    similarity = problem.similarity
    shifts = similarity.shape[2]
    place = (rotations / (2 * np.pi) * shifts) % shifts
    below = np.floor(place).astype(np.int64)
    share = place - below
    rows = np.arange(len(labels))[:, None]
    value = (1 - share) * similarity[rows, labels, below % shifts]
    value += share * similarity[rows, labels, (below + 1) % shifts]
    lack = np.maximum(similarity.max(axis=(1, 2))[:, None] - value, 0.0) / step
    cost = lack / (1.0 + lack / SIMILARITY_LIMIT)
    trust = np.clip(problem.part.cut_distance[problem.part.nodes] / CUT_TRUST, CUT_LEAST, 1.0)
    cost *= UNARY_WEIGHT * trust[:, None]
    result: Floats = np.where(problem.forbidden[rows, labels], 1e3, cost)
    return result


def solve(problem: Problem, labels: Ints, rotations: Floats, *, step: float) -> Labeling:
    """Choose one of the candidates (k, c) of each node so that the total cost is low."""
    part, template, edges = problem.part, problem.template, problem.edges
    angles = part.directions
    pairs = np.stack([angles[edges[:, 0], edges[:, 1]], angles[edges[:, 1], edges[:, 0]]], axis=1)
    shape = (template.label_to_label, template.label_headings)
    turns = rotations.astype(np.float32)
    costs = labeling_costs(edges, problem.measures, labels, turns, pairs, shape, problem.settings)
    bridges = np.flatnonzero(~np.isfinite(problem.measures[:, 0]))
    costs[bridges] = _bridge_costs(problem, bridges, labels)
    unary = unary_cost(problem, labels, rotations, step).astype(np.float32)
    count = len(part.nodes)
    ends = edges.T.ravel()
    order = np.argsort(ends, kind="stable")
    incident = np.tile(np.arange(len(edges)), 2)[order]
    pointers = np.searchsorted(ends[order], np.arange(count + 1))
    chosen, energy = pass_messages(edges, costs, unary, pointers, incident, ROUNDS)
    rows = np.arange(count)
    paid = costs[np.arange(len(edges)), chosen[edges[:, 0]], chosen[edges[:, 1]]]
    local = _local_cost(problem, paid)
    return Labeling(labels[rows, chosen], rotations[rows, chosen], local, energy / count)


def _edges(part: PartData, rng: np.random.Generator) -> Ints:
    between = part.between
    count = len(between)
    tied = np.zeros((count, count), dtype=bool)
    for node in range(count):
        order = np.argsort(between[node], kind="stable")
        order = order[(order != node) & np.isfinite(between[node, order])]
        tied[node, order[:NEAR_NEIGHBORS]] = True
        rest = order[NEAR_NEIGHBORS:]
        close = between[node, rest] < MIDDLE_REACH
        for choice, limit in ((rest[close], MIDDLE_NEIGHBORS), (rest[~close], FAR_NEIGHBORS)):
            picked = rng.choice(choice, min(limit, len(choice)), replace=False)
            tied[node, picked.astype(np.int64)] = True
    tied |= _bridges(part)
    first, second = np.nonzero(np.triu(tied | tied.T, 1))
    return np.stack([first, second], axis=1)


def _bridges(part: PartData) -> Bools:
    """Pairs (k, k) of nodes in different components: the nearest, and some of all distances.

    Nodes of crumbs, which have few neighbors in their own component, take more of the nearest.
    """
    tied = ~np.isfinite(part.between)
    places = part.mesh.vertices[part.nodes]
    for node in np.flatnonzero(tied.any(axis=1)):
        others = np.flatnonzero(tied[node])
        straight = np.linalg.norm(places[others] - places[node], axis=1)
        order = others[np.argsort(straight, kind="stable")]
        own = len(places) - len(others) - 1
        near = BRIDGES_NEAR + max(NEAR_NEIGHBORS - own, 0)
        rest = order[near:]
        far = rest[np.linspace(0, len(rest) - 1, min(BRIDGES_FAR, len(rest))).astype(int)]
        tied[node] = False
        tied[node, order[:near]] = True
        tied[node, far] = True
    return tied


def _measures(edges: Ints, part: PartData) -> Floats:
    cut = part.cut_distance[part.nodes]
    length = part.between[edges[:, 0], edges[:, 1]]
    safe = cut[edges[:, 0]] + cut[edges[:, 1]]
    lower = 0.95 * np.minimum(length, safe)
    clear = length <= 1.05 * safe  # the heat method is right to a few percent
    fade = np.exp(-np.maximum(length - safe, 0.0) / CUT_FADE)
    equality = np.where(clear, 1.0, CUT_SHARE * fade * (length < 0.4))
    weight = 1.0 / (1.0 + (length / LENGTH_HALF) ** 2)
    turn = ANGLE_WEIGHT * (length < ANGLE_REACH) * np.where(clear, 1.0, fade)
    return np.stack([length, lower, equality, weight, turn], axis=1)


def _bridge_costs(problem: Problem, bridges: Ints, labels: Ints) -> Singles:
    """Cost (b, c, c) of each pair of candidates on edges between components."""
    first, second = problem.edges[bridges].T
    places = problem.part.mesh.vertices[problem.part.nodes]
    straight = np.linalg.norm(places[second] - places[first], axis=1)[:, None, None]
    table = problem.template.label_to_label
    length = table[labels[first][:, :, None], labels[second][:, None, :]]
    sigma = LENGTH_SIGMA + STRETCH_SIGMA * straight
    short = (np.maximum(0.95 * straight - length, 0.0) / sigma) ** 2
    # how far components of the full shape are from each other is not known either
    beyond = np.where(np.isfinite(length), length - DETOUR * straight, 0.0)
    long = (np.maximum(beyond, 0.0) / sigma) ** 2
    cost = short / (1 + short / LIMIT) + long / (1 + long / DETOUR_LIMIT)
    cost *= BRIDGE_WEIGHT / (1 + (straight / LENGTH_HALF) ** 2)
    result: Singles = cost.astype(np.float32)
    return result


def _local_cost(problem: Problem, paid: Floats) -> Floats:
    """Mean unweighted cost of the edges shorter than 0.25 at each node."""
    count = len(problem.part.nodes)
    short = problem.measures[:, 0] < 0.25
    cost = paid[short] / problem.measures[short, 3]
    ends = problem.edges[short].T
    total = sum(np.bincount(end, cost, minlength=count) for end in ends)
    number = sum(np.bincount(end, minlength=count) for end in ends)
    result: Floats = total / np.maximum(number, 1)
    return result


def _contradicting(template: Template, part: PartData) -> Bools:
    """Labels (k, s) farther from a pinned place than the node is from the pinned vertex.

    A path on the part is a path on the full shape, so distances on the full shape are not longer,
    up to stretch and the spacing of labels.
    """
    forbidden = np.zeros((len(part.nodes), len(template.label_vertices)), dtype=bool)
    if len(part.pin_vertices) == 0:
        return forbidden
    places = template.vertex_tree.query(part.pin_positions)[1]
    reach = template.geodesics.distances_from(places)[:, template.label_vertices]
    for vertex, row in zip(part.pin_vertices, reach, strict=True):
        node = int(np.flatnonzero(part.nodes == vertex)[0])
        limit = PIN_SLACK + PIN_STRETCH * part.between[node]
        forbidden |= row[None, :] > limit[:, None]
    forbidden[forbidden.all(axis=1)] = False  # pins that contradict each other rule nothing out
    return forbidden
