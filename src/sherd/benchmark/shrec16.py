"""SHREC'16 partial matching: error, region and time of :func:`sherd.match.match`, pair by pair.

Every vertex of every part is answered and counted. Each finished pair is one small file under
`output/pairs`, named by a hash of its input files, the version and the settings, so that an
interrupted run goes on where it stopped and a changed input is measured anew.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, fields
from functools import lru_cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sherd._version import __version__
from sherd.benchmark.datasets import Pair, PairFiles, rotated, shrec16_pairs
from sherd.benchmark.metrics import (
    GroundTruthDistances,
    cumulative_curve,
    region_overlap,
    vertex_mask,
)
from sherd.errors import OptionError
from sherd.match import MatchOptions, MatchResult, match
from sherd.mesh.files import read_mesh
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import Stages, write_text
from sherd.shapes.truth import true_region
from sherd.template import Template

__all__ = [
    "THRESHOLDS",
    "BenchmarkSettings",
    "MatchRow",
    "shrec16_benchmark",
    "shrec16_summary",
    "shrec16_table",
]

Floats = NDArray[np.float64]

# Errors at which the cumulative curve is kept, in sqrt(area): 0 to 0.25 as in the literature.
THRESHOLDS = np.round(np.linspace(0.0, 0.25, 51), 3)
# The error below which confidence promises an answer to be.
NEAR = 0.05
# A pair whose mean error is above this is a bad one.
BAD = 0.10
# A vertex is flipped if its answer is clearly nearer to the mirror map than to the truth.
FLIP_MARGIN = 0.02
CONFIDENCE_BINS = 10


@dataclass(frozen=True)
class BenchmarkSettings:
    """What is measured.

    Parameters
    ----------
    kinds
        ``"cuts"``, ``"holes"`` or both.
    rotate
        Turn every part at random.
    unknown_scale
        Scale every part by a random factor in [1/2, 2] and tell the method only that it is unknown.
    seed
        Seed of rotations, factors and of the method.

    Raises
    ------
    OptionError
        If a kind is unknown or none is given.
    """

    kinds: tuple[str, ...] = ("cuts", "holes")
    rotate: bool = False
    unknown_scale: bool = False
    seed: int = 0

    def __post_init__(self) -> None:
        if not self.kinds or set(self.kinds) - {"cuts", "holes"}:
            raise OptionError(f'kinds is {self.kinds}, but "cuts" and "holes" can be measured')


@dataclass(frozen=True)
class MatchRow:
    """What was measured on one pair; errors in units of sqrt(area of the full shape).

    Attributes
    ----------
    pair, kind
        Name of the part and ``"cuts"`` or ``"holes"``.
    area_fraction
        Area of the part over area of the full shape.
    mean, median, large
        Mean and median error of all vertices, and share of errors above 0.1.
    flips
        Share of vertices clearly nearer to the mirror map; NaN without one.
    coverage, mean_matched
        Share of vertices called matched, and their mean error.
    iou, iou_vertices
        Overlap of the region with the true region, sampled densely, and with the vertices that the
        true map hits.
    curve
        Share of errors at most each of `THRESHOLDS`.
    confidence
        Ten triples: number of vertices by tenth of confidence, their mean confidence, their
        share of errors below 0.05.
    scale_error
        Estimated over true scale; 1 where the scale was known.
    score, twin_score, status
        Of the result.
    seconds, template_seconds
        By stage of the match, and of preparing the full shape, once per class.
    """

    pair: str
    kind: str
    area_fraction: float
    mean: float
    median: float
    large: float
    flips: float
    coverage: float
    mean_matched: float
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


def shrec16_benchmark(
    directory: Path,
    *,
    output: Path,
    settings: BenchmarkSettings | None = None,
    remeshed: Path | None = None,
    only: tuple[str, ...] = (),
    jobs: int = 1,
) -> list[MatchRow]:
    """Match all pairs, write ``bench.json`` to `output`, and return the rows.

    Parameters
    ----------
    directory
        Folder of SHREC'16 with ``null``, ``cuts`` and ``holes``.
    output
        Where results go; what is found there already is not measured again.
    settings
        See :class:`BenchmarkSettings`.
    remeshed
        Folder with the parts meshed anew.
    only
        Names of the parts to measure; all if empty.
    jobs
        Processes; pairs of one class go to one process, which prepares the full shape once.

    Raises
    ------
    MeshFileError
        If a file is missing or damaged.
    OptionError
        If `jobs` is below 1.
    """
    if jobs < 1:
        raise OptionError(f"jobs is {jobs}, but at least 1 process is needed")
    settings = settings or BenchmarkSettings()
    files = [
        (kind, pair)
        for kind in settings.kinds
        for pair in shrec16_pairs(directory, kind=kind, remeshed=remeshed)
        if not only or pair.name in only
    ]
    keys = [_key(kind, pair, settings) for kind, pair in files]
    rows = {key: row for key in keys if (row := _stored(output, key)) is not None}
    waiting = [(key, *entry) for key, entry in zip(keys, files, strict=True) if key not in rows]
    stages = Stages(len(waiting))
    for key, row in _measured_all(waiting, settings, jobs):
        with stages(row.pair):
            rows[key] = row
            write_text(_place(output, key), json.dumps(asdict(row)) + "\n")
    stages.close()
    ordered = [rows[key] for key in keys]
    document = shrec16_summary(ordered, settings, remeshed=remeshed is not None)
    write_text(output / "bench.json", json.dumps(document, indent=1) + "\n")
    return ordered


def shrec16_summary(
    rows: list[MatchRow], settings: BenchmarkSettings, *, remeshed: bool
) -> dict[str, Any]:
    """Rows, totals by kind, cumulative and calibration curves, as plain numbers for JSON."""
    totals = {}
    for kind in settings.kinds:
        chosen = [row for row in rows if row.kind == kind]
        if chosen:
            totals[kind] = _total(chosen)
    return {
        "version": __version__,
        "data": "SHREC'16 training set; the method is not trained",
        "meshes": "remeshed" if remeshed else "as stored",
        "settings": asdict(settings),
        "thresholds": THRESHOLDS.tolist(),
        "totals": totals,
        "rows": [asdict(row) for row in rows],
    }


def shrec16_table(rows: list[MatchRow]) -> str:
    """The rows and their means as text; errors times 100."""
    lines = [
        f"{'pair':<26}{'area':>6}{'mean':>7}{'median':>8}{'>0.1':>7}{'flips':>7}{'IoU':>7}{'s':>7}"
    ]
    lines += [
        f"{row.pair:<26}{row.area_fraction:>6.2f}{100 * row.mean:>7.2f}{100 * row.median:>8.2f}"
        f"{row.large:>7.1%}{row.flips:>7.1%}{row.iou:>7.3f}{sum(row.seconds.values()):>7.1f}"
        for row in rows
    ]
    for kind in sorted({row.kind for row in rows}):
        total = _total([row for row in rows if row.kind == kind])
        lines.append(
            f"{kind}: {total['pairs']} pairs, mean error x100 {100 * total['mean']:.2f}, "
            f"region IoU {total['iou']:.3f} (vertices {total['iou_vertices']:.3f}), bad pairs "
            f"{total['bad_pairs']}, flips {total['flips']:.1%}, coverage {total['coverage']:.1%}, "
            f"calibration error {total['calibration_error']:.3f}, {total['seconds']:.1f} s a pair"
        )
    lines.append("SHREC'16 training set; the method is not trained.")
    return "\n".join(lines)


def _total(rows: list[MatchRow]) -> dict[str, Any]:
    def mean(name: str) -> float:
        values = np.array([getattr(row, name) for row in rows])
        return float(np.nanmean(values)) if np.isfinite(values).any() else float("nan")

    table = np.array([row.confidence for row in rows])  # (pairs, bins, 3)
    counts = table[:, :, 0]
    number = np.maximum(counts.sum(axis=0), 1)
    promised = (counts * table[:, :, 1]).sum(axis=0) / number
    kept = (counts * table[:, :, 2]).sum(axis=0) / number
    weights = counts.sum(axis=0) / max(counts.sum(), 1)
    return {
        "pairs": len(rows),
        **{name: mean(name) for name in ("mean", "median", "large", "flips", "coverage")},
        **{name: mean(name) for name in ("mean_matched", "iou", "iou_vertices")},
        "bad_pairs": sum(row.mean > BAD for row in rows),
        "worst": max(row.mean for row in rows),
        "seconds": float(np.mean([sum(row.seconds.values()) for row in rows])),
        "curve": np.mean([row.curve for row in rows], axis=0).tolist(),
        "calibration": np.stack([weights, promised, kept], axis=1).tolist(),
        "calibration_error": float((weights * np.abs(promised - kept)).sum()),
    }


def _measured_all(
    waiting: list[tuple[str, str, PairFiles]], settings: BenchmarkSettings, jobs: int
) -> Iterator[tuple[str, MatchRow]]:
    # pairs of one class one after another: the full shape is prepared once
    waiting = sorted(waiting, key=lambda entry: str(entry[2].full))
    if jobs == 1 or len(waiting) < 2:
        for key, kind, pair in waiting:
            yield key, _measured(kind, pair, settings)
        return
    groups = [
        [entry for entry in waiting if entry[2].full == full]
        for full in dict.fromkeys(entry[2].full for entry in waiting)
    ]
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        for batch in pool.map(_measured_group, groups, [settings] * len(groups)):
            yield from batch


def _measured_group(
    group: list[tuple[str, str, PairFiles]], settings: BenchmarkSettings
) -> list[tuple[str, MatchRow]]:
    import numba  # noqa: PLC0415

    numba.set_num_threads(1)  # the processes share the cores
    return [(key, _measured(kind, pair, settings)) for key, kind, pair in group]


@lru_cache(maxsize=1)
def _full_shape(path: Path) -> tuple[Template, float, GroundTruthDistances]:
    stages = Stages(visible=False)
    with stages("template"):
        template = Template(read_mesh(path))
        template.prepare()
    return template, stages.seconds["template"], GroundTruthDistances(template.full)


def _measured(kind: str, files: PairFiles, settings: BenchmarkSettings) -> MatchRow:
    template, template_seconds, distances = _full_shape(files.full)
    pair = files.load()
    seed = settings.seed + int(hashlib.sha256(pair.name.encode()).hexdigest()[:6], 16)
    part, factor = _presented(pair, settings, seed)
    scale = "unknown" if settings.unknown_scale else "same"
    result = match(template, part, MatchOptions(scale=scale, seed=settings.seed))
    return _row(kind, pair, result, distances, (factor, template_seconds))


def _presented(pair: Pair, settings: BenchmarkSettings, seed: int) -> tuple[TriangleMesh, float]:
    """The part as the method sees it, and the factor that would undo its scaling."""
    part = rotated(pair.part, seed) if settings.rotate else pair.part
    if not settings.unknown_scale:
        return part, 1.0
    factor = float(np.exp(np.random.default_rng(seed).uniform(-np.log(2), np.log(2))))
    return part.with_vertices(part.vertices / factor), factor


def _row(
    kind: str,
    pair: Pair,
    result: MatchResult,
    distances: GroundTruthDistances,
    known: tuple[float, float],
) -> MatchRow:
    factor, template_seconds = known
    answers, matched = result.point_map.points, result.point_map.matched
    errors = distances.between(pair.truth, answers)
    flips = float("nan")
    if pair.mirrored_truth is not None:
        mirrored = distances.between(pair.mirrored_truth, answers)
        flips = float((mirrored < errors - FLIP_MARGIN).mean())
    dense, hit = true_region(pair.full, pair.part, pair.truth), vertex_mask(pair.full, pair.truth)
    return MatchRow(
        pair=pair.name,
        kind=kind,
        area_fraction=pair.part.area / pair.full.area,
        mean=float(errors.mean()),
        median=float(np.median(errors)),
        large=float((errors > BAD).mean()),
        flips=flips,
        coverage=float(matched.mean()),
        mean_matched=float(errors[matched].mean()) if matched.any() else float("nan"),
        iou=region_overlap(pair.full, result.region.mask, dense),
        iou_vertices=region_overlap(pair.full, vertex_mask(pair.full, answers), hit),
        curve=cumulative_curve(errors, THRESHOLDS).tolist(),
        confidence=_reliability(result.point_map.confidence, errors <= NEAR),
        scale_error=result.scale / factor,
        score=result.scores["best"],
        twin_score=result.scores["mirrored twin"],
        status=result.status.name,
        seconds=dict(result.timings),
        template_seconds=template_seconds,
    )


def _reliability(confidence: Floats, near: NDArray[np.bool_]) -> list[list[float]]:
    tenth = np.minimum((confidence * CONFIDENCE_BINS).astype(np.int64), CONFIDENCE_BINS - 1)
    number = np.bincount(tenth, minlength=CONFIDENCE_BINS)
    safe = np.maximum(number, 1)
    promised = np.bincount(tenth, confidence, minlength=CONFIDENCE_BINS) / safe
    kept = np.bincount(tenth, near.astype(np.float64), minlength=CONFIDENCE_BINS) / safe
    table: list[list[float]] = np.stack([number, promised, kept], axis=1).astype(float).tolist()
    return table


def _key(kind: str, files: PairFiles, settings: BenchmarkSettings) -> str:
    """Hash of everything that the measurement depends on."""
    content = hashlib.sha256()
    question = {**asdict(settings), "kinds": kind, "version": __version__, "pair": files.name}
    content.update(json.dumps(question, sort_keys=True).encode())
    truth = files.part.with_suffix(".baryc_gt")
    for path in (files.full, files.part, truth):
        content.update(path.read_bytes() if path.exists() else b"")
    return content.hexdigest()[:24]


def _place(output: Path, key: str) -> Path:
    return output / "pairs" / f"{key}.json"


def _stored(output: Path, key: str) -> MatchRow | None:
    try:
        content = json.loads(_place(output, key).read_text(encoding="utf-8"))
        names = {field.name for field in fields(MatchRow)}
        return MatchRow(**content) if set(content) == names else None
    except (OSError, ValueError, TypeError):
        return None  # not measured yet, or written by another version
