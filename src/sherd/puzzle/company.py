"""The joint choice with borders as evidence: a piece that closes a hole is likely to belong there.

Appearance and deformation say how likely a piece lies right alone, whoever its neighbors are. Where
pieces were cut apart their borders coincide, and a piece in a wrong place meets others along a part
of its border only. So chances are judged again among the pieces that were chosen,

    logit p' = logit p + W max(phi - lambda - phi_0, 0),

phi being the share of its border that faces theirs and lambda the share of its core that is in
theirs, and the choice is made again with these. What lies on another piece closes no hole. A
border that meets nothing says nothing against a piece: its neighbor may be missing, and pieces that
overlap have borders inside each other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sherd.arrays import Floats
from sherd.correspondence.confidence import MOST
from sherd.puzzle.border import met_share
from sherd.puzzle.joint_choice import Candidate, Choice, joint_choice

__all__ = ["choice_in_company"]

# Of the logit, for all of a border. The slope of a logistic regression with the logit of the chance
# alone as an offset, over 94 trials of twelve puzzles of animated animals in three and five pieces,
# 56 of the trials right (error below 0.05).
WEIGHT = 4.7
# Of those trials the ones that lay somewhere else, but on no other piece, met others along at most
# 0.54 of their borders.
BY_CHANCE = 0.5
# New neighbors change what is met; mostly the second choice is the last.
ROUNDS = 3


def choice_in_company(
    pieces: Sequence[Sequence[Candidate]], areas: Floats, *, may_overlap: bool = False
) -> tuple[Choice, list[list[Candidate]]]:
    """The joint choice by chances among the chosen pieces, and the candidates with these chances.

    Parameters
    ----------
    pieces, areas, may_overlap
        As in :func:`sherd.puzzle.joint_choice.joint_choice`.
    """
    choice = joint_choice(pieces, areas, may_overlap=may_overlap)
    judged = [list(some) for some in pieces]
    for _ in range(ROUNDS):
        before = choice
        judged = _judged(pieces, before, areas)
        choice = joint_choice(judged, areas, may_overlap=may_overlap)
        if np.array_equal(choice.candidates, before.candidates):
            break
    return choice, judged


def _judged(
    pieces: Sequence[Sequence[Candidate]], choice: Choice, areas: Floats
) -> list[list[Candidate]]:
    """The candidates with their chances among the chosen ones of other pieces."""
    chosen = {k: pieces[k][int(c)] for k, c in enumerate(choice.candidates) if c >= 0}
    return [
        [_among(each, [other for k, other in chosen.items() if k != piece], areas) for each in some]
        for piece, some in enumerate(pieces)
    ]


def _among(candidate: Candidate, others: Sequence[Candidate], areas: Floats) -> Candidate:
    """The candidate with its chance among these of other pieces."""
    met = met_share(candidate.border, [other.border for other in others])
    if met <= BY_CHANCE:
        return candidate
    core = areas * candidate.core
    taken = np.logical_or.reduce([other.core for other in others])
    lies_on = float(core @ taken) / max(float(core.sum()), 1e-12)
    more = WEIGHT * max(met - lies_on - BY_CHANCE, 0.0)
    odds = np.exp(more) * candidate.chance / (1.0 - candidate.chance)
    # what was sure alone is no less so
    return replace(candidate, chance=max(candidate.chance, min(float(odds / (1.0 + odds)), MOST)))
