"""By relief: a labeling that compares the skin as well, for a part whose place is not sure.

Where a pose bends a joint, normals turn, and the right label is no longer among the most similar
ones; bumps and hollows of the skin stay. They say little of another individual, and nothing of a
noisy scan, so the place that they lead to counts only if the part fits better there.
"""

from __future__ import annotations

from dataclasses import replace

from sherd.correspondence.labels.anchors import candidates_again, find_anchors
from sherd.correspondence.labels.labeling import Labeling, Problem, solve
from sherd.correspondence.labels.relief_similarity import with_relief

__all__ = ["labeled_by_relief"]


def labeled_by_relief(problem: Problem) -> Labeling:
    """The labeling by normals and relief; its energy is what it settles at by normals alone.

    In one round; so it can be compared with that of the problem itself, and with that of chance.
    """
    found = find_anchors(with_relief(problem))
    settled = solve(problem, *candidates_again(problem, found))
    return replace(found, energy=settled.energy)
