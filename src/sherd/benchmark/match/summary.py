"""Rows and totals of a benchmark of `match`: what bench.json holds, and the same as text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from sherd._version import __version__
from sherd.benchmark.datasets.pairs import PairSet
from sherd.benchmark.match.measurement import BAD, THRESHOLDS
from sherd.benchmark.match.row import MatchRow
from sherd.benchmark.row_file import plain_row

__all__ = ["summary", "summary_table"]

MEANS = (
    "area_fraction", "present", "mean", "median", "near", "large", "flips", "mirror_forgiven",
    "coverage", "mean_matched", "recognized", "ranking", "iou", "iou_vertices",
)  # fmt: skip


def summary(pair_set: PairSet, rows: Sequence[MatchRow]) -> dict[str, Any]:
    """Rows, totals by kind and together, cumulative and calibration curves, for JSON.

    A total is the mean over the pairs that were answered; None where it is known of none.
    """
    kinds = dict.fromkeys(row.kind for row in rows)
    return {
        "version": __version__,
        "title": pair_set.title,
        "data": pair_set.data,
        "meshes": pair_set.meshes,
        "settings": asdict(pair_set.settings),
        "thresholds": THRESHOLDS.tolist(),
        "totals": {kind: _total([row for row in rows if row.kind == kind]) for kind in kinds},
        "together": _total(rows),
        "rows": [plain_row(row) for row in rows],
    }


def summary_table(document: Mapping[str, Any]) -> str:
    """The rows and totals of bench.json as text; errors times 100."""
    width = max([len(row["pair"]) for row in document["rows"]], default=4) + 2
    lines = [
        f"{'pair':<{width}}{'area':>6}{'mean':>7}{'median':>8}{'>0.1':>7}{'flips':>7}{'IoU':>7}"
        f"{'s':>7}"
    ]
    for row in document["rows"]:
        name = f"{row['pair']:<{width}}{row['area_fraction']:>6.2f}"
        if row["mean"] is None:
            lines.append(f"{name}  refused: the part is larger than the full shape")
            continue
        flips = "-" if row["flips"] is None else f"{row['flips']:.1%}"
        lines.append(
            f"{name}{100 * row['mean']:>7.2f}{100 * row['median']:>8.2f}{row['large']:>7.1%}"
            f"{flips:>7}{row['iou']:>7.3f}{sum(row['seconds'].values()):>7.1f}"
        )
    totals = dict(document["totals"])
    if len(totals) > 1:
        totals["together"] = document["together"]
    lines += [_sentence(kind, total) for kind, total in totals.items()]
    return "\n".join([*lines, f"{document['data']}."])


def _sentence(kind: str, total: Mapping[str, Any]) -> str:
    if total["mean"] is None:
        return f"{kind}: {total['pairs']} pairs, all refused"
    said = [
        f"{total['pairs']} pairs",
        f"mean error x100 {100 * total['mean']:.2f}",
        f"median {100 * total['median']:.2f}",
        f"region IoU {total['iou']:.3f} (vertices hit {total['iou_vertices']:.3f})",
        f"bad pairs {total['bad_pairs']}",
        f"coverage {total['coverage']:.1%}",
        f"calibration error {total['calibration_error']:.3f}",
        f"{total['seconds']:.1f} s a pair",
    ]
    if total["flips"] is not None:
        said.insert(5, f"flips {total['flips']:.1%}")
    if total["recognized"] is not None:
        said.append(f"vertices without a place recognized {total['recognized']:.1%}")
    if total["refused"]:
        said.append(f"{total['refused']} refused and not counted")
    return f"{kind}: {', '.join(said)}"


def _total(rows: Sequence[MatchRow]) -> dict[str, Any]:
    answered = [row for row in rows if row.answered]
    total: dict[str, Any] = {"pairs": len(rows), "refused": len(rows) - len(answered)}
    for name in MEANS:
        values = np.array([getattr(row, name) for row in answered], dtype=np.float64)
        total[name] = float(np.nanmean(values)) if np.isfinite(values).any() else None
    seconds = [sum(row.seconds.values()) for row in answered]
    names = dict.fromkeys(name for row in answered for name in row.seconds)
    total |= {
        "bad_pairs": sum(row.mean > BAD for row in answered),
        "worst": max((row.mean for row in answered), default=None),
        "seconds": _mean(seconds),
        # a machine that is busy for a while spoils the mean
        "seconds_median": float(np.median(seconds)) if answered else None,
        "template_seconds": _mean([row.template_seconds for row in answered]),
        "stages": {name: _mean([row.seconds.get(name, 0.0) for row in answered]) for name in names},
        "curve": np.mean([row.curve for row in answered], axis=0).tolist() if answered else [],
    }
    return total | _calibration(answered)


def _mean(values: list[float]) -> float | None:
    return float(np.mean(values)) if values else None


def _calibration(rows: list[MatchRow]) -> dict[str, Any]:
    if not rows:
        return {"calibration": [], "calibration_error": None}
    table = np.array([row.confidence for row in rows])  # (pairs, bins, 3)
    counts = table[:, :, 0]
    number = np.maximum(counts.sum(axis=0), 1)
    promised = (counts * table[:, :, 1]).sum(axis=0) / number
    kept = (counts * table[:, :, 2]).sum(axis=0) / number
    weights = counts.sum(axis=0) / max(counts.sum(), 1)
    return {
        "calibration": np.stack([weights, promised, kept], axis=1).tolist(),
        "calibration_error": float((weights * np.abs(promised - kept)).sum()),
    }
