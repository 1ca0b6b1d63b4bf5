"""How much of the border of what is shared lies inside both shapes, where it needs a reason."""

from __future__ import annotations

import math

import numpy as np

from sherd.arrays import Bools, Floats
from sherd.correspondence.question import Question
from sherd.correspondence.shared.region_cut import WIDTH, seam_lengths
from sherd.correspondence.shared.round_trip import RoundTrip
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["MOST_OPEN", "is_inside", "open_seam", "open_seam_where", "other_goes_on"]

# The whole border of a square is four times the root of its area; half of it open says all.
MOST_OPEN = 2.0


def other_goes_on(question: Question, trip: RoundTrip) -> Bools:
    """Vertices (n,) whose places lie farther inside the other shape than a border is blurred."""
    full = question.full
    return is_inside(trip.points.interpolate(full.mesh, full.cut_distance))


def is_inside(depth: Floats) -> Bools:
    """Whether places at such distances (n,) from a cut lie farther inside than it is blurred."""
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
    return open_seam_where(question.part.mesh, shared, other_goes_on(question, trip))


def open_seam_where(mesh: TriangleMesh, shared: Bools, goes_on: Bools) -> float:
    """:func:`open_seam` of vertices (n,) that are shared, the other shape going on at others."""
    area = float(mesh.vertex_areas @ shared)
    if area <= 0:
        return MOST_OPEN
    first, second = mesh.edges.T
    at = np.flatnonzero(shared[first] != shared[second])
    inner = np.where(shared[first], first, second)[at]
    length = float(seam_lengths(mesh)[at][goes_on[inner]].sum())
    return min(length / math.sqrt(area), MOST_OPEN)
