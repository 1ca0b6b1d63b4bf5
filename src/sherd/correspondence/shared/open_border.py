"""How much of the border of what is shared lies inside both shapes, where it needs a reason."""

from __future__ import annotations

import math

import numpy as np

from sherd.arrays import Bools
from sherd.correspondence.question import Question
from sherd.correspondence.shared.region_cut import WIDTH, seam_lengths
from sherd.correspondence.shared.round_trip import RoundTrip

__all__ = ["MOST_OPEN", "open_seam", "other_goes_on"]

# The whole border of a square is four times the root of its area; half of it open says all.
MOST_OPEN = 2.0


def other_goes_on(question: Question, trip: RoundTrip) -> Bools:
    """Vertices (n,) whose places lie farther inside the other shape than a border is blurred."""
    full = question.full
    depth = trip.points.interpolate(full.mesh, full.cut_distance)
    inside: Bools = depth > 2 * WIDTH
    return inside


def open_seam(question: Question, trip: RoundTrip, shared: Bools) -> float:
    """How much of the border of what is shared lies where neither shape ends, at most `MOST_OPEN`.

    Its length over the root of the shared area. Both shapes are cut from something whole, so what
    they share ends where either ends; a place that is wrong, or of which much is left out, ends
    anywhere. Nothing shared is as open as can be.

    Parameters
    ----------
    question, trip
        The part on the other shape, there and back.
    shared
        (n,) vertices of the part's working mesh.
    """
    mesh = question.part.mesh
    area = float(mesh.vertex_areas @ shared)
    if area <= 0:
        return MOST_OPEN
    first, second = mesh.edges.T
    at = np.flatnonzero(shared[first] != shared[second])
    inner = np.where(shared[first], first, second)[at]
    length = float(seam_lengths(mesh)[at][other_goes_on(question, trip)[inner]].sum())
    return min(length / math.sqrt(area), MOST_OPEN)
