"""Which pairs of pieces are worth a full question first: cheap evidence for all.

A few nodes of each piece are labeled on the other, with nowhere as a label at half of what a node
costs by chance (as :mod:`sherd.correspondence.labels.two_way` does it with all nodes and in three
rounds). The share that is placed, in both directions, ranks the pairs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from sherd.arrays import Floats
from sherd.correspondence.labels.anchors import chance_energy, first_labeling
from sherd.correspondence.labels.labeling import SAME_SCALE
from sherd.correspondence.placements import anchor_problem
from sherd.correspondence.question import Question
from sherd.surface.described import DescribedSurface
from sherd.surface.transformed import thinned

__all__ = ["LEAST_EVIDENCE", "pair_evidence"]

# Nodes of each piece: a third of all, so a pair costs a tenth of a full question.
NODES = 70
# Half way between a perfect answer and chance.
PRICE_SHARE = 0.5
# Unrelated pieces had evidence of 0.27 to 0.31, pieces that overlap 0.40 to 0.91 (twelve pairs of
# two puzzles). Where all pairs of a folder are compared, none below this is asked in full.
LEAST_EVIDENCE = 0.35


def pair_evidence(surfaces: Sequence[DescribedSurface], seed: int) -> Floats:
    """(k, k) symmetric share in [0, 1] of nodes that are worth more than chance, both ways."""
    few = [thinned(surface, NODES) for surface in surfaces]
    share = np.zeros((len(surfaces), len(surfaces)))
    for here, there in combinations(range(len(surfaces)), 2):
        for part, full in ((here, there), (there, here)):
            share[part, full] = _placed_share(surfaces[full], few[part], seed)
    evidence: Floats = np.sqrt(share * share.T)
    return evidence


def _placed_share(full: DescribedSurface, part: DescribedSurface, seed: int) -> float:
    problem = anchor_problem(Question(full, part, SAME_SCALE), np.random.default_rng(seed))
    price = PRICE_SHARE * chance_energy(problem, np.random.default_rng(seed))
    return float(first_labeling(replace(problem, price=price)).placed.mean())
