"""What is measured on one pair: errors, region, confidence, time."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["REFUSED", "MatchRow"]


# Status of a pair that `match` refused as infeasible.
REFUSED = "REFUSED"


@dataclass(frozen=True)
class MatchRow:
    """What was measured on one pair; errors in units of sqrt(area of the full shape).

    What is unknown is NaN; of a pair that `match` refused, everything but the first five and
    `status` is.

    Attributes
    ----------
    pair, kind, seed
        Name of the part, the group it is averaged in, and the seed of its rotation, factor and cut.
    area_fraction
        Area of the part over area of the full shape.
    present
        Share of the part's vertices that have a true place on the full shape. All errors, flips and
        `coverage` are of these.
    mean, median, near, large
        Mean and median error, share of errors at most 0.05 and above 0.1.
    flips, mirror_forgiven
        Share of vertices clearly nearer to the mirror map, and the mean error with respect to the
        true or the mirror map, whichever is smaller; NaN without a mirror map.
    coverage, mean_matched
        Share of vertices called matched, and their mean error.
    recognized, ranking
        Share of the vertices without a true place that are unmatched, and the chance that such
        a vertex has less confidence than one that has a place; NaN if all are present.
    iou, iou_vertices
        Overlap of the region with the true region, sampled densely, and with the vertices that the
        true map hits. These have gaps, the more the coarser the part: a perfect region has 0.93 on
        parts as dense as the full shape.
    curve
        Share of errors at most each of `THRESHOLDS`.
    confidence
        Ten triples: number of vertices by tenth of confidence, their mean confidence, their
        share of errors below 0.05; a vertex that is not present counts as wrong.
    scale_error
        Estimated over true scale; 1 where the scale was known.
    score, twin_score, status
        Of the result; the status is ``"REFUSED"`` if `match` refused the pair as infeasible.
    seconds, template_seconds
        By stage of the match, and of preparing the full shape, once for all its parts.
    """

    pair: str
    kind: str
    seed: int
    area_fraction: float
    present: float
    mean: float
    median: float
    near: float
    large: float
    flips: float
    mirror_forgiven: float
    coverage: float
    mean_matched: float
    recognized: float
    ranking: float
    iou: float
    iou_vertices: float
    curve: list[float]
    confidence: list[list[float]]
    scale_error: float
    score: float
    twin_score: float
    status: str
    seconds: dict[str, float]
    template_seconds: float

    @property
    def answered(self) -> bool:
        """Whether `match` gave an answer at all."""
        return self.status != REFUSED
