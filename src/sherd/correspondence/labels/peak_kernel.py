"""Compiled: at which rotation a node is most like a label, and which labels it is most like."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Bools, Floats, Ints, Singles
from sherd.compiled import compiled
from sherd.threads import over_rows

__all__ = ["most_alike", "rotation_peaks"]

# A flat top has no vertex; far below the rounding of a similarity.
LEAST_BEND = np.float32(-1e-6)
# Above the cost of everything that may be chosen, which is a similarity with its sign turned.
LAST = np.float32(2.0)


def rotation_peaks(similarity: Singles) -> tuple[Singles, Floats]:
    """Similarity (k, s) at the best of r rotations, and that rotation (k, s) in radians.

    The rotation is the vertex of the parabola through the values (k, s, r) at the best and beside.
    """
    peaks = np.empty(similarity.shape[:2], dtype=np.float32)
    turns = np.empty(similarity.shape[:2])
    over_rows(_rotation_peaks, len(similarity), similarity, peaks, turns)
    return peaks, turns


def most_alike(peaks: Singles, forbidden: Bools, count: int) -> Ints:
    """The `count` labels (k, count) of largest peaks (k, s), equal ones in their order.

    Forbidden ones (k, s) come after all others.
    """
    leaders = np.empty((len(peaks), min(count, peaks.shape[1])), dtype=np.int64)
    over_rows(_most_alike, len(peaks), peaks, forbidden, leaders)
    return leaders


@compiled()
def _rotation_peaks(rows, similarity, peaks, turns):
    shifts = similarity.shape[2]
    for row in range(rows[0], rows[1]):
        for label in range(similarity.shape[1]):
            values = similarity[row, label]
            at = 0
            for shift in range(1, shifts):
                if values[shift] > values[at]:
                    at = shift
            before, after = values[(at - 1) % shifts], values[(at + 1) % shifts]
            bend = min(before - np.float32(2) * values[at] + after, LEAST_BEND)
            aside = np.float32(0.5) * (before - after) / bend
            peaks[row, label] = values[at]
            turns[row, label] = (at + np.float64(aside)) * 2 * np.pi / shifts


@compiled()
def _most_alike(rows, peaks, forbidden, leaders):
    count = leaders.shape[1]
    costs = np.empty(count, np.float32)
    for row in range(rows[0], rows[1]):
        found = 0
        for label in range(peaks.shape[1]):
            cost = LAST if forbidden[row, label] else -peaks[row, label]
            if found == count and not cost < costs[count - 1]:
                continue
            place = found if found < count else count - 1
            while place > 0 and cost < costs[place - 1]:
                costs[place] = costs[place - 1]
                leaders[row, place] = leaders[row, place - 1]
                place -= 1
            costs[place], leaders[row, place] = cost, label
            found = min(found + 1, count)
