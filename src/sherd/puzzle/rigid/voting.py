"""Motions of a rigid piece that many neighborhoods agree on.

Where two neighborhoods are alike, and by which turn about the normal, says a whole rotation and
shift, if nothing bends. So each node with each label that looks like it proposes one, and all other
nodes vote: how many come to lie near one of the labels that look like them? What is broken, not
bent, needs no more: a quarter of right labels is enough, as wrong ones agree on nothing.

References
----------
Tombari, Di Stefano, *Object recognition in 3D scenes with occlusions and clutter by Hough voting*,
2010: each match of two neighborhoods with local frames votes for a pose. Here motions are counted
by the matches that agree with them, so no space of poses is cut into bins.
"""

from __future__ import annotations

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.correspondence.labels.labeling import Problem
from sherd.puzzle.rigid.motion import RigidMotion, best_motion, extent

__all__ = ["voted_motions"]

# Of 1,200 labels; of seven sherds of a vase, whose neighborhoods are much alike, six are found with
# 30, and all with 60.
ALIKE = 60
# Labels lie 0.03 apart, and turns are known to 11 degrees, which is 0.04 at 0.2 from a node.
NEAR = 0.05
# Motions that move nodes apart by less than this, on average, are one: fits bring them together.
SAME = 0.06
# Or by less than half of the piece's extent: a small one that is turned by more than 30 degrees in
# its place moves by about that, and fits do not turn it back.
TURNED = 0.5
# A motion is fitted to the labels that agree with it, as far as these, in turn.
FITTED = (0.06, 0.04, 0.03, 0.02)
# How far proposals move apart is seen by so many nodes.
WITNESSES = 16


def voted_motions(problem: Problem, count: int) -> list[RigidMotion]:
    """The `count` different motions with most votes at most, from the part's frame to the full's.

    Parameters
    ----------
    problem
        Nodes, labels, and how alike they are.
    count
        So many, the one with most votes first.
    """
    question = problem.question
    nodes = question.part.mesh.vertices[problem.nodes.vertices]
    places = question.full.mesh.vertices[problem.labels.vertices]
    labels = problem.most_similar(min(ALIKE, len(places)))
    rotations, shifts = _proposed(problem, nodes, places, labels)
    votes = _votes(rotations, shifts, nodes, places[labels])
    chosen = _different(rotations, shifts, votes, nodes[problem.nodes.farthest_first], count)
    return [_agreed(RigidMotion(rotations[k], shifts[k]), nodes, places[labels]) for k in chosen]


def _proposed(
    problem: Problem, nodes: Floats, places: Floats, labels: Ints
) -> tuple[Floats, Floats]:
    """Rotations (h, 3, 3) and shifts (h, 3) that bring each node onto each of its labels (k, a)."""
    question = problem.question
    turns = -np.take_along_axis(problem.turns, labels, axis=1)
    cosines, sines = np.cos(turns), np.sin(turns)
    about = np.zeros((*labels.shape, 3, 3))
    about[..., 0, 0], about[..., 0, 1] = cosines, -sines
    about[..., 1, 0], about[..., 1, 1] = sines, cosines
    about[..., 2, 2] = 1.0
    own = _frames(*question.part.frames(problem.nodes.vertices))
    there = _frames(*question.full.frames(problem.labels.vertices))
    rotations = there[labels] @ about @ np.swapaxes(own, 1, 2)[:, None]
    shifts = places[labels] - np.einsum("kaij,kj->kai", rotations, nodes)
    return rotations.reshape(-1, 3, 3), shifts.reshape(-1, 3)


def _frames(axes: Floats, normals: Floats) -> Floats:
    """(q, 3, 3) with the tangent axis, the other one and the normal as columns."""
    return np.stack([axes, np.cross(normals, axes), normals], axis=-1)


def _votes(rotations: Floats, shifts: Floats, nodes: Floats, alike: Floats) -> Floats:
    """How many nodes (k, 3) each motion brings near one of the places (k, a, 3) alike to them."""
    found = np.zeros(len(rotations))
    turns, away = rotations.astype(np.float32), shifts.astype(np.float32)
    for node, places in zip(nodes.astype(np.float32), alike.astype(np.float32), strict=True):
        here = turns @ node + away
        # |x - y|^2 by a product of matrices; rounding is a thousandth of what is near
        least = ((places**2).sum(axis=1) - 2 * here @ places.T).min(axis=1)
        found += np.exp(-0.5 * (least + (here**2).sum(axis=1)) / NEAR**2)
    return found


def _different(
    rotations: Floats, shifts: Floats, votes: Floats, nodes: Floats, count: int
) -> list[int]:
    """The motions with most votes, none of which is another one."""
    moved = nodes[:WITNESSES] @ np.swapaxes(rotations, 1, 2) + shifts[:, None]
    same = min(SAME, TURNED * extent(nodes))
    left = np.ones(len(votes), dtype=bool)
    found: list[int] = []
    for k in np.argsort(-votes, kind="stable").tolist():
        if left[k]:
            found.append(k)
            left &= np.linalg.norm(moved - moved[k], axis=2).mean(axis=1) >= same
        if len(found) == count:
            break
    return found


def _agreed(motion: RigidMotion, nodes: Floats, alike: Floats) -> RigidMotion:
    """The motion fitted to the labels, of those alike to each node, that agree with it."""
    rows = np.arange(len(nodes))
    for reach in FITTED:
        apart = ((motion(nodes)[:, None] - alike) ** 2).sum(axis=-1)
        nearest = apart.argmin(axis=1)
        weights = np.exp(-0.5 * apart[rows, nearest] / reach**2)
        motion = best_motion(nodes, alike[rows, nearest], weights)
    return motion
