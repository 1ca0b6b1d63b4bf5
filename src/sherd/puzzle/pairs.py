"""Which pairs of pieces are worth a full question: cheap evidence for all, then the best few.

A few nodes of each piece are labeled on the other, with nowhere as a label at half of what a node
costs by chance (as :mod:`sherd.correspondence.labels.two_way` does it with all nodes and in three
rounds). The share that is placed, in both directions, ranks the pairs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from sherd.arrays import Floats
from sherd.correspondence.labels.anchors import chance_energy, first_labeling
from sherd.correspondence.labels.labeling import SAME_SCALE
from sherd.correspondence.placements import anchor_problem
from sherd.correspondence.question import Question
from sherd.surface.described import DescribedSurface
from sherd.surface.transformed import thinned

__all__ = ["pair_evidence", "pairs_to_ask"]

# Nodes of each piece: a third of all, so a pair costs a tenth of a full question.
NODES = 70
# Half way between a perfect answer and chance.
PRICE_SHARE = 0.5
# Each piece asks so many of the others, so that there are loops; a dozen ask 36 pairs at the most,
# fewer as most choose each other.
PARTNERS = 3
# Unrelated pieces had evidence of 0.27 to 0.31, pieces that overlap 0.40 to 0.91 (twelve pairs of
# two puzzles). Below this a pair is not asked: what it would seem to share is chance.
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


def pairs_to_ask(evidence: Floats) -> list[tuple[int, int]]:
    """The pairs (first, second) that are asked, those with most evidence first.

    The best partners of each piece, and what else the tree of most evidence has, so that all that
    belongs together can be found; none with less evidence than unrelated pieces have.
    """
    count = len(evidence)
    asked = np.zeros((count, count), dtype=bool)
    for piece in range(count):
        others = np.delete(np.arange(count), piece)
        best = others[np.argsort(-evidence[piece, others], kind="stable")][:PARTNERS]
        asked[piece, best] = True
    # the tree of least cost; every pair has one, so nothing is left apart
    cost = sparse.csr_array(np.triu(2.0 - evidence, 1))
    first, second = csgraph.minimum_spanning_tree(cost).nonzero()
    asked[first, second] = True
    asked |= asked.T
    pairs = [
        (i, j)
        for i, j in combinations(range(count), 2)
        if asked[i, j] and evidence[i, j] >= LEAST_EVIDENCE
    ]
    return sorted(pairs, key=lambda pair: -float(evidence[pair]))


def _placed_share(full: DescribedSurface, part: DescribedSurface, seed: int) -> float:
    problem = anchor_problem(Question(full, part, SAME_SCALE), np.random.default_rng(seed))
    price = PRICE_SHARE * chance_energy(problem, np.random.default_rng(seed))
    return float(first_labeling(replace(problem, price=price)).placed.mean())
