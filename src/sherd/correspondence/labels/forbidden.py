"""Labels that are ruled out before anything is compared: by landmarks, or as taken already."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Bools
from sherd.correspondence.question import Question

__all__ = ["PIN_SLACK", "PIN_STRETCH", "forbidden_labels"]

# A pinned vertex may move by the spacing of labels, and lengths from it stretch by a fifth.
PIN_SLACK, PIN_STRETCH = 0.04, 1.2


def forbidden_labels(question: Question) -> Bools:
    """Labels (k, s) that contradict a pin or lie where something else does."""
    forbidden = _contradicting(question)
    if question.free is not None:
        taken = ~question.free[question.labels.vertices]
        if not taken.all():  # where all is taken nothing can be said of the places
            forbidden |= taken
            forbidden[forbidden.all(axis=1)] = taken
    return forbidden


def _contradicting(question: Question) -> Bools:
    """Labels (k, s) farther from a pinned place than the node is from the pinned vertex.

    A path on the part is a path on the full shape, so distances on the full shape are not longer,
    up to stretch and the spacing of labels.
    """
    full, labels = question.full, question.labels
    nodes, pins = question.part.sparse, question.pins
    forbidden = np.zeros((len(nodes), len(labels)), dtype=bool)
    if len(pins.vertices) == 0:
        return forbidden
    places = full.vertex_tree.query(pins.positions)[1]
    reach = full.geodesics.distances_from(places)[:, labels.vertices]
    for vertex, row in zip(pins.vertices, reach, strict=True):
        node = int(np.flatnonzero(nodes.vertices == vertex)[0])
        limit = PIN_SLACK + PIN_STRETCH * nodes.between[node]
        forbidden |= row[None, :] > limit[:, None]
    forbidden[forbidden.all(axis=1)] = False  # pins that contradict each other rule nothing out
    return forbidden
