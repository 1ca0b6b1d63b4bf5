"""Unknown scale: how much larger the part must be to fit the full shape."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from sherd.arrays import Floats, Ints, Singles
from sherd.correspondence.labels.anchors import (
    find_anchors,
    first_labeling,
    proposed_anchors,
)
from sherd.correspondence.labels.labeling import Labeling, Problem, labeling_problem
from sherd.correspondence.labels.node_pairs import CLEAR
from sherd.correspondence.placements import node_similarity
from sherd.correspondence.question import Question
from sherd.descriptors.rotation_shot import pooled_similarity
from sherd.mesh.sizes import LARGEST_PART
from sherd.surface.described import DescribedSurface
from sherd.surface.transformed import enlarged, thinned
from sherd.threads import side_by_side

__all__ = [
    "SAME",
    "ScaleEstimate",
    "estimated_scale",
    "factors_about_one",
    "factors_that_fit",
    "length_ratio",
]

# In sqrt(area) over that of the full shape: a part of a hundredth of the area is as wide as the
# largest neighborhood, and what is smaller still has too little to be told apart by.
SMALLEST_SIZE, LARGEST_SIZE = 0.1, float(np.sqrt(LARGEST_PART))
# The range that users are promised where neither shape is whole.
LARGEST_SCALE = 2.0
# Factors are tried this far apart: a neighborhood that is a tenth too large is still recognized.
STEP = 1.26
# Lengths below this are dominated by the spacing of labels, above it by the cut.
SHORTEST, LONGEST = 0.08, 0.5
# Ratios of two labelings at one factor differ by a percent, so the last correction is a mean.
REPEATS = 2
# Labels give way to lengths, so their ratio says a third to two thirds of what a factor lacks, as
# rounds of it on 15 parts of animated animals did.
CORRECTION = 1.5
# Of labelings whose score is asked for, not their labels.
ROUNDS = 2
# So many nodes, a tenth of the width of the part apart, tell a factor from one 1.26 times as large;
# with all nodes, scores differed from theirs by up to 0.04.
FEW_NODES = 70
# One in so many vertices of the full shape is seen, and all labels: three or four for each label of
# 10,000. The scales of 11 parts that are not taken for another changed by 1.1 percent at most.
GLANCE_STEP = 4
# Peaks of the score that are compared with all nodes: up to so many, as far as they are so near.
FINALISTS, NEAR_PEAK = 3, 0.1
# Of 18 parts in other poses 15 scored 0.06 and more higher at the true scale than at other peaks,
# three small ones between -0.002 and 0.03: there nothing but the files tells which is right. The
# bound was read off these 18, none was held out.
UNSURE = 0.04
# An estimate that would lie farther out varies by so much around the bound.
BOUND = 1.02
# The median of fewer lengths is worth less than that of unsafe ones.
FEWEST = 20


@dataclass(frozen=True)
class ScaleEstimate:
    """A factor, and what speaks against it.

    Attributes
    ----------
    factor
        What lengths of the part are multiplied by.
    at_bound
        Whether it would lie farther out if that were allowed.
    rival
        Another factor at which the part fits about as well, if there is one.
    """

    factor: float
    at_bound: bool = False
    rival: float | None = None


SAME = ScaleEstimate(1.0)


def factors_that_fit(question: Question) -> Floats:
    """Factors that make the part 0.01 to 1.3 times as large in area as the full shape."""
    size = np.sqrt(question.part.mesh.area / question.full.mesh.area)
    factors: Floats = _equal_ratios(SMALLEST_SIZE, LARGEST_SIZE) / size
    return factors


def factors_about_one() -> Floats:
    """Factors from a half to two, whatever the areas are."""
    return _equal_ratios(1 / LARGEST_SCALE, LARGEST_SCALE)


def estimated_scale(
    question: Question, rng: np.random.Generator, factors: Floats, *, own: float = 1.0
) -> ScaleEstimate:
    """The factor by which `part` must be enlarged.

    A few nodes of the part are labeled at each factor; where the labelings keep the most
    similarity and the most even ratio of lengths, between the factors by a parabola, all nodes are
    labeled, and that ratio corrects the best. A single such place is compared with no other.

    Parameters
    ----------
    question
        Full shape and part.
    rng
        Draws the edges of the labelings.
    factors
        (g,) in equal ratios, ascending; the answer lies between the first and the last.
    own
        The factor that leaves the part as large as its file says: of those that fit about as well,
        the nearest to it is taken.
    """
    least, largest = float(factors[0]), float(factors[-1])
    seeds = rng.integers(2**32, size=(2, len(factors)))
    few = question.with_part(thinned(question.part, FEW_NODES))
    sketch = _Trial(_Glance.of(question.full).similarity, _sketched)
    whole = _Trial(node_similarity, _labeled)
    scores = np.array([score for score, _ in _tried(sketch, few, factors, seeds[0])])
    peaks = _peaks(scores)
    finalists = np.exp(_parabola_tops(np.log(factors), scores, peaks))
    equals = [0]
    if len(peaks) > 1:
        trials = _tried(whole, question, finalists, seeds[1, peaks])
        best = max(score for score, _ in trials)
        equals = [k for k, (score, _) in enumerate(trials) if score > best - UNSURE]
        equals.sort(key=lambda k: abs(np.log(finalists[k] / own)))
        finalists = finalists * [ratio for _, ratio in trials]
    factor = float(np.clip(finalists[equals[0]], least, largest))
    again = _tried(whole, question, np.full(REPEATS, factor), rng.integers(2**32, size=REPEATS))
    factor *= float(np.exp(CORRECTION * np.mean([np.log(ratio) for _, ratio in again])))
    factor = float(np.clip(factor, least, largest))
    return ScaleEstimate(
        factor,
        at_bound=factor <= BOUND * least or factor >= largest / BOUND,
        rival=float(finalists[equals[1]]) if len(equals) > 1 else None,
    )


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


def _equal_ratios(first: float, last: float) -> Floats:
    return np.geomspace(first, last, 1 + int(np.ceil(np.log(last / first) / np.log(STEP))))


def _peaks(scores: Floats) -> Ints:
    """Where scores (g,) are higher than beside, the highest first; the lower ones are left out."""
    beside = np.pad(scores, 1, constant_values=-np.inf)
    found = np.flatnonzero((scores >= beside[:-2]) & (scores > beside[2:]))
    found = found[np.argsort(-scores[found], kind="stable")]
    near: Ints = found[scores[found] >= scores[found[0]] - NEAR_PEAK][:FINALISTS]
    return near


def _parabola_tops(places: Floats, scores: Floats, peaks: Ints) -> Floats:
    """Vertices (p,) of the parabolas through each peak and its neighbors; ends stay themselves."""
    tops: Floats = places[peaks].copy()
    inner = (peaks > 0) & (peaks < len(places) - 1)
    here = peaks[inner]
    before, after = scores[here] - scores[here - 1], scores[here] - scores[here + 1]
    step = places[here + 1] - places[here]  # before >= 0 and after > 0: at most half a step aside
    tops[inner] += 0.5 * (before - after) / (before + after) * step
    return tops


@dataclass(frozen=True, eq=False)
class _Glance:
    """The full shape as some of its vertices see it, enough to tell factors 1.26 apart.

    Attributes
    ----------
    spectra
        (5, m, 2 k) of the labels and of every `GLANCE_STEP`-th vertex.
    cells
        (m,) the label nearest to each of them.
    """

    spectra: Singles
    cells: Ints

    @classmethod
    def of(cls, full: DescribedSurface) -> _Glance:
        vertices = np.arange(0, full.mesh.vertex_count, GLANCE_STEP)
        vertices = np.union1d(vertices, full.dense.vertices)
        return cls(np.ascontiguousarray(full.spectra[:, vertices]), full.dense.cells[vertices])

    def similarity(self, question: Question, node_spectra: Singles) -> Singles:
        """As :func:`node_similarity`, of fewer vertices."""
        full = question.full
        sought = full.axes.project(node_spectra)
        return pooled_similarity(self.spectra, sought, self.cells, len(full.dense))


@dataclass(frozen=True)
class _Trial:
    """How a factor is tried: what is how similar, and how that is labeled."""

    similarity: Callable[[Question, Singles], Singles]
    labeling: Callable[[Problem], Labeling]


def _tried(
    how: _Trial, question: Question, factors: Floats, seeds: Ints
) -> list[tuple[float, float]]:
    """A trial of each factor, as many at a time as there are cores."""
    return side_by_side(
        partial(_trial, how, question, *each)
        for each in zip(factors.tolist(), seeds.tolist(), strict=True)
    )


def _trial(how: _Trial, question: Question, factor: float, seed: int) -> tuple[float, float]:
    """Score of the labeling at one factor, and the ratio of lengths that it finds."""
    part = enlarged(question.part, factor)
    trial = question.with_part(part)
    similarity = how.similarity(trial, part.trusted_spectra(part.sparse.vertices))
    problem = labeling_problem(trial, similarity, np.random.default_rng(seed))
    labeling = how.labeling(problem)
    rows = np.arange(len(part.sparse))
    shifts = similarity.shape[2]
    at = np.round(labeling.rotations / (2 * np.pi) * shifts).astype(np.int64) % shifts
    alike = similarity[rows, labeling.labels, at]
    ratio, spread = length_ratio(problem, labeling)
    return float(alike.mean()) - spread, ratio


def _sketched(problem: Problem) -> Labeling:
    """A labeling without growth, enough to tell factors 1.26 apart; half of the time.

    For 17 parts of animated animals the factors that were found in the end differed from those of
    :func:`_labeled` by as much as those of three seeds did.
    """
    return proposed_anchors(problem, first_labeling(problem), rounds=ROUNDS)


def _labeled(problem: Problem) -> Labeling:
    return find_anchors(problem, rounds=ROUNDS)
