"""Which nodes of a part are compared with each other, and what is known of these pairs."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.correspondence.labels.labeling_data import EdgeMeasures
from sherd.surface.samples import Samples

__all__ = ["CLEAR", "HEAT_ERROR", "LENGTH_HALF", "compared_pairs", "edge_measures"]


# Each node is tied to its near neighbors, which carry the shape, and to some farther away, which
# carry the layout; all pairs would be twenty times as many.
NEAR_NEIGHBORS, MIDDLE_NEIGHBORS, FAR_NEIGHBORS = 10, 6, 6
MIDDLE_REACH = 0.35
# Short lengths are more reliable and there are more far pairs than near ones.
LENGTH_HALF = 0.3
# Nodes in different components are tied by straight lines: neighbors across the gap say what
# continues where; nodes at all distances, which limb is which.
BRIDGES_NEAR, BRIDGES_FAR = 4, 6
# Directions are useless beyond a limb's length.
ANGLE_REACH = 0.3
ANGLE_WEIGHT = 0.5
# Paths that met the cut: the full shape's may be shorter by the heat method's few percent too, and
# beyond this length nothing is believed to be equal.
HEAT_ERROR, CUT_REACH = 0.05, 0.4
# Belief in equal length where the path cannot have met the cut: then nothing else is asked.
CLEAR = 1.0
# How fast the belief in equal length fades once the path may have met the cut.
CUT_FADE = 0.15
CUT_SHARE = 0.6


def compared_pairs(nodes: Samples, places: Floats, rng: np.random.Generator) -> Ints:
    """Pairs (e, 2) of nodes, at (k, 3), that are compared; the first below the second."""
    between = nodes.between
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
    tied |= _bridges(nodes, places)
    first, second = np.nonzero(np.triu(tied | tied.T, 1))
    return np.stack([first, second], axis=1)


def _bridges(nodes: Samples, places: Floats) -> Bools:
    """Pairs (k, k) of nodes in different components: the nearest, and some of all distances.

    Nodes of crumbs, which have few neighbors in their own component, take more of the nearest.
    """
    tied: Bools = ~np.isfinite(nodes.between)
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


def edge_measures(edges: Ints, nodes: Samples, depth: Floats) -> EdgeMeasures:
    """What is known of the edges (e, 2), by the distances (k,) of the nodes to the cut."""
    length = np.asarray(nodes.between[edges[:, 0], edges[:, 1]], dtype=np.float64)
    safe = depth[edges[:, 0]] + depth[edges[:, 1]]
    clear = length <= (1 + HEAT_ERROR) * safe
    fade = np.exp(-np.maximum(length - safe, 0.0) / CUT_FADE)
    return EdgeMeasures(
        length=length,
        lower=(1 - HEAT_ERROR) * np.minimum(length, safe),
        equality=np.where(clear, CLEAR, CUT_SHARE * fade * (length < CUT_REACH)),
        weight=1.0 / (1.0 + (length / LENGTH_HALF) ** 2),
        turn=np.where(length < ANGLE_REACH, ANGLE_WEIGHT, 0.0) * np.where(clear, 1.0, fade),
    )
