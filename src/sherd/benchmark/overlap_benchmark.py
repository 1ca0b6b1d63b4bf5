"""Run :func:`sherd.overlap.overlap` over the pairs of a data set, going on where a run stopped."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from sherd._version import __version__
from sherd.benchmark.datasets.overlaps import OverlapSet
from sherd.benchmark.overlap_measurement import OverlapRow, measured_overlap
from sherd.benchmark.runner import chosen_pairs, measured_pairs
from sherd.output import write_text
from sherd.report.stored.folder import plain

__all__ = ["BAD", "overlap_benchmark", "overlap_table"]

# The mean error above which a pair is bad.
BAD = 0.10


def overlap_benchmark(
    pair_set: OverlapSet,
    output: Path,
    *,
    only: tuple[str, ...] = (),
    limit: int | None = None,
    jobs: int = 1,
) -> dict[str, Any]:
    """Ask for all pairs, write ``bench.json``, and return what it holds.

    Parameters
    ----------
    pair_set
        The pairs of a data set and how they are shown.
    output
        Where results go; what is found there already is not measured again.
    only
        Names of the pairs to measure; all if empty.
    limit
        First pairs only, which are of all kinds.
    jobs
        Processes.

    Raises
    ------
    MeshFileError
        If a file is missing or damaged.
    OptionError
        If `jobs` or `limit` is below 1.
    OutputError
        If a result cannot be written.
    """
    settings = pair_set.settings
    rows = measured_pairs(
        chosen_pairs(pair_set.pairs, only, limit),
        partial(measured_overlap, settings=settings),
        kind=OverlapRow,
        output=output,
        settings=settings,
        jobs=jobs,
    )
    kinds = sorted({row.kind for row in rows})
    document = {
        "version": __version__,
        "title": pair_set.title,
        "data": pair_set.data,
        "meshes": pair_set.meshes,
        "settings": asdict(settings),
        "totals": {kind: _total([row for row in rows if row.kind == kind]) for kind in kinds},
        "together": _total(rows),
        "rows": [asdict(row) for row in rows],
    }
    written: dict[str, Any] = plain(document)
    write_text(output / "bench.json", json.dumps(written, indent=1, allow_nan=False) + "\n")
    return written


def overlap_table(document: dict[str, Any]) -> str:
    """The rows and totals of bench.json as text; errors times 100."""
    rows, totals = document["rows"], dict(document["totals"])
    width = max([len(row["pair"]) for row in rows], default=4) + 2
    head = ("share", "error", "median", "IoU", "IoU", "vIoU", "vIoU", "chance", "s")
    lines = [f"{'pair':<{width}}" + "".join(f"{name:>7}" for name in head) + "  status"]
    for row in rows:
        numbers = (
            _shown(row["share"], 2), _shown(row["mean"], 2, 100), _shown(row["median"], 2, 100),
            _shown(row["iou_first"], 3), _shown(row["iou_second"], 3),
            _shown(row["vertex_iou_first"], 3), _shown(row["vertex_iou_second"], 3),
            _shown(row["chance"], 2), _shown(row["seconds"], 1),
        )  # fmt: skip
        name, status = f"{row['pair']:<{width}}", row["status"].lower()
        lines.append(name + "".join(f"{text:>7}" for text in numbers) + f"  {status}")
    if len(totals) > 1:
        totals["together"] = document["together"]
    else:
        totals = {"together": document["together"]}
    lines += [_sentence(kind, total) for kind, total in totals.items()]
    return "\n".join([*lines, f"{document['data']}."])


def _sentence(kind: str, total: dict[str, Any]) -> str:
    return (
        f"{kind}: {total['pairs']} pairs, mean error x100 {_shown(total['mean'], 2, 100)}, pooled "
        f"{_shown(total['pooled'], 2, 100)}, IoU {_shown(total['iou'], 3)}, vertex IoU "
        f"{_shown(total['vertex_iou'], 3)}, bad pairs {total['bad_pairs']}, of them called good "
        f"{total['bad_called_good']}, right ones (error below 5) not called good "
        f"{total['right_not_called_good']}, {_shown(total['seconds_median'], 1)} s a pair"
    )


def _shown(value: float | None, digits: int, factor: float = 1.0) -> str:
    return "-" if value is None else f"{factor * value:.{digits}f}"


def _total(rows: Sequence[OverlapRow]) -> dict[str, Any]:
    known = [row for row in rows if not math.isnan(row.mean)]
    weights = [row.count for row in known]
    return {
        "pairs": len(rows),
        "mean": _mean([row.mean for row in known]),
        "pooled": float(np.average([row.mean for row in known], weights=weights))
        if known
        else None,
        "iou": _mean([row.iou for row in rows]),
        "vertex_iou": _mean([row.vertex_iou for row in rows]),
        "bad_pairs": sum(row.mean > BAD for row in known),
        "bad_called_good": sum(row.mean > BAD and row.status == "GOOD" for row in known),
        "right_not_called_good": sum(row.mean < BAD / 2 and row.status != "GOOD" for row in known),
        "seconds_median": float(np.median([row.seconds for row in rows])) if rows else None,
    }


def _mean(values: list[float]) -> float | None:
    known = [value for value in values if not math.isnan(value)]
    return float(np.mean(known)) if known else None
