"""What two labelings save against nowhere, of both directions together."""

from __future__ import annotations

import numpy as np

from sherd.correspondence.labels.consistent import (
    missing_area,
    node_areas,
    node_costs,
    node_lacks,
)
from sherd.correspondence.labels.labeling import Labeling, Problem

__all__ = ["PRICE_SHARE", "lack", "most_saved", "saved"]

# Half way between a perfect answer, which costs nothing, and chance. With their true labels nodes
# of one animal cost a fifth of chance on average, those of other species 0.35 to 0.8 (four pairs of
# SMAL), so half of these go nowhere. At 0.65 more of them stay, and more of what is wrong: of 24
# pairs of cuts the mean error was 2.1 instead of 1.1.
PRICE_SHARE = 0.5
# A placement that misses a fifth of what it keeps counts a third (1 / e): right placements hardly
# miss anything, wrong ones a seventh of what they keep (SMAL), and what is found is found nearly as
# alike in wrong places. At four times a wrong placement of a horse's cut that keeps more saves as
# much as the right one; between three and eight the choice between species is the same.
MISSING_WEIGHT = 5.0


def saved(
    problems: tuple[Problem, Problem], kept: tuple[Labeling, Labeling], chance: tuple[float, float]
) -> float:
    """What the nodes that are kept save against nowhere, as a share of chance, times their area.

    So a few nodes that are much alike save as much as twice as many that are hardly worth their
    price. Times `exp(-5 missing / kept area)`.
    """
    total = missing = area = 0.0
    for problem, labeling, energy in zip(problems, kept, chance, strict=True):
        less = PRICE_SHARE - node_costs(problem, labeling) / max(energy, 1e-12)
        areas = node_areas(problem)[labeling.placed]
        total += float(areas @ less[labeling.placed])
        area += float(areas.sum())
        missing += missing_area(problem, labeling)
    if total <= 0:
        return total
    return total * float(np.exp(-MISSING_WEIGHT * missing / area))


def most_saved(problems: tuple[Problem, Problem]) -> float:
    """What a perfect labeling of all of the smaller shape would save, in both directions."""
    areas = (float(node_areas(problem).sum()) for problem in problems)
    return 2 * PRICE_SHARE * min(areas)


def lack(
    problems: tuple[Problem, Problem], kept: tuple[Labeling, Labeling], chance: tuple[float, float]
) -> float:
    """How much less alike than the best labels those that are kept are, as a share of chance.

    Mean of both directions, each over the area that is kept; 0 if none is.
    """
    total = 0.0
    for problem, labeling, energy in zip(problems, kept, chance, strict=True):
        areas = node_areas(problem) * labeling.placed
        paid = float(areas @ node_lacks(problem, labeling)) / max(energy, 1e-12)
        total += 0.5 * paid / max(float(areas.sum()), 1e-12)
    return total
