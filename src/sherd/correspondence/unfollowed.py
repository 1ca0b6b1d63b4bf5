"""Landmarks that the answer does not follow, and those that cannot all be true."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Bools, Floats
from sherd.correspondence.labels.forbidden import PIN_SLACK, PIN_STRETCH
from sherd.correspondence.question import Pins, Question
from sherd.mesh.surface_points import SurfacePoints
from sherd.results.advice import UnfollowedLandmark

__all__ = ["contradictions", "culprits", "unfollowed_landmarks"]

# In sqrt(area of the full shape): what a right answer is promised to be within.
FOLLOWED = 0.05


def unfollowed_landmarks(
    question: Question, pins: Pins, points: SurfacePoints
) -> tuple[UnfollowedLandmark, ...]:
    """The landmarks that a user should look at again, farthest from the answer first.

    Parameters
    ----------
    question
        At the scale that was found.
    pins
        All landmarks, on vertices of the part itself.
    points
        The answer: a point of the full shape for each vertex of the part itself.
    """
    if len(pins.vertices) == 0:
        return ()
    full = question.full
    places = np.asarray(full.vertex_tree.query(pins.positions)[1])
    reach = full.geodesics.distances_from(places)
    answers = points[pins.vertices].positions(full.placed)
    nearest = np.asarray(full.vertex_tree.query(answers)[1])
    straight = np.linalg.norm(answers - pins.positions, axis=1)
    along = reach[np.arange(len(places)), nearest]
    # a path runs along vertices, so it is not told from a straight line over a few edges
    distance = np.where(np.isfinite(along) & (straight > FOLLOWED / 2), along, straight)
    gaps = np.linalg.norm(pins.positions[:, None] - pins.positions[None], axis=2)
    between = np.where(np.isfinite(reach[:, places]), reach[:, places], gaps)
    clash = contradictions(_between_on_part(question, pins), between)
    blamed = culprits(clash) | (distance > FOLLOWED)
    order = [int(k) for k in np.argsort(-distance, kind="stable") if blamed[k]]
    return tuple(
        UnfollowedLandmark(
            part_vertex=int(pins.landmarks[k, 0]),
            full_vertex=int(pins.landmarks[k, 1]),
            distance=float(distance[k]),
            contradicts=tuple(pins.landmarks[clash[k], 0].tolist()),
        )
        for k in order
    )


def contradictions(on_part: Floats, on_full: Floats) -> Bools:
    """Pairs (p, p) of landmarks that cannot both be true.

    A path on the part is a path on the full shape, so distances (p, p) on the full shape are not
    longer than on the part, up to stretch and the spacing of labels.
    """
    clash: Bools = on_full > PIN_SLACK + PIN_STRETCH * on_part
    return clash | clash.T


def culprits(clash: Bools) -> Bools:
    """The landmarks (p,) that contradict most others; without them no contradiction is left.

    Two that contradict only each other are both named: nobody knows which is wrong.
    """
    left, named = clash.copy(), np.zeros(len(clash), dtype=bool)
    while left.any():
        count = left.sum(axis=1)
        worst = count == count.max()
        named |= worst
        left[worst], left[:, worst] = False, False
    return named


def _between_on_part(question: Question, pins: Pins) -> Floats:
    """Geodesic distances (p, p) on the part between the landmarks, which are among its nodes."""
    nodes = question.part.sparse
    row_of = np.full(question.part.mesh.vertex_count, -1, dtype=np.int64)
    row_of[nodes.vertices] = np.arange(len(nodes))
    rows = row_of[question.part.working.working_vertices(pins.vertices)]
    return np.asarray(nodes.between[np.ix_(rows, rows)], dtype=np.float64)
