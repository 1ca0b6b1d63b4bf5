"""One pair matched, and the answer compared with the truth."""

from __future__ import annotations

import math
from dataclasses import fields
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import rankdata

from sherd.arrays import Bools, Floats
from sherd.benchmark.datasets.pairs import BenchmarkSettings, Pair, PairSource, seed_of
from sherd.benchmark.match.row import REFUSED, MatchRow
from sherd.benchmark.metrics import cumulative_curve, region_overlap, vertex_mask
from sherd.errors import InfeasibleError
from sherd.files.mesh_files import read_mesh
from sherd.match import match
from sherd.mesh.point_cloud import PointCloud
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import Stages
from sherd.results.match_options import MatchOptions
from sherd.results.match_result import MatchResult
from sherd.scan.intake import Intake, scan_intake
from sherd.shapes.rotation import rotated
from sherd.shapes.truth import true_region
from sherd.spectral.surface_distances import SurfaceDistances
from sherd.surface.template import Template

__all__ = ["BAD", "NEAR", "THRESHOLDS", "measured"]


# Errors at which the cumulative curve is kept, in sqrt(area): 0 to 0.25 as in the literature.
THRESHOLDS = np.round(np.linspace(0.0, 0.25, 51), 3)
# The error below which confidence promises an answer to be.
NEAR = 0.05
# A vertex, or the mean of a pair, is bad above this error.
BAD = 0.10
# A vertex is flipped if its answer is clearly nearer to the mirror map than to the truth.
FLIP_MARGIN = 0.02
CONFIDENCE_BINS = 10


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
    options = MatchOptions(
        scale="unknown" if settings.unknown_scale else "same", seed=settings.seed
    )
    there = np.ones(len(pair.truth), dtype=bool) if pair.present is None else pair.present
    known: dict[str, Any] = {
        "pair": pair.name,
        "kind": source.kind,
        "seed": seed,
        "area_fraction": pair.part.area / pair.full.area,
        "present": float(there.mean()),
    }
    try:
        result = match(template, part, options)
    except InfeasibleError:
        return _refused(known)
    return MatchRow(
        **known,
        **_errors(pair, result, there, distances),
        **_recognition(result, there),
        **_regions(pair, result.best.mask, there),
        scale_error=result.scale / factor,
        score=result.best.score,
        twin_score=_known(result.twin_score),
        status=result.status.name,
        seconds=dict(result.timings),
        template_seconds=template_seconds,
    )


@lru_cache(maxsize=1)
def _full_shape(path: Path) -> tuple[Template, float, SurfaceDistances]:
    stages = Stages(visible=False)
    with stages("template"):
        template = Template(read_mesh(path))
        template.prepare()
    return template, stages.seconds["template"], SurfaceDistances(template.full)


def _presented(part: TriangleMesh, settings: BenchmarkSettings, seed: int) -> tuple[Intake, float]:
    """The part as the method sees it, and the factor that would undo its scaling."""
    shown = rotated(part, np.random.default_rng(seed)) if settings.rotate else part
    factor = 1.0
    if settings.unknown_scale:
        factor = float(np.exp(np.random.default_rng(seed).uniform(-np.log(2), np.log(2))))
        shown = shown.with_vertices(shown.vertices / factor)
    source = PointCloud(shown.vertices, name=shown.name) if settings.points else shown
    return scan_intake(source), factor


def _known(number: float | None) -> float:
    return math.nan if number is None else number


def _refused(known: dict[str, Any]) -> MatchRow:
    empty: dict[str, Any] = {"curve": [], "confidence": [], "seconds": {}, "status": REFUSED}
    names = {field.name for field in fields(MatchRow)} - set(known) - set(empty)
    unknown: dict[str, Any] = dict.fromkeys(names, math.nan)
    return MatchRow(**known, **empty, **unknown)


def _errors(
    pair: Pair, answers: MatchResult, there: Bools, distances: SurfaceDistances
) -> dict[str, Any]:
    points, matched = answers.points[there], answers.matched[there]
    errors = distances.between(pair.truth[there], points)
    flips = forgiven = math.nan
    if pair.mirrored_truth is not None:
        mirrored = distances.between(pair.mirrored_truth[there], points)
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
        "confidence": _reliability(answers.confidence, right),
    }


def _recognition(answers: MatchResult, there: Bools) -> dict[str, Any]:
    """How well the vertices without a place are told from the others."""
    if there.all() or not there.any():
        return {"recognized": math.nan, "ranking": math.nan}
    rank = rankdata(answers.confidence)
    count, others = int(there.sum()), int((~there).sum())
    # Mann and Whitney's statistic: the area under the receiver operating curve
    pairs_won = rank[there].sum() - count * (count + 1) / 2
    return {
        "recognized": float((~answers.matched[~there]).mean()),
        "ranking": float(pairs_won / (count * others)),
    }


def _regions(pair: Pair, region: Bools, there: Bools) -> dict[str, Any]:
    dense = true_region(pair.full, pair.part, pair.truth, present=there)
    hit = vertex_mask(pair.full, pair.truth[there])
    return {
        "iou": region_overlap(pair.full, region, dense),
        "iou_vertices": region_overlap(pair.full, region, hit),
    }


def _reliability(confidence: Floats, near: Bools) -> list[list[float]]:
    tenth = np.minimum((confidence * CONFIDENCE_BINS).astype(np.int64), CONFIDENCE_BINS - 1)
    number = np.bincount(tenth, minlength=CONFIDENCE_BINS)
    safe = np.maximum(number, 1)
    promised = np.bincount(tenth, confidence, minlength=CONFIDENCE_BINS) / safe
    kept = np.bincount(tenth, near.astype(np.float64), minlength=CONFIDENCE_BINS) / safe
    table: list[list[float]] = np.stack([number, promised, kept], axis=1).astype(float).tolist()
    return table
