"""Joint labeling: every node of the part gets a label of the full shape and a tangent rotation.

Cost of a labeling = sum over nodes of (lack of similarity) + sum over edges of (disagreement of
geodesic length and of geodesic direction). Lengths count as equal where the path on the part
cannot have met the cut, that is `d(i, j) <= b_i + b_j` with b the distance to the cut (Bracha,
Dages, Kimmel, *Wormhole loss for partial shape matching*, 2024, use the same criterion);
elsewhere the full shape may have a shorter path, not shorter than b_i + b_j and not longer
than the part's. Directions are compared in the tangent frames, which rules mirrored answers out.
Components of the part are tied by straight lines, taken as lower bounds of the lengths on the full
shape, and as a hint of them.

Where the full shape may lack what the part has, a node may be placed nowhere, at the price of the
problem; each edge between a placed node and one placed nowhere then costs its weight, the length
of boundary that it crosses, and edges between two such nodes nothing. It may cost more where the
full shape goes on: where the label is farther from its cut than the edge is long.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from sherd.arrays import Bools, Floats, Ints, Singles
from sherd.correspondence.labels.forbidden import forbidden_labels
from sherd.correspondence.labels.labeling_data import (
    Comparison,
    EdgeMeasures,
    FullGeometry,
    PartGeometry,
)
from sherd.correspondence.labels.message_passing_kernel import labeling_costs, pass_messages
from sherd.correspondence.labels.node_pairs import (
    HEAT_ERROR,
    LENGTH_HALF,
    compared_pairs,
    edge_measures,
)
from sherd.correspondence.labels.peak_kernel import most_alike, rotation_peaks
from sherd.correspondence.question import Question
from sherd.surface.samples import Labels, Samples
from sherd.threads import cached_property

__all__ = [
    "SAME_SCALE",
    "UNKNOWN_SCALE",
    "Labeling",
    "Problem",
    "labeling_problem",
    "pair_costs",
    "solve",
    "unary_cost",
]


# A length may be off by half the spacing of labels at both ends, and by a tenth through stretch.
LENGTH_SIGMA, STRETCH_SIGMA = 0.02, 0.1
# Beyond two sigma a pair says "wrong" and not more.
LIMIT = 4.0
# Skin that touches skin is joined by a scanner, and by any surface through points, so paths on the
# part may be shortcuts: one sigma beyond the part's length a longer one says no more.
LONGER_LIMIT = 1.0
# Between components of the part no geodesic is known, but the straight line is not longer than the
# one on the full shape, and on animals and people three geodesics in four are not longer than
# 1.35 straight lines (limbs that touch make the others, so beyond one sigma a length says no more).
DETOUR, DETOUR_LIMIT, BRIDGE_WEIGHT = 1.35, 1.0, 1.0
# Directions: 16 rotations are 22 degrees apart, and geodesics bend.
ANGLE_SIGMA = float(np.radians(30.0))
SAME_SCALE = Comparison(LENGTH_SIGMA, STRETCH_SIGMA, LIMIT, LONGER_LIMIT, ANGLE_SIGMA)
# Where the scale is unknown, all lengths may be too short by some percent, and longer ones must
# count as much as shorter ones: they tell left from right.
UNKNOWN_SCALE = SAME_SCALE._replace(longer_limit=LIMIT)
# A similarity 0.1 below the best is one unit of cost; three units say "unlike" and not more.
SIMILARITY_STEP, SIMILARITY_LIMIT = 0.1, 3.0
# One node's similarity weighs as much as its dozen weighted edges.
UNARY_WEIGHT = 8.0
# Close to the cut a neighborhood says less: down to 0.4 within the middle radius.
CUT_TRUST, CUT_LEAST = 0.06, 0.4
ROUNDS = 8
# A node is judged by its edges up to two of the largest neighborhoods and a half.
LOCAL_LENGTH = 0.25
# A boundary is crossed by edges to near neighbors; longer ones only say that it lies between.
FAR_BOUNDARY = 0.1
# The local cost of what is placed nowhere: more than any that is placed has.
NOWHERE_COST = 2.0 * LIMIT + LONGER_LIMIT


@dataclass(frozen=True, eq=False)
class Problem:
    """A labeling problem.

    Attributes
    ----------
    question
        The two shapes.
    similarity
        (k, s, r) float32 similarity of node and label at each of r rotations.
    edges, measures
        (e, 2) pairs of nodes that are compared, and what is known of them.
    forbidden
        (k, s) bool, labels that a hint rules out.
    price
        What it costs to place a node nowhere; infinite if all must be placed.
    inside
        How many times its weight an edge to nowhere costs where the full shape goes on.
    order
        (k,) the row of `similarity` that each node has; its own if None.
    """

    question: Question
    similarity: Singles
    edges: Ints
    measures: EdgeMeasures
    forbidden: Bools
    price: float = np.inf
    inside: float = 1.0
    order: Ints | None = None

    def priced(self, price: float, *, inside: float = 1.0) -> Problem:
        """The same problem with nowhere among the labels; what was computed of it is shared."""
        return self._of_same_peaks(replace(self, price=price, inside=inside))

    def forbidding(self, more: Bools) -> Problem:
        """The same problem with `more` labels (k, s) forbidden; what was computed is shared."""
        return self._of_same_peaks(replace(self, forbidden=self.forbidden | more))

    def _of_same_peaks(self, problem: Problem) -> Problem:
        problem.__dict__["_peaks"] = self._peaks  # where cached properties are kept
        return problem

    def mixed(self, order: Ints) -> Problem:
        """The same problem where each node looks as another does, (k,) a permutation."""
        problem = replace(self, forbidden=self.forbidden[order], order=self._rows(order))
        problem.__dict__["_peaks"] = (self.peaks[order], self.turns[order])
        return problem

    def alike(self, nodes: Ints, labels: Ints, shifts: Ints) -> Singles:
        """Similarity of nodes and labels at rotations, all of one shape or broadcast to it."""
        found: Singles = self.similarity[self._rows(nodes), labels, shifts]
        return found

    def _rows(self, nodes: Ints) -> Ints:
        return nodes if self.order is None else self.order[nodes]

    @cached_property
    def nodes(self) -> Samples:
        """The part's samples, which get labels."""
        return self.question.part.sparse

    @cached_property
    def labels(self) -> Labels:
        """Where nodes may lie on the full shape."""
        return self.question.labels

    @property
    def peaks(self) -> Singles:
        """(k, s) similarity of node and label at the best rotation."""
        return self._peaks[0]

    @property
    def turns(self) -> Floats:
        """(k, s) rotation of most similarity, in radians."""
        return self._peaks[1]

    @cached_property
    def _peaks(self) -> tuple[Singles, Floats]:
        return rotation_peaks(self.similarity)

    def most_similar(self, count: int) -> Ints:
        """(k, count) labels that are not forbidden, most similar first, then the others."""
        return most_alike(self.peaks, self.forbidden, count)

    @cached_property
    def node_depth(self) -> Floats:
        """(k,) distance of each node to the cut."""
        depth: Floats = self.question.part.cut_distance[self.nodes.vertices]
        return depth

    @cached_property
    def label_depth(self) -> Floats:
        """(s,) distance of each label to the cut of the full shape; infinite if it has none."""
        depth: Floats = self.question.full.cut_distance[self.labels.vertices]
        return depth

    @cached_property
    def part_geometry(self) -> PartGeometry:
        """Distances and directions between the nodes, for kernels."""
        return PartGeometry(self.nodes.between, self.nodes.directions)

    @cached_property
    def full_geometry(self) -> FullGeometry:
        """Distances and directions between the labels, for kernels."""
        labels = self.labels
        between = labels.between.astype(np.float32, copy=False)  # or loops are compiled once more
        return FullGeometry(between, labels.directions, labels.leaving, labels.arriving)


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
    placed
        (k,) bool, False where a node is placed nowhere; its label is then the best guess.
    """

    labels: Ints
    rotations: Floats
    local_cost: Floats
    energy: float
    placed: Bools = field(default_factory=lambda: np.ones(0, dtype=bool))

    def __post_init__(self) -> None:
        if len(self.placed) != len(self.labels):
            object.__setattr__(self, "placed", np.ones(len(self.labels), dtype=bool))


def labeling_problem(question: Question, similarity: Singles, rng: np.random.Generator) -> Problem:
    """Choose the edges and their weights; labels that contradict the pins are forbidden."""
    part = question.part
    nodes, depth = part.sparse, part.cut_distance[part.sparse.vertices]
    edges = compared_pairs(nodes, part.mesh.vertices[nodes.vertices], rng)
    measures = edge_measures(edges, nodes, depth)
    return Problem(question, similarity, edges, measures, forbidden_labels(question))


def unary_cost(problem: Problem, labels: Ints, rotations: Floats, step: float) -> Floats:
    """Cost (k, c) of candidates (k, c): how much less similar than the best of the node."""
    shifts = problem.similarity.shape[2]
    place = (rotations / (2 * np.pi) * shifts) % shifts
    below = np.floor(place).astype(np.int64)
    share = place - below
    rows = np.arange(len(labels))[:, None]
    value = (1 - share) * problem.alike(rows, labels, below % shifts)
    value += share * problem.alike(rows, labels, (below + 1) % shifts)
    lack = np.maximum(problem.peaks.max(axis=1)[:, None] - value, 0.0) / step
    cost = lack / (1.0 + lack / SIMILARITY_LIMIT)
    trust = np.clip(problem.node_depth / CUT_TRUST, CUT_LEAST, 1.0)
    cost *= UNARY_WEIGHT * trust[:, None]
    result: Floats = np.where(problem.forbidden[rows, labels], 1e3, cost)
    return result


def solve(
    problem: Problem, labels: Ints, rotations: Floats, *, step: float = SIMILARITY_STEP
) -> Labeling:
    """Choose one of the candidates (k, c) of each node so that the total cost is low."""
    edges, costs = problem.edges, pair_costs(problem, labels, rotations)
    unary = unary_cost(problem, labels, rotations, step).astype(np.float32)
    count = len(problem.nodes)
    ends = edges.T.ravel()
    order = np.argsort(ends, kind="stable")
    incident = np.tile(np.arange(len(edges)), 2)[order]
    pointers = np.searchsorted(ends[order], np.arange(count + 1))
    placed = np.ones(count, dtype=bool)
    if np.isfinite(problem.price):
        open_costs, open_unary = _with_nowhere(problem, labels, costs, unary)
        chosen, energy = pass_messages(edges, open_costs, open_unary, pointers, incident, ROUNDS)
        placed = chosen < labels.shape[1]
        chosen = _best_guesses(chosen, edges, costs, unary, placed)
    else:
        chosen, energy = pass_messages(edges, costs, unary, pointers, incident, ROUNDS)
    rows = np.arange(count)
    paid = costs[np.arange(len(edges)), chosen[edges[:, 0]], chosen[edges[:, 1]]]
    both: Bools = np.all(placed[edges], axis=1)
    local = np.where(placed, _local_cost(problem, paid, both), NOWHERE_COST)
    return Labeling(labels[rows, chosen], rotations[rows, chosen], local, energy / count, placed)


def pair_costs(problem: Problem, labels: Ints, rotations: Floats) -> Singles:
    """Cost (e, c, c) of each pair of candidates (k, c) on each edge."""
    edges, angles = problem.edges, problem.nodes.directions
    pairs = np.stack([angles[edges[:, 0], edges[:, 1]], angles[edges[:, 1], edges[:, 0]]], axis=1)
    costs = labeling_costs(
        edges,
        problem.measures,
        labels,
        rotations.astype(np.float32),
        pairs,
        problem.full_geometry,
        problem.question.comparison,
    )
    bridges = np.flatnonzero(~np.isfinite(problem.measures.length))
    costs[bridges] = _bridge_costs(problem, bridges, labels)
    return costs


def _with_nowhere(
    problem: Problem, labels: Ints, costs: Singles, unary: Singles
) -> tuple[Singles, Singles]:
    """Costs (e, c + 1, c + 1) and (k, c + 1) with one candidate more: nowhere."""
    measures, count = problem.measures, unary.shape[1]
    weight = np.where(np.isfinite(measures.length), measures.weight, 0.0)
    weight *= np.where(measures.length < LOCAL_LENGTH, 1.0, FAR_BOUNDARY)
    wider = np.zeros((len(costs), count + 1, count + 1), dtype=np.float32)
    wider[:, :count, :count] = costs
    for end, side in enumerate((wider[:, :count, count], wider[:, count, :count])):
        goes_on = problem.label_depth[labels[problem.edges[:, end]]] > measures.length[:, None]
        side[:] = weight[:, None] * np.where(goes_on, problem.inside, 1.0)
    price = np.full((len(unary), 1), problem.price, dtype=np.float32)
    return wider, np.concatenate([unary, price], axis=1)


def _best_guesses(chosen: Ints, edges: Ints, costs: Singles, unary: Singles, placed: Bools) -> Ints:
    """The candidates (k,), for nodes placed nowhere the one that suits their placed neighbors."""
    total = unary.astype(np.float64)
    for here, there, turned in ((0, 1, False), (1, 0, True)):
        rows = np.flatnonzero(~placed[edges[:, here]] & placed[edges[:, there]])
        at = chosen[edges[rows, there]]
        table = costs[rows, at, :] if turned else costs[rows, :, at]
        np.add.at(total, edges[rows, here], table)
    guesses: Ints = np.where(placed, chosen, total.argmin(axis=1))
    return guesses


def _bridge_costs(problem: Problem, bridges: Ints, labels: Ints) -> Singles:
    """Cost (b, c, c) of each pair of candidates on edges between components."""
    first, second = problem.edges[bridges].T
    places = problem.question.part.mesh.vertices[problem.nodes.vertices]
    straight = np.linalg.norm(places[second] - places[first], axis=1)[:, None, None]
    table = problem.labels.between
    length = table[labels[first][:, :, None], labels[second][:, None, :]]
    sigma = LENGTH_SIGMA + STRETCH_SIGMA * straight
    short = (np.maximum((1 - HEAT_ERROR) * straight - length, 0.0) / sigma) ** 2
    # how far components of the full shape are from each other is not known either
    beyond = np.where(np.isfinite(length), length - DETOUR * straight, 0.0)
    long = (np.maximum(beyond, 0.0) / sigma) ** 2
    cost = short / (1 + short / LIMIT) + long / (1 + long / DETOUR_LIMIT)
    cost *= BRIDGE_WEIGHT / (1 + (straight / LENGTH_HALF) ** 2)
    result: Singles = cost.astype(np.float32)
    return result


def _local_cost(problem: Problem, paid: Floats, both: Bools) -> Floats:
    """Mean unweighted cost of the short edges at each node, of those (e,) placed at both ends."""
    count = len(problem.nodes)
    short = (problem.measures.length < LOCAL_LENGTH) & both
    cost = paid[short] / problem.measures.weight[short]
    ends = problem.edges[short].T
    total = sum(np.bincount(end, cost, minlength=count) for end in ends)
    number = sum(np.bincount(end, minlength=count) for end in ends)
    result: Floats = total / np.maximum(number, 1)
    return result
