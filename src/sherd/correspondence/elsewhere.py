"""Elsewhere: another place where a part would lie as well, such as the next of five alike arms.

Labels settle in one place, and nothing in that says whether another one is as good, or better. So
the nodes are labeled once more with no node near where it lies; where that costs about as little,
the part is laid there too, and both places are compared.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from sherd.correspondence.labels.anchors import ELSEWHERE, find_anchors, first_labeling
from sherd.correspondence.labels.labeling import Labeling, Problem
from sherd.correspondence.working_placement import WorkingPlacement

__all__ = ["LabeledElsewhere", "are_apart", "labeled_elsewhere"]

# Arms of stars that are all alike take labels elsewhere up to a quarter of the way from the energy
# of their own to that of chance, as labels are sampled: where part and full shape have the very
# same vertices; otherwise up to a ninth.
AS_CHEAP = 0.25


@dataclass(frozen=True, eq=False)
class LabeledElsewhere:
    """A first labeling where no node lies near where it lay before.

    Attributes
    ----------
    energy
        Of it, per node.
    finished
        What finds the last labeling from there.
    """

    energy: float
    finished: Callable[[], Labeling]

    def is_as_cheap(self, start: float, by_chance: float) -> bool:
        """Whether it may be as good a place as one of energy `start`, beside what chance costs."""
        return self.energy - start <= AS_CHEAP * (by_chance - start)


def labeled_elsewhere(problem: Problem, labeling: Labeling) -> LabeledElsewhere | None:
    """Label each node at least as far from its label as places are apart; None where it cannot."""
    near = problem.labels.between[labeling.labels] < ELSEWHERE
    elsewhere = problem.forbidding(near)
    if elsewhere.forbidden.all(axis=1).any():
        return None
    first = first_labeling(elsewhere)
    return LabeledElsewhere(first.energy, partial(find_anchors, elsewhere, start=first))


def are_apart(one: WorkingPlacement, other: WorkingPlacement) -> bool:
    """Whether most of the part lies elsewhere; what slid back along a limb does not."""
    apart = one.distances_to(other)
    return bool(np.median(apart) > ELSEWHERE)
