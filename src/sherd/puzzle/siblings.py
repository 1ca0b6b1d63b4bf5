"""Pieces of one thing beside each other: one whose skin is much less alike is in doubt.

How alike the relief of a piece is to that of the whole where it lies right, rho, goes with the
thing: 0.85 to 0.9 of a wolf, 0.4 to 0.65 of a lion whose poses stretch its skin. So a bound for all
things lets a dog's part pass on a cow (0.5), whose own pieces have 0.76 and 0.8. The others that
are placed say what is to be expected here:

    logit p' = logit p - A max(sum_i w_i rho_i / sum_i w_i - rho - B, 0),     w_i = area_i p_i

So a piece of something else that was bent into a gap is in doubt, and one that slid; and so may a
noisy scan be beside clean ones.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from sherd.arrays import Floats
from sherd.puzzle.against import lowered
from sherd.puzzle.trials import Together, Trial, chosen_together, without_the_unlikely

__all__ = ["beside_siblings", "chosen_beside_siblings", "is_less_alike"]

# How much less alike than the others a piece may be, and by how much less likely more makes it, in
# log odds: a logistic regression of the right place (error below 0.1), with the log odds of the
# chances that were given as an offset, over 229 pieces of 52 puzzles of six animals of SMAL and of
# `tosca_poses` and `animations` in three and five pieces. Of 174 that are less than 0.05 off twelve
# are less alike by more than 0.18, of 43 foreign ones all but five. With the slope for places that
# are less than 0.05 off, 12, a part of a horse would be refused that lies right in a pose that
# creases its skin.
LESS, LESS_LIKELY = 0.15, 4.7


def chosen_beside_siblings(
    trials: Sequence[Trial], count: int, areas: Floats, *, may_overlap: bool = False
) -> Together:
    """The trials that are chosen jointly, each then judged beside the others.

    What is unlikely then is taken out, and the rest is chosen anew.

    Parameters
    ----------
    trials, count, areas, may_overlap
        As in :func:`sherd.puzzle.trials.chosen_together`.
    """

    def chosen(left: Sequence[Trial]) -> Together:
        found = chosen_together(left, count, areas, may_overlap=may_overlap)
        placed = found.trials
        judged = {k: beside_siblings(each, placed.values(), areas) for k, each in placed.items()}
        return replace(found, trials=judged)

    return without_the_unlikely(trials, chosen)


def beside_siblings(trial: Trial, placed: Collection[Trial], areas: Floats) -> Trial:
    """A trial with its chance beside all that are placed; `areas` (n,) of the full shape."""
    against = -LESS_LIKELY * max(_less_alike(trial, placed, areas) - LESS, 0.0)
    return trial.with_chance(lowered(trial.chance, against))


def is_less_alike(trial: Trial, placed: Collection[Trial], areas: Floats) -> bool:
    """Whether that lowers its chance."""
    return _less_alike(trial, placed, areas) > LESS


def _less_alike(trial: Trial, placed: Collection[Trial], areas: Floats) -> float:
    """By how much a trial is less alike than the others are; 0 where it is not known."""
    known = [
        (other.alike, float(areas @ other.candidate.region) * other.chance)
        for other in placed
        if other.piece != trial.piece and other.alike is not None
    ]
    if trial.alike is None or not known:
        return 0.0
    alike, weights = zip(*known, strict=True)
    return float(np.average(alike, weights=weights)) - trial.alike
