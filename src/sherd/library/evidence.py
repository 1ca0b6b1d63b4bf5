"""Cheap evidence: which of many full shapes a part may belong to, before it is placed anywhere.

A few nodes of the part are labeled on the coarse surface of each full shape, and the energy is
compared with what it is when the nodes have each other's similarities
(:mod:`sherd.correspondence.plausibility`). This ratio knows neither the size nor the likeness to
itself of a shape, so those of different shapes can be compared. The part is described once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sherd.arrays import Singles
from sherd.correspondence.hints import without_ignored
from sherd.correspondence.labels.anchors import energy_ratio, first_labeling
from sherd.correspondence.labels.labeling import (
    SAME_SCALE,
    UNKNOWN_SCALE,
    Labeling,
    Problem,
    labeling_problem,
)
from sherd.correspondence.labels.labeling_data import Comparison
from sherd.correspondence.placements import node_similarity
from sherd.correspondence.plausibility import belonging_chance
from sherd.correspondence.question import Question
from sherd.correspondence.scale import length_ratio
from sherd.library.candidate import Candidate
from sherd.mesh.sizes import LARGEST_PART, SMALLEST_PART, check_areas
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.match_options import MatchOptions
from sherd.scan.intake import Intake
from sherd.surface.described import DescribedSurface
from sherd.surface.prepared import described_part
from sherd.surface.transformed import enlarged, thinned

__all__ = ["UNLIKE", "Evidence", "gathered_evidence"]

# A third of the nodes of a match: first labelings with all 200 put the same shape first.
NODES = 70
# A ratio of 1 says: no better than chance.
UNLIKE = 1.0
# Sizes sqrt(area) of a part of unknown scale, of 0.01 to 1.3 times the area of the full shape, as
# far apart as where a match looks for its scale: 1.25.
SIZES = np.geomspace(0.1, LARGEST_PART**0.5, 12)


@dataclass(frozen=True)
class Evidence:
    """What speaks for one full shape before anything is placed.

    Attributes
    ----------
    ratio
        Energy of the labeling over what it would be if nothing belonged together: a third where
        the part belongs, two thirds and more where it does not.
    share
        Area of the part over that of the full shape.
    refused
        Why the full shape is out of the question; empty if it is not.
    """

    ratio: float = UNLIKE
    share: float = 1.0
    refused: str = ""

    @property
    def chance(self) -> float:
        """That the part belongs there, by this evidence alone; 0 if out of the question."""
        return 0.0 if self.refused else belonging_chance(self.ratio, self.share)


def gathered_evidence(
    candidates: Sequence[Candidate], part: Intake, options: MatchOptions
) -> tuple[Evidence, ...]:
    """Evidence for each candidate, in their order.

    Raises
    ------
    InfeasibleError
        If the part has no area, or everything is ignored.
    """
    kept, _ = without_ignored(part, options)
    check_areas(kept)
    if options.scale == "unknown":
        return _of_any_size(candidates, kept, options)
    sizes = [kept.length * options.factor / each.length for each in candidates]
    possible = [SMALLEST_PART**0.5 <= size <= LARGEST_PART**0.5 for size in sizes]
    refusals = [_refusal(size) for size in sizes]
    if not any(possible):
        return tuple(Evidence(refused=refusal) for refusal in refusals)
    largest = max(size for size, fits in zip(sizes, possible, strict=True) if fits)
    # described as large as it is on any candidate: made smaller, its mesh is fine enough
    described = thinned(described_part(kept, kept.length / largest), NODES)
    return tuple(
        Evidence(_ratio(each, enlarged(described, size / largest), options), size**2) if fits
        else Evidence(refused=refusal)
        for each, size, fits, refusal in zip(candidates, sizes, possible, refusals, strict=True)
    )  # fmt: skip


def _refusal(size: float) -> str:
    share = f"the part has {size**2:.3g} times its area"
    if size**2 > LARGEST_PART:
        return f"{share}, and {LARGEST_PART} at most are possible"
    return f"{share}, too little to be found there"


def _ratio(candidate: Candidate, part: DescribedSurface, options: MatchOptions) -> float:
    rng = np.random.default_rng(options.seed)
    return energy_ratio(*_labeled(candidate, part, options, SAME_SCALE), rng)


def _of_any_size(
    candidates: Sequence[Candidate], kept: TriangleMesh, options: MatchOptions
) -> tuple[Evidence, ...]:
    """Evidence at the size of the part that fits each candidate best."""
    largest = float(SIZES[-1])
    described = thinned(described_part(kept, kept.length / largest), NODES)
    tried = [enlarged(described, float(size) / largest) for size in SIZES]
    found = []
    for each in candidates:
        trials = [_labeled(each, part, options, UNKNOWN_SCALE) for part in tried]
        best = int(np.argmax([_fit(*trial) for trial in trials]))
        ratio = energy_ratio(*trials[best], np.random.default_rng(options.seed))
        found.append(Evidence(ratio, float(SIZES[best]) ** 2))
    return tuple(found)


def _labeled(
    candidate: Candidate, part: DescribedSurface, options: MatchOptions, comparison: Comparison
) -> tuple[Problem, Labeling]:
    question = Question(candidate.coarse, part, comparison)
    spectra: Singles = part.trusted_spectra(part.sparse.vertices)
    similarity = node_similarity(question, spectra)
    problem = labeling_problem(question, similarity, np.random.default_rng(options.seed))
    return problem, first_labeling(problem)


def _fit(problem: Problem, labeling: Labeling) -> float:
    """Similarity that a labeling keeps, less how unevenly it changes lengths: as for the scale."""
    shifts = problem.similarity.shape[2]
    at = np.round(labeling.rotations / (2 * np.pi) * shifts).astype(np.int64) % shifts
    alike = problem.similarity[np.arange(len(labeling.labels)), labeling.labels, at]
    return float(alike.mean()) - length_ratio(problem, labeling)[1]
