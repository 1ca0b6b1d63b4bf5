"""What the labeling of one direction says of the other: images, inverse labels, what comes back."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.correspondence.labels.anchors import turned_by_guides
from sherd.correspondence.labels.labeling import NOWHERE_COST, Labeling, Problem

__all__ = ["closing_nodes", "following", "inverse_labeling", "inverse_labels"]

# So many nodes of the other shape say where a node lies; further ones lie two spacings away.
INVERSE = 4
# A node and the four nearest nodes of the other shape's there are as far apart here, up to the
# spacing of labels at both ends and a quarter for stretch (as for pairs of nodes, twice sigma).
CLOSES, CLOSES_STRETCH = 0.05, 0.25
# Nodes lie 0.05 apart, so where images cover a shape one lies within this of each of its nodes.
COVERED = 0.08


def inverse_labels(problem: Problem, other: Labeling) -> Ints:
    """Labels (k, INVERSE) of each node where the other direction says: nearest first."""
    near, _ = _nearest_images(problem, other)
    full = problem.question.full
    labels: Ints = full.dense.cells[full.sparse.vertices][near]
    return labels


def inverse_labeling(problem: Problem, other: Labeling) -> Labeling:
    """Where the other direction alone says that the nodes are; nowhere if it says nothing.

    The labeling of a direction that follows the other, whatever it would have found by itself. Its
    rotations are those that neighbors agree on.
    """
    near, reach = _nearest_images(problem, other)
    full = problem.question.full
    labels = full.dense.cells[full.sparse.vertices[near[:, 0]]]
    placed = other.placed[near[:, 0]] & (reach[:, 0] < COVERED)
    rotations = problem.turns[np.arange(len(labels)), labels]
    local = np.where(placed, 0.0, NOWHERE_COST)
    start = Labeling(labels, rotations, local, np.inf, placed)
    return turned_by_guides(problem, start)


def following(
    problems: tuple[Problem, Problem], kept: tuple[Labeling, Labeling]
) -> tuple[Labeling, Labeling]:
    """Where one direction keeps nothing it follows the other one again in the next round.

    A piece finds its place on a larger one, of which it lacks the most; the larger one hears of
    that and still lays what it shares on a twin, with which it agrees as well as with itself.
    """
    forward, backward = kept
    if forward.placed.any() == backward.placed.any():
        return kept
    if forward.placed.any():
        return forward, inverse_labeling(problems[1], forward)
    return inverse_labeling(problems[0], backward), backward


def closing_nodes(problem: Problem, own: Labeling, other: Labeling) -> Bools:
    """Nodes (k,) that are placed and that the other direction brings back.

    Nodes of the full shape near the label of a node have their images as near to the node.
    """
    full, part = problem.question.full, problem.question.part
    there = full.dense.distances[own.labels][:, full.sparse.vertices]  # (k, nodes of full)
    there = np.where(other.placed[None, :], there, np.inf)
    near = np.argsort(there, axis=1, kind="stable")[:, :INVERSE]
    length = np.take_along_axis(there, near, axis=1)
    known = np.isfinite(length)
    back = part.dense.distances[other.labels[near], problem.nodes.vertices[:, None]]
    off = np.abs(np.where(known, back, np.inf) - np.where(known, length, 0.0))
    close = off <= CLOSES + CLOSES_STRETCH * np.where(known, length, 0.0)
    # two of four, so that a single neighbor that went wrong does not decide
    agrees: Bools = own.placed & (close.sum(axis=1) >= INVERSE // 2)
    return agrees


def _nearest_images(problem: Problem, other: Labeling) -> tuple[Ints, Floats]:
    """The placed nodes (k, INVERSE) of the full shape whose images lie nearest to each node."""
    part = problem.question.part
    reach = part.dense.distances[other.labels][:, problem.nodes.vertices].T
    if other.placed.any():
        reach = np.where(other.placed[None, :], reach, np.inf)
    near = np.argsort(reach, axis=1, kind="stable")[:, :INVERSE]
    return near, np.take_along_axis(reach, near, axis=1).astype(np.float64)
