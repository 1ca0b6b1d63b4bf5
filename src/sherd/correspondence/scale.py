"""Unknown scale: how much larger the part must be to fit the full shape."""

from __future__ import annotations

import numpy as np

from sherd.correspondence.anchors import find_anchors
from sherd.correspondence.labeling import EVEN_SETTINGS, Labeling, Problem, make_problem
from sherd.correspondence.part_data import PartData, part_spectra, rescaled, trusted_by_cut
from sherd.descriptors.rotation_shot import pooled_similarity
from sherd.template import Template

__all__ = ["LARGEST", "LARGEST_AREA", "estimated_scale", "length_ratio"]


# The range that users are promised, and a grid over it: a neighborhood that is a tenth too
# large is still recognized.
LARGEST = 2.0
GRID = 7
# A part is not larger than the whole, but the skin may stretch.
LARGEST_AREA = 1.3
# Lengths below this are dominated by the spacing of labels, above it by the cut.
SHORTEST, LONGEST = 0.08, 0.5
REFINEMENTS = 2


def estimated_scale(template: Template, part: PartData, rng: np.random.Generator) -> float:
    """The factor in [1/2, 2] by which `part` must be enlarged.

    The part is labeled at each factor of a grid, as far as it does not become larger than the full
    shape; the factor whose labeling keeps the most similarity and the most even ratio of lengths
    wins, and is then corrected by that ratio.
    """
    largest = min(LARGEST, float(np.sqrt(LARGEST_AREA * template.unit.area / part.mesh.area)))
    factors = np.geomspace(1 / LARGEST, LARGEST, GRID)
    factors = factors[: max(1, int((factors <= largest).sum()))]
    trials = [_trial(template, part, float(factor), rng) for factor in factors]
    best = int(np.argmax([score for score, _ in trials]))
    factor = float(factors[best]) * trials[best][1]
    for _ in range(REFINEMENTS):
        factor = float(np.clip(factor, 1 / LARGEST, largest))
        factor *= _trial(template, part, factor, rng)[1]
    return float(np.clip(factor, 1 / LARGEST, largest))


def length_ratio(problem: Problem, labeling: Labeling) -> tuple[float, float]:
    """Median ratio of full to part length over safe edges, and the median deviation of its log."""
    edges, measures = problem.edges, problem.measures
    length = measures[:, 0]
    ends = labeling.labels[edges]
    distance = problem.template.label_to_label[ends[:, 0], ends[:, 1]]
    use = (length > SHORTEST) & (length < LONGEST) & (measures[:, 2] == 1.0) & (distance > 0)
    if use.sum() < 20:
        use = (length > 0) & (distance > 0)
    if not use.any():
        return 1.0, np.inf
    ratios = np.log(distance[use] / length[use])
    middle = float(np.median(ratios))
    return float(np.exp(middle)), float(np.median(np.abs(ratios - middle)))


def _trial(
    template: Template, part: PartData, factor: float, rng: np.random.Generator
) -> tuple[float, float]:
    """Score of the labeling at one factor, and the ratio of lengths that it finds."""
    data = rescaled(part, factor)
    spectra = trusted_by_cut(data, data.nodes, part_spectra(data, data.nodes))
    similarity = pooled_similarity(
        template.spectra, spectra, template.cells, len(template.label_vertices)
    )
    own_rng = np.random.default_rng(rng.integers(2**32))
    problem = make_problem(template, data, similarity, own_rng, settings=EVEN_SETTINGS)
    labeling = find_anchors(problem, rounds=2)
    rows = np.arange(len(data.nodes))
    shifts = similarity.shape[2]
    at = np.round(labeling.rotations / (2 * np.pi) * shifts).astype(np.int64) % shifts
    alike = similarity[rows, labeling.labels, at]
    ratio, spread = length_ratio(problem, labeling)
    return float(alike.mean()) - spread, ratio
