"""Unknown scale: how much larger the part must be to fit the full shape."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.correspondence.labels.anchors import find_anchors
from sherd.correspondence.labels.labeling import CLEAR, Labeling, Problem, labeling_problem
from sherd.correspondence.placements import node_similarity
from sherd.correspondence.question import Question
from sherd.mesh.sizes import LARGEST_PART
from sherd.surface.transformed import enlarged, thinned
from sherd.threads import begun

__all__ = [
    "LARGEST_SCALE",
    "SAME",
    "ScaleEstimate",
    "estimated_scale",
    "largest_factor",
    "length_ratio",
]

# The range that users are promised, and a grid over it: a neighborhood that is a tenth too
# large is still recognized.
LARGEST_SCALE = 2.0
GRID = 7
# Lengths below this are dominated by the spacing of labels, above it by the cut.
SHORTEST, LONGEST = 0.08, 0.5
REFINEMENTS = 2
# So many nodes, a tenth of the width of the part apart, tell a factor from one 1.26 times as large;
# where they are not sure, the runner-up is tried with all nodes too.
FEW_NODES, FINALISTS = 70, 2
# An estimate that would lie farther out varies by so much around the bound.
BOUND = 1.02
# The median of fewer lengths is worth less than that of unsafe ones.
FEWEST = 20


@dataclass(frozen=True)
class ScaleEstimate:
    """A factor, and whether it would lie farther out if that were allowed."""

    factor: float
    at_bound: bool = False


SAME = ScaleEstimate(1.0)


def largest_factor(question: Question) -> float:
    """The factor by which `part` may be enlarged: not beyond the full shape, and at most 2."""
    room = np.sqrt(LARGEST_PART * question.full.mesh.area / question.part.mesh.area)
    return min(LARGEST_SCALE, float(room))


def estimated_scale(
    question: Question, rng: np.random.Generator, *, largest: float
) -> ScaleEstimate:
    """The factor from 1/2 to `largest` by which `part` must be enlarged.

    A few nodes of the part are labeled at each factor of a grid; the factors whose labelings keep
    the most similarity and the most even ratio of lengths are tried with all nodes. The best is
    then corrected by that ratio.
    """
    factors = np.geomspace(1 / LARGEST_SCALE, LARGEST_SCALE, GRID)
    factors = factors[: max(1, int((factors <= largest).sum()))]
    seeds = rng.integers(2**32, size=(2, len(factors)))
    few = question.with_part(thinned(question.part, FEW_NODES))
    scores = [score for score, _ in _trials(few, factors, seeds[0])]
    finalists = np.argsort(scores, kind="stable")[::-1][:FINALISTS]
    trials = _trials(question, factors[finalists], seeds[1, finalists])
    best = int(np.argmax([score for score, _ in trials]))
    factor = float(factors[finalists[best]]) * trials[best][1]
    for _ in range(REFINEMENTS):
        factor = float(np.clip(factor, 1 / LARGEST_SCALE, largest))
        factor *= _trial(question, factor, int(rng.integers(2**32)))[1]
    factor = float(np.clip(factor, 1 / LARGEST_SCALE, largest))
    at_bound = factor <= BOUND / LARGEST_SCALE or factor >= largest / BOUND
    return ScaleEstimate(factor, at_bound)


def length_ratio(problem: Problem, labeling: Labeling) -> tuple[float, float]:
    """Median ratio of full to part length over safe edges, and the median deviation of its log."""
    edges, measures = problem.edges, problem.measures
    length = measures.length
    ends = labeling.labels[edges]
    distance = problem.labels.between[ends[:, 0], ends[:, 1]]
    safe = measures.equality == CLEAR
    use = (length > SHORTEST) & (length < LONGEST) & safe & (distance > 0)
    if use.sum() < FEWEST:
        use = (length > 0) & np.isfinite(length) & (distance > 0)
    if not use.any():
        return 1.0, np.inf
    ratios = np.log(distance[use] / length[use])
    middle = float(np.median(ratios))
    return float(np.exp(middle)), float(np.median(np.abs(ratios - middle)))


def _trials(question: Question, factors: Floats, seeds: Ints) -> list[tuple[float, float]]:
    """A trial of each factor, as many at a time as there are cores."""
    works = [
        partial(_trial, question, *each)
        for each in zip(factors.tolist(), seeds.tolist(), strict=True)
    ]
    return [result() for result in [begun(work) for work in works]]


def _trial(question: Question, factor: float, seed: int) -> tuple[float, float]:
    """Score of the labeling at one factor, and the ratio of lengths that it finds."""
    part = enlarged(question.part, factor)
    trial = question.with_part(part)
    similarity = node_similarity(trial, part.trusted_spectra(part.sparse.vertices))
    problem = labeling_problem(trial, similarity, np.random.default_rng(seed))
    labeling = find_anchors(problem, rounds=2)
    rows = np.arange(len(part.sparse))
    shifts = similarity.shape[2]
    at = np.round(labeling.rotations / (2 * np.pi) * shifts).astype(np.int64) % shifts
    alike = similarity[rows, labeling.labels, at]
    ratio, spread = length_ratio(problem, labeling)
    return float(alike.mean()) - spread, ratio
