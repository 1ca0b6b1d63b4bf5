"""One pair matched and measured: errors, region, confidence, time."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import rankdata

from sherd.arrays import Bools, Floats
from sherd.benchmark.metrics import (
    GroundTruthDistances,
    cumulative_curve,
    region_overlap,
    vertex_mask,
)
from sherd.benchmark.pairs import Pair, PairSource, rotated, seed_of
from sherd.either_side import match_either_side
from sherd.errors import InfeasibleError
from sherd.files.mesh_files import read_mesh
from sherd.match import MatchOptions, MatchResult, match
from sherd.mesh.point_cloud import PointCloud
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import Stages
from sherd.scan.surface_from_points import surface_from_points
from sherd.shapes.truth import true_region
from sherd.template import Template

__all__ = ["BAD", "NEAR", "THRESHOLDS", "BenchmarkSettings", "MatchRow", "measured"]


# Errors at which the cumulative curve is kept, in sqrt(area): 0 to 0.25 as in the literature.
THRESHOLDS = np.round(np.linspace(0.0, 0.25, 51), 3)
# The error below which confidence promises an answer to be.
NEAR = 0.05
# A vertex, or the mean of a pair, is bad above this error.
BAD = 0.10
# A vertex is flipped if its answer is clearly nearer to the mirror map than to the truth.
FLIP_MARGIN = 0.02
CONFIDENCE_BINS = 10
REFUSED = "REFUSED"


@dataclass(frozen=True)
class BenchmarkSettings:
    """How parts are shown to the method.

    Parameters
    ----------
    rotate
        Turn every part at random.
    unknown_scale
        Scale every part by a random factor in [1/2, 2] and tell the method only that it is unknown.
    points
        Take the faces from every part; which side is outside is then unknown as well.
    seed
        Seed of rotations, factors, cuts and of the method.
    """

    rotate: bool = False
    unknown_scale: bool = False
    points: bool = False
    seed: int = 0


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

    def plain(self) -> dict[str, Any]:
        """Names and values for JSON; NaN becomes None."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return {
            name: None if isinstance(value, float) and math.isnan(value) else value
            for name, value in values.items()
        }

    @classmethod
    def from_plain(cls, content: dict[str, Any]) -> MatchRow:
        """The row that :meth:`plain` gave.

        Raises
        ------
        TypeError
            If a name is missing or unknown.
        """
        values: dict[str, Any] = {
            name: math.nan if value is None else value for name, value in content.items()
        }
        return cls(**values)


def measured(source: PairSource, settings: BenchmarkSettings) -> MatchRow:
    """Match one pair and measure the answer.

    Raises
    ------
    MeshFileError
        If a file is missing or damaged.
    """
    template, template_seconds, distances = _full_shape(source.full)
    pair = source.load()
    seed = seed_of(pair.name, settings.seed)
    part, factor = _presented(pair.part, settings, seed)
    scale = "unknown" if settings.unknown_scale else "same"
    there = np.ones(part.vertex_count, dtype=bool) if pair.present is None else pair.present
    known: dict[str, Any] = {
        "pair": pair.name,
        "kind": source.kind,
        "seed": seed,
        "area_fraction": pair.part.area / pair.full.area,
        "present": float(there.mean()),
    }
    try:
        matching = match_either_side if settings.points else match
        result = matching(template, part, MatchOptions(scale=scale, seed=settings.seed))
    except InfeasibleError:
        return _refused(known)
    return MatchRow(
        **known,
        **_errors(pair, result, there, distances),
        **_recognition(result, there),
        **_regions(pair, result, there),
        scale_error=result.scale / factor,
        score=result.scores["best"],
        twin_score=result.scores["mirrored twin"],
        status=result.status.name,
        seconds=dict(result.timings),
        template_seconds=template_seconds,
    )


