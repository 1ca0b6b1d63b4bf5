"""One pair of incomplete shapes asked for what they share, and the answer compared with the truth.

Vertex IoU and the pooled error are the official protocol of CP2P, PSMAL and BeCoS (Ehm et al.,
*Echoes in the correspondence*, 2025): IoU of the predicted with the true overlap on each shape, and
a geodesic error in units of sqrt(area of the whole) over all truly shared vertices.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sherd.arrays import Bools
from sherd.benchmark.datasets.overlaps import OverlapPair, OverlapSource
from sherd.benchmark.datasets.pairs import BenchmarkSettings, seed_of
from sherd.benchmark.metrics import region_overlap
from sherd.output import Stages
from sherd.overlap import overlap
from sherd.results.overlap_options import OverlapOptions
from sherd.results.overlap_result import Overlap
from sherd.shapes.rotation import rotated
from sherd.spectral.surface_distances import SurfaceDistances

__all__ = ["OverlapRow", "measured_overlap"]


@dataclass(frozen=True)
class OverlapRow:
    """What was measured on one pair; errors in units of sqrt(area of the whole).

    Attributes
    ----------
    pair, kind
        Name, and the group it is averaged in.
    share
        Truly shared area over the area of the larger shape.
    mean, median, count
        Error over all truly shared vertices of the second shape, answered or not, and their number;
        NaN and 0 if none is shared.
    iou_first, iou_second
        Overlap of the found with the true region of each shape, by area.
    vertex_iou_first, vertex_iou_second
        The same, each vertex counting once.
    there_and_back
        Mean distance between matched vertices and what comes back, in edges.
    chance, status
        Of the result.
    seconds
        Of the whole, and by stage.
    """

    pair: str
    kind: str
    share: float
    mean: float
    median: float
    count: int
    iou_first: float
    iou_second: float
    vertex_iou_first: float
    vertex_iou_second: float
    there_and_back: float
    chance: float
    status: str
    seconds: float
    stages: dict[str, float]

    @property
    def iou(self) -> float:
        """Mean of both shapes, by area."""
        return 0.5 * (self.iou_first + self.iou_second)

    @property
    def vertex_iou(self) -> float:
        """Mean of both shapes, by vertices."""
        return 0.5 * (self.vertex_iou_first + self.vertex_iou_second)


def measured_overlap(source: OverlapSource, settings: BenchmarkSettings) -> OverlapRow:
    """Ask for one pair and measure the answer.

    Raises
    ------
    MeshFileError
        If a file is missing or damaged.
    """
    pair = source.load()
    rng = np.random.default_rng(seed_of(pair.name, settings.seed))
    first, second = pair.first, pair.second
    if settings.rotate:
        first, second = rotated(first, rng), rotated(second, rng)
    scale = "same"
    if settings.unknown_scale:
        scale = "unknown"
        second = second.with_vertices(second.vertices * math.exp(rng.uniform(-1, 1) * math.log(2)))
    stages = Stages(visible=False)
    options = OverlapOptions(scale="unknown" if scale == "unknown" else "same", seed=settings.seed)
    result = overlap(first, second, options, stages=stages)
    return row_of(pair, source.kind, result, stages)


def row_of(pair: OverlapPair, kind: str, result: Overlap, stages: Stages) -> OverlapRow:
    """The answer to one pair compared with its truth."""
    rows = np.flatnonzero(pair.second_shared)
    mean = median = math.nan
    if len(rows):
        answers = result.second_to_first.points[rows]
        errors = SurfaceDistances(pair.first).between(pair.truth[rows], answers)
        errors *= pair.first.length / pair.length
        mean, median = float(errors.mean()), float(np.median(errors))
    one, other = result.first_to_second.matched, result.second_to_first.matched
    shared = float(pair.first.vertex_areas @ pair.first_shared)
    return OverlapRow(
        pair=pair.name,
        kind=kind,
        share=shared / max(pair.first.area, pair.second.area),
        mean=mean,
        median=median,
        count=len(rows),
        iou_first=region_overlap(pair.first, one, pair.first_shared),
        iou_second=region_overlap(pair.second, other, pair.second_shared),
        vertex_iou_first=_vertex_overlap(one, pair.first_shared),
        vertex_iou_second=_vertex_overlap(other, pair.second_shared),
        there_and_back=result.check().there_and_back,
        chance=result.chance,
        status=result.status.name,
        seconds=sum(stages.seconds.values()),
        stages=dict(stages.seconds),
    )


def _vertex_overlap(found: Bools, true: Bools) -> float:
    union = int((found | true).sum())
    return float((found & true).sum()) / union if union else math.nan
