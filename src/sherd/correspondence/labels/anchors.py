"""Anchors: the labeling found in rounds, its proposals, and growth from nodes to be trusted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from sherd.arrays import Bools, Floats, Ints
from sherd.correspondence.labels.guided_kernel import best_placed, guided_turns
from sherd.correspondence.labels.labeling import (
    CUT_TRUST,
    SIMILARITY_LIMIT,
    SIMILARITY_STEP,
    UNARY_WEIGHT,
    Labeling,
    Problem,
    solve,
)
from sherd.correspondence.labels.labeling_data import State

__all__ = [
    "ELSEWHERE",
    "candidates_again",
    "candidates_around",
    "chance_energy",
    "energy_ratio",
    "find_anchors",
    "first_labeling",
    "grown",
    "proposed_anchors",
    "turned_by_guides",
]


# The right label is among the 30 most similar of 1,200 for nine nodes in ten of real cuts.
CANDIDATES = 30
PROPOSALS = 8
ROUNDS = 3
# A node belongs to the core when over half of its near pairs agree.
CORE_SHARE = 0.5
CORE_REACH = 0.2
# Two labels this far apart, the largest neighborhood, are different places.
ELSEWHERE = 0.1
# If nearly all nodes are core there is nothing to grow.
GROWN_ENOUGH = 0.97
# Of nodes that already have a label so many say where a node is: twice what pins a place and a
# direction for one that is grown, more where single ones may be wrong, fewer for its rotation only.
GROWING_GUIDES, PROPOSING_GUIDES, TURNING_GUIDES = 10, 14, 8
# A guide at odds with its own neighbors, by so many units of mean cost, stands back behind those
# that are farther away by this much, three spacings of nodes.
ODD_COST, ODD_DISTANCE = 1.5, 0.15
# Two nodes of the core agree: in length within a label's spacing and the stretch of skin, and in
# both directions together within 50 degrees on average (cosines that add up to 0.8 or more).
CORE_LENGTH, CORE_STRETCH, CORE_COSINES = 0.03, 0.15, 0.8
# Among so many labels that suit the guides equally similarity decides; it weighs half as much as
# in the labeling, since guides are few.
LEADERS, LEADER_WEIGHT = 25, 0.5
# The labels around one: two rings.
AROUND = 16
# Four neighbors say where a node could be as well.
NEAR_LABELS = 4


def find_anchors(
    problem: Problem,
    *,
    step: float = SIMILARITY_STEP,
    rounds: int = ROUNDS,
    start: Labeling | None = None,
) -> Labeling:
    """Label the nodes: candidates by similarity, then proposals from neighbors, then growth.

    `step` is the lack of similarity that costs one unit, `start` the first labeling if it is known.
    """
    best = first_labeling(problem, step=step) if start is None else start
    best = proposed_anchors(problem, best, step=step, rounds=rounds)
    other = grown(problem, best, _core(problem, best), step=step)
    best = other if other.energy < best.energy else best
    other = grown(problem, best, _far_from_cut(problem), step=step)
    # Relabeling alone lowers the energy, but rather lets labels slide than finds better ones.
    moved = problem.labels.between[best.labels, other.labels].max()
    return other if other.energy < best.energy and moved > ELSEWHERE else best


def proposed_anchors(
    problem: Problem, start: Labeling, *, step: float = SIMILARITY_STEP, rounds: int = ROUNDS
) -> Labeling:
    """Label the nodes in all rounds but the first, without growth; see :func:`find_anchors`."""
    best = start
    for _ in range(rounds - 1):
        best = solve(problem, *candidates_again(problem, best), step=step)
    return best


def first_labeling(problem: Problem, *, step: float = SIMILARITY_STEP) -> Labeling:
    """The labeling with the most similar labels as candidates."""
    similar, turn = problem.most_similar(CANDIDATES), problem.turns
    return solve(problem, similar, _at(turn, similar), step=step)


def chance_energy(problem: Problem, rng: np.random.Generator) -> float:
    """Energy per node when every node has the similarities of another one: nothing belongs.

    This leaves shapes, cuts and likeness what they are and mixes up only what looks like what. Of
    one round, which is enough to compare with.
    """
    return first_labeling(problem.mixed(rng.permutation(len(problem.nodes)))).energy


def energy_ratio(problem: Problem, labeling: Labeling, rng: np.random.Generator) -> float:
    """Energy of a labeling over :func:`chance_energy`: near 1 where nothing belongs together."""
    return float(labeling.energy / max(chance_energy(problem, rng), 1e-12))


def candidates_again(
    problem: Problem, labeling: Labeling, *, also: Ints | None = None
) -> tuple[Ints, Floats]:
    """Candidates (k, c): where each node is, where its neighbors place it, and similar ones.

    `also` (k, a) are further labels, with the rotations of most similarity.
    """
    similar, turn = problem.most_similar(CANDIDATES), problem.turns
    near = np.argsort(problem.nodes.between, axis=1, kind="stable")[:, 1 : 1 + NEAR_LABELS]
    proposed, proposed_turns = _proposals(problem, labeling)
    from_near = labeling.labels[near]
    half = similar[:, : CANDIDATES // 2]
    by_turn = [from_near, half] if also is None else [also, from_near, half]
    labels = np.concatenate([labeling.labels[:, None], proposed, *by_turn], axis=1)
    turns = [_at(turn, each) for each in by_turn]
    return labels, np.concatenate([labeling.rotations[:, None], proposed_turns, *turns], axis=1)


def candidates_around(problem: Problem, labeling: Labeling, also: Ints) -> tuple[Ints, Floats]:
    """Candidates (k, c) by the placed nodes alone: where each is, or where its neighbors place it.

    And the labels of the nearest that are placed, and `also` (k, a). Where nodes that are placed
    nowhere lay before is not among them.
    """
    proposed, proposed_turns = _proposals(problem, labeling)
    placed = labeling.placed
    own = np.where(placed, labeling.labels, proposed[:, 0])
    own_turn = np.where(placed, labeling.rotations, proposed_turns[:, 0])
    reach = np.where(placed[None, :], problem.nodes.between, np.inf)
    np.fill_diagonal(reach, np.inf)
    near = np.argsort(reach, axis=1, kind="stable")[:, :NEAR_LABELS]
    further = np.concatenate([also, labeling.labels[near]], axis=1)
    labels = np.concatenate([own[:, None], proposed, further], axis=1)
    turns = [own_turn[:, None], proposed_turns, _at(problem.turns, further)]
    return labels, np.concatenate(turns, axis=1)


def grown(
    problem: Problem,
    labeling: Labeling,
    kept: Bools,
    *,
    step: float = SIMILARITY_STEP,
) -> Labeling:
    """Keep the labels of the nodes `kept` (k,), grow the rest outward from them, relabel locally.

    Returns `labeling` itself if nothing or nearly everything is kept.
    """
    if not kept.any() or kept.sum() > GROWN_ENOUGH * len(kept):
        return labeling
    labels, rotations, accepted = labeling.labels.copy(), labeling.rotations.copy(), kept.copy()
    between = problem.nodes.between
    while not accepted.all():
        inside = np.flatnonzero(accepted)
        gap = np.where(accepted, np.inf, between[:, inside].min(axis=1))
        node = int(gap.argmin())
        if not np.isfinite(gap[node]):
            break
        guides = inside[np.argsort(between[node, inside], kind="stable")[:GROWING_GUIDES]]
        state = State(labels, rotations)
        labels[node], rotations[node] = _best_from(problem, node, guides, state, step=step)
        accepted[node] = True
    result = Labeling(labels, rotations, np.zeros(len(labels)), np.inf)
    for _ in range(2):
        result = solve(problem, *_local_candidates(problem, result), step=step)
    return result


def turned_by_guides(problem: Problem, labeling: Labeling) -> Labeling:
    """The same labels with the rotations that the neighbors of each node agree on."""
    labels, nodes = labeling.labels, np.arange(len(labeling.labels))
    guides = _guides(problem, labeling, TURNING_GUIDES)
    part, full = problem.part_geometry, problem.full_geometry
    state = State(labels, labeling.rotations)
    turns = guided_turns(nodes, guides, labels[:, None], part, full, state)[:, 0]
    return replace(labeling, rotations=np.where(guides[:, 0] < 0, labeling.rotations, turns))


def _at(turn: Floats, labels: Ints) -> Floats:
    return np.take_along_axis(turn, labels, axis=1)


def _guides(problem: Problem, labeling: Labeling, count: int) -> Ints:
    """Nodes (k, count) near each node whose own neighborhoods agree; -1 where there are no more."""
    rank = problem.nodes.between + ODD_DISTANCE * (labeling.local_cost > ODD_COST)
    rank[:, ~labeling.placed] = np.inf
    np.fill_diagonal(rank, np.inf)
    order = np.argsort(rank, axis=1, kind="stable")[:, :count]
    guides: Ints = np.where(np.isfinite(np.take_along_axis(rank, order, axis=1)), order, -1)
    return guides


def _proposals(problem: Problem, labeling: Labeling) -> tuple[Ints, Floats]:
    """Labels (k, p) and rotations where the neighbors of each node place it."""
    nodes = np.arange(len(labeling.labels))
    guides = _guides(problem, labeling, PROPOSING_GUIDES)
    state = State(labeling.labels, labeling.rotations)
    part, full = problem.part_geometry, problem.full_geometry
    labels, _ = best_placed(
        nodes, guides, part, full, state, problem.question.comparison, PROPOSALS
    )
    rotations = guided_turns(nodes, guides, labels, part, full, state)
    alone = guides[:, 0] < 0
    labels[alone], rotations[alone] = labeling.labels[alone, None], labeling.rotations[alone, None]
    return labels, rotations


def _far_from_cut(problem: Problem) -> Bools:
    """Nodes whose neighborhoods the cut leaves whole, up to the middle radius.

    A shred along the cut looks like no place on the full shape and bends in its own plane at little
    cost, so it may lie folded aside, consistent with itself and with its stump. Grown from inside,
    it follows the directions of geodesics instead.
    """
    far: Bools = problem.node_depth >= CUT_TRUST
    return far


def _core(problem: Problem, labeling: Labeling) -> Bools:
    """Nodes of the largest component of mutually consistent nodes."""
    labels, rotations = labeling.labels, labeling.rotations
    between = problem.nodes.between
    distance = problem.labels.between[np.ix_(labels, labels)]
    turn = (
        problem.nodes.directions
        - problem.labels.directions[np.ix_(labels, labels)]
        - rotations[:, None]
    )
    agreement = np.cos(turn)
    near = (between < CORE_REACH) & (between > 0)
    length = np.where(near, between, 0.0)  # elsewhere both may be infinite
    agree = near & (np.abs(distance - length) < CORE_LENGTH + CORE_STRETCH * length)
    agree &= agreement + agreement.T > CORE_COSINES
    agree &= agree.T
    core = agree.sum(axis=1) > CORE_SHARE * np.maximum(near.sum(axis=1), 1)
    if not core.any():
        core[:] = True
    joined = sparse.csr_array(agree & core[:, None] & core[None, :])
    _, component = csgraph.connected_components(joined, directed=False)
    main = np.bincount(component[core]).argmax()
    result: Bools = core & (component == main)
    return result


def _best_from(
    problem: Problem, node: int, guides: Ints, state: State, *, step: float
) -> tuple[int, float]:
    """The label and rotation of one node by its guides, similarity deciding among the leaders."""
    nodes, rows = np.array([node]), guides[None, :]
    part, full = problem.part_geometry, problem.full_geometry
    at, misfit = best_placed(nodes, rows, part, full, state, problem.question.comparison, LEADERS)
    turn = guided_turns(nodes, rows, at, part, full, state)[0]
    shifts = problem.similarity.shape[2]
    shift = np.round(turn / (2 * np.pi) * shifts).astype(np.int64) % shifts
    lack = (problem.peaks[node].max() - problem.alike(nodes, at[0], shift)) / step
    cost = misfit[0] + LEADER_WEIGHT * UNARY_WEIGHT * lack / (1 + lack / SIMILARITY_LIMIT)
    best = int(cost.argmin())
    return int(at[0, best]), float(turn[best])


def _local_candidates(problem: Problem, labeling: Labeling) -> tuple[Ints, Floats]:
    """Where each node is, where its neighbors place it, and the labels around."""
    proposed, turns = _proposals(problem, labeling)
    around = np.argsort(problem.labels.between[labeling.labels], axis=1, kind="stable")
    around = np.ascontiguousarray(around[:, :AROUND])
    guides = _guides(problem, labeling, TURNING_GUIDES)
    state = State(labeling.labels, labeling.rotations)
    around_turns = guided_turns(
        np.arange(len(around)), guides, around, problem.part_geometry, problem.full_geometry, state
    )
    alone = guides[:, 0] < 0
    around_turns[alone] = labeling.rotations[alone, None]
    labels = np.concatenate([labeling.labels[:, None], proposed, around], axis=1)
    rotations = np.concatenate([labeling.rotations[:, None], turns, around_turns], axis=1)
    return labels, rotations