@lru_cache(maxsize=1)
def _full_shape(path: Path) -> tuple[Template, float, GroundTruthDistances]:
    stages = Stages(visible=False)
    with stages("template"):
        template = Template(read_mesh(path))
        template.prepare()
    return template, stages.seconds["template"], GroundTruthDistances(template.full)


def _presented(
    part: TriangleMesh, settings: BenchmarkSettings, seed: int
) -> tuple[TriangleMesh, float]:
    """The part as the method sees it, and the factor that would undo its scaling."""
    shown = rotated(part, seed) if settings.rotate else part
    if settings.points:
        shown = surface_from_points(PointCloud(shown.vertices, name=shown.name))
    if not settings.unknown_scale:
        return shown, 1.0
    factor = float(np.exp(np.random.default_rng(seed).uniform(-np.log(2), np.log(2))))
    return shown.with_vertices(shown.vertices / factor), factor


def _refused(known: dict[str, Any]) -> MatchRow:
    empty: dict[str, Any] = {"curve": [], "confidence": [], "seconds": {}, "status": REFUSED}
    names = {field.name for field in fields(MatchRow)} - set(known) - set(empty)
    unknown: dict[str, Any] = dict.fromkeys(names, math.nan)
    return MatchRow(**known, **empty, **unknown)


def _errors(
    pair: Pair, result: MatchResult, there: Bools, distances: GroundTruthDistances
) -> dict[str, Any]:
    answers = result.point_map.points[there]
    matched = result.point_map.matched[there]
    errors = distances.between(pair.truth[there], answers)
    flips = forgiven = math.nan
    if pair.mirrored_truth is not None:
        mirrored = distances.between(pair.mirrored_truth[there], answers)
        flips = float((mirrored < errors - FLIP_MARGIN).mean())
        forgiven = float(min(errors.mean(), mirrored.mean()))
    right = np.zeros(len(there), dtype=bool)
    right[there] = errors <= NEAR
    return {
        "mean": float(errors.mean()),
        "median": float(np.median(errors)),
        "near": float((errors <= NEAR).mean()),
        "large": float((errors > BAD).mean()),
        "flips": flips,
        "mirror_forgiven": forgiven,
        "coverage": float(matched.mean()),
        "mean_matched": float(errors[matched].mean()) if matched.any() else math.nan,
        "curve": cumulative_curve(errors, THRESHOLDS).tolist(),
        "confidence": _reliability(result.point_map.confidence, right),
    }


def _recognition(result: MatchResult, there: Bools) -> dict[str, Any]:
    """How well the vertices without a place are told from the others."""
    if there.all() or not there.any():
        return {"recognized": math.nan, "ranking": math.nan}
    rank = rankdata(result.point_map.confidence)
    count, others = int(there.sum()), int((~there).sum())
    # Mann and Whitney's statistic: the area under the receiver operating curve
    pairs_won = rank[there].sum() - count * (count + 1) / 2
    return {
        "recognized": float((~result.point_map.matched[~there]).mean()),
        "ranking": float(pairs_won / (count * others)),
    }


def _regions(pair: Pair, result: MatchResult, there: Bools) -> dict[str, Any]:
    dense = true_region(pair.full, pair.part, pair.truth, present=there)
    hit = vertex_mask(pair.full, pair.truth[there])
    return {
        "iou": region_overlap(pair.full, result.region.mask, dense),
        "iou_vertices": region_overlap(pair.full, result.region.mask, hit),
    }


def _reliability(confidence: Floats, near: Bools) -> list[list[float]]:
    tenth = np.minimum((confidence * CONFIDENCE_BINS).astype(np.int64), CONFIDENCE_BINS - 1)
    number = np.bincount(tenth, minlength=CONFIDENCE_BINS)
    safe = np.maximum(number, 1)
    promised = np.bincount(tenth, confidence, minlength=CONFIDENCE_BINS) / safe
    kept = np.bincount(tenth, near.astype(np.float64), minlength=CONFIDENCE_BINS) / safe
    table: list[list[float]] = np.stack([number, promised, kept], axis=1).astype(float).tolist()
    return table
