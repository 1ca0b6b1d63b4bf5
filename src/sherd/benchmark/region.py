"""The region benchmark: overlap of the located with the true region, over many pairs."""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from sherd._version import __version__
from sherd.arrays import Bools
from sherd.benchmark.datasets.pairs import Pair
from sherd.benchmark.datasets.shrec16 import shrec16_pairs
from sherd.benchmark.metrics import region_overlap
from sherd.benchmark.row_file import stored_rows, write_rows
from sherd.benchmark.runner import measured_rows
from sherd.limits import require_whole
from sherd.locate import locate
from sherd.mesh.surface_points import SurfacePoints
from sherd.results.locate_options import LocateOptions
from sherd.shapes.rotation import rotated
from sherd.shapes.truth import true_region

__all__ = ["RegionRow", "region_benchmark", "region_table"]


@dataclass(frozen=True)
class RegionRow:
    """One pair: IoU with the true region, with it or its mirror image, and with the best
    of the reported placements; seconds of `locate` and of its stages after the eigenbasis.
    """  # noqa: D205

    pair: str
    area_fraction: float
    iou: float
    iou_mirror_forgiven: float
    iou_with_alternatives: float
    score: float
    status: str
    seconds: float
    seconds_after_eigenbasis: float


def region_benchmark(
    directory: Path,
    *,
    remeshed: Path | None = None,
    kind: str = "cuts",
    options: LocateOptions | None = None,
    limit: int | None = None,
    output: Path | None = None,
) -> list[RegionRow]:
    """Locate the parts of a SHREC'16 folder, each turned at random, one after the other.

    Writes ``bench.json`` to `output` after every pair, and takes up there what an earlier run of
    the same version and options already measured.
    """
    options = options or LocateOptions()
    if limit is not None:
        require_whole("limit", limit, 1, 10**6, "no data set has more pairs")
    pairs = shrec16_pairs(directory, kind=kind, remeshed=remeshed)[:limit]
    question = {
        "version": __version__,
        "kind": kind,
        "remeshed": remeshed is not None,
        "options": asdict(options),
    }
    known: dict[str, RegionRow] = {}
    if output is not None:
        stored = stored_rows(output / "bench.json", question, RegionRow)
        known = {row.pair: row for row in stored}

    def keep(name: str, row: RegionRow) -> None:
        known[name] = row
        if output is not None:
            write_rows(output / "bench.json", question, known.values())

    seeds = {files.name: number for number, files in enumerate(pairs)}
    return measured_rows(
        pairs,
        lambda files: _measured(files.load(), seeds[files.name], options),
        known=known,
        keep=keep,
    )


def region_table(rows: list[RegionRow]) -> str:
    """The rows and their means as text."""
    head = f"{'pair':<28}{'area':>6}{'IoU':>7}{'mirror':>8}{'any':>6}{'score':>7}{'s':>7}"
    lines = [head]
    lines += [
        f"{row.pair:<28}{row.area_fraction:>6.2f}{row.iou:>7.3f}{row.iou_mirror_forgiven:>8.3f}"
        f"{row.iou_with_alternatives:>6.2f}{row.score:>7.3f}{row.seconds:>7.1f}"
        for row in rows
    ]
    if rows:
        mean = {
            name: float(np.mean([getattr(row, name) for row in rows]))
            for name in ("area_fraction", "iou", "iou_mirror_forgiven", "iou_with_alternatives")
        }
        seconds = float(np.median([row.seconds for row in rows]))
        lines.append(
            f"{f'mean of {len(rows)} (seconds: median)':<28}{mean['area_fraction']:>6.2f}"
            f"{mean['iou']:>7.3f}{mean['iou_mirror_forgiven']:>8.3f}"
            f"{mean['iou_with_alternatives']:>6.2f}{'':>7}{seconds:>7.1f}"
        )
        lines.append("SHREC'16 training set; the method is not trained.")
    return "\n".join(lines)


def _measured(pair: Pair, seed: int, options: LocateOptions) -> RegionRow:
    start = time.perf_counter()
    region = locate(pair.full, rotated(pair.part, np.random.default_rng(seed)), options)
    seconds = time.perf_counter() - start
    truth = _truth_mask(pair, pair.truth)
    iou = region_overlap(pair.full, region.mask, truth)
    forgiven = iou
    if pair.mirrored_truth is not None:
        mirrored = _truth_mask(pair, pair.mirrored_truth)
        forgiven = max(iou, region_overlap(pair.full, region.mask, mirrored))
    others = [region_overlap(pair.full, other.mask, truth) for other in region.alternatives]
    return RegionRow(
        pair=pair.name,
        area_fraction=region.area_fraction,
        iou=iou,
        iou_mirror_forgiven=forgiven,
        iou_with_alternatives=max([iou, *others]),
        score=region.score,
        status=region.convergence.name,
        seconds=seconds,
        seconds_after_eigenbasis=seconds - region.timings["eigenbasis"],
    )


def _truth_mask(pair: Pair, truth: SurfacePoints) -> Bools:
    return true_region(pair.full, pair.part, truth)
