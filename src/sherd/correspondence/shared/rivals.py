"""Which of several answers to one question lie elsewhere than another one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sherd.arrays import Bools
from sherd.correspondence.labels.consistent import PLACE_WIDTH, SAME_PLACE
from sherd.correspondence.labels.two_way import Both
from sherd.correspondence.question import Question
from sherd.correspondence.shared.two_way_placement import SharedPlacement

__all__ = ["are_rivals"]


def are_rivals(questions: Both[Question], answers: Sequence[Both[SharedPlacement]]) -> Bools:
    """Whether each answer (k, k) lies at another place than each other one.

    Two labelings at different places may be laid at one: as they grow, and as both shapes see more
    of each other. They lie at one if they lay half of the smaller at the same points, up to the
    radius of the largest neighborhood. An answer that shares nothing is everyone's rival.
    """
    rivals = np.ones((len(answers), len(answers)), dtype=bool)
    np.fill_diagonal(rivals, val=False)
    for i, one in enumerate(answers):
        for j, other in enumerate(answers[:i]):
            rivals[i, j] = rivals[j, i] = _common(questions, one, other) < SAME_PLACE
    return rivals


def _common(
    questions: Both[Question], one: Both[SharedPlacement], other: Both[SharedPlacement]
) -> float:
    """The share of the smaller that both lay at the same points, mean of both shapes."""
    shares = []
    for question, here, there in zip(questions, one, other, strict=True):
        areas = question.part.mesh.vertex_areas
        near = np.linalg.norm(here.trip.there - there.trip.there, axis=1) < PLACE_WIDTH
        smaller = min(float(areas @ here.shared), float(areas @ there.shared))
        common = float(areas @ (here.shared & there.shared & near))
        shares.append(common / smaller if smaller > 0 else 0.0)
    return 0.5 * (shares[0] + shares[1])
