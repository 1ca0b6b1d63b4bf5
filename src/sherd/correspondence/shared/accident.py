"""How surely what two shapes share is alike, and not by accident.

A rank correlation of n independent places scatters by 1 / sqrt(n) where nothing is alike. But what
is known of neighboring places is nearly the same, on smooth skin far around, so a place says the
less, the more others near it say the same: there a few places are all that can be seen, and what is
alike at all of them proves little.

References
----------
Clifford, Richardson, Hemon, *Assessing the significance of the correlation between two spatial
processes*, 1989: the variance of a correlation is the mean, over all pairs of places, of the
product of how much either alone is alike at places so far apart.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial.distance import pdist, squareform
from scipy.stats import rankdata

from sherd.arrays import Floats, Ints
from sherd.correspondence.confidence import above
from sherd.correspondence.labels.two_way import Both
from sherd.correspondence.question import Question
from sherd.correspondence.shared.relief_correlation import (
    concordance_in,
    judged_reliefs,
    seen_where_laid,
)
from sherd.correspondence.shared.two_way_placement import SharedPlacement
from sherd.descriptors.relief import curvatures

__all__ = ["independent_places", "most_by_accident"]

# Pairs whose distances are alike within so much count as so far apart, in sqrt(area) of the larger
# piece: as dense as labels are, of which no two are nearer.
STEP = 0.03
# How much more alike curvatures must be than by accident, in standard deviations of that, and how
# wide the doubt is. On skin without muscles, such as a trunk made of round cones, all that is seen
# is alike along the back and around it, as there is little to see, and two pieces that only meet
# are laid over each other: of 46 such pairs of three generated animals ten were likely (0.54 to
# 0.99). Seven of them have 0.8 to 2.54, two 2.9 and 3.1 (a side of the belly on another one), one
# 4.2, a foreleg on the other one, turned about itself. Right answers of a cat that stretches, which
# share 0.08 of the whole, have 2.83 and 2.92, of 27 first questions of real animals and people one
# has 3.5 and the others more, and of two species 3.3 and more. Half way, three steps to either.
ACCIDENT, DOUBT = 2.65, 0.04
# What is alike by accident may be right all the same: of answers that all else speaks for, and that
# have less, about as many were right (of cats that stretch) as wrong. So it is not likely, but half
# likely, which is said of whom nobody knows the place of.
EVEN = 0.45


def independent_places(
    fields: Both[Floats], questions: Both[Question], placements: Both[SharedPlacement]
) -> float:
    """As how many independent places those count at which one shape lies on the other.

    Mean of both directions; 0 where nothing is shared.

    Parameters
    ----------
    fields
        (n,) and (m,) what is compared, of the part's vertices of the one question and of the other.
    questions, placements
        Of both directions.
    """
    both = zip(questions, placements, fields, fields[::-1], strict=True)
    return float(np.mean([_count(*each) for each in both]))


def most_by_accident(questions: Both[Question], placements: Both[SharedPlacement]) -> float:
    """What a chance may be at the most, as all that is seen may be alike by accident: `EVEN` to 1.

    Less than 1 where what is shared is not as much curved in both, more than by accident. Reliefs
    say where bumps are, by rank and less what is around; curvatures also how large they are, and
    how thick what they are on is. Gaussian or mean ones, whichever are more alike, as the mean one
    changes where joints bend, and the other one is small on what is straight; beside the standard
    deviation of an accident over as many independent places as reliefs have.
    """
    here, there = (question.part.mesh for question in questions)
    curved = zip(curvatures(here), curvatures(there), strict=True)
    alike = max(concordance_in(fields, questions, placements) for fields in curved)
    reliefs = judged_reliefs(questions)
    places = np.mean([independent_places(fields, questions, placements) for fields in reliefs])
    return EVEN + (1.0 - EVEN) * above(alike * math.sqrt(places), ACCIDENT, DOUBT)


def _count(question: Question, place: SharedPlacement, own: Floats, other: Floats) -> float:
    seen = seen_where_laid(question, place, own, other).among(question.part.dense.vertices)
    if len(seen.vertices) < 2:
        return 0.0
    steps = (squareform(pdist(question.part.mesh.vertices[seen.vertices])) / STEP).astype(np.int64)
    pairs = np.outer(seen.trust, seen.trust)
    alike = [_alike_by_step(values, seen.trust, pairs, steps) for values in (seen.here, seen.there)]
    variance = float(np.average((alike[0] * alike[1])[steps], weights=pairs))
    # where both are alike at other distances the mean says nothing, and no place counts twice
    return 1.0 / max(variance, 1.0 / len(seen.vertices))


def _alike_by_step(values: Floats, trust: Floats, pairs: Floats, steps: Ints) -> Floats:
    """The correlation (s,) of values (k,) with themselves so many steps away."""
    order = rankdata(values)
    order -= np.average(order, weights=trust)
    order /= max(math.sqrt(np.average(order**2, weights=trust)), 1e-12)
    together = np.bincount(steps.ravel(), (pairs * np.outer(order, order)).ravel())
    of = np.bincount(steps.ravel(), pairs.ravel())
    found: Floats = together / np.maximum(of, 1e-300)
    return found
