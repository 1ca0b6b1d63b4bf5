"""How much a correlation over a surface proves, where what is near is alike anyway.

A rank correlation of n independent places scatters by 1 / sqrt(n) where nothing is alike. But what
is known of neighboring places is nearly the same, on smooth skin far around, so a place says the
less, the more others near it say the same.

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
from sherd.correspondence.labels.two_way import Both
from sherd.correspondence.question import Question
from sherd.correspondence.shared.relief_correlation import seen_where_laid
from sherd.correspondence.shared.two_way_placement import SharedPlacement

__all__ = ["independent_places"]

# Pairs whose distances are alike within so much count as so far apart, in sqrt(area) of the larger
# piece: as dense as labels are, of which no two are nearer.
STEP = 0.03


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
