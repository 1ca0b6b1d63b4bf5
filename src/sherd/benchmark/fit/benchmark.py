"""Fit the pairs of a folder, going on where a run stopped, and say what was measured."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict, fields
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from sherd._version import __version__
from sherd.benchmark.fit.baselines import has_libigl, require_icp
from sherd.benchmark.fit.measurement import WAYS, FitRow, Quality, measured_fit
from sherd.benchmark.fit.sources import fit_sources
from sherd.benchmark.runner import measured_rows
from sherd.limits import require_whole
from sherd.output import write_text
from sherd.report.stored.folder import plain

__all__ = ["fit_benchmark", "fit_table"]

NAMES = {"fit": "sherd fit", "arap": "libigl ARAP, same map", "icp": "nricp_amberg, same map"}


def fit_benchmark(
    directory: Path,
    output: Path,
    *,
    poses: int = 2,
    cuts: tuple[str, ...] = (),
    limit: int | None = None,
    with_icp: bool = False,
    jobs: int = 1,
) -> list[FitRow]:
    """Fit the pairs of a folder, with the baselines in the same run.

    Writes ``fit.json`` after every pair, and goes on where an interrupted run stopped.

    Parameters
    ----------
    directory, poses
        As in :func:`sherd.benchmark.fit.sources.fit_sources`.
    output
        Folder.
    cuts, limit
        Kinds of cuts, and how many pairs; all if not given.
    with_icp
        Whether to run trimesh's non-rigid ICP too, which takes minutes a pair.
    jobs
        Processes.

    Raises
    ------
    MeshFileError
        If a file is missing or damaged.
    OptionError
        If `poses`, `limit` or `jobs` is below 1, or the ICP cannot run.
    OutputError
        If the result cannot be written.
    """
    if with_icp:
        require_icp()
    require_whole("poses", poses, 1, 10**4, "no animation has more poses")
    if limit is not None:
        require_whole("pairs", limit, 1, 10**6, "no folder has more pairs")
    sources = [each for each in fit_sources(directory, poses) if not cuts or each.cut in cuts]
    path = output / "fit.json"
    known = {row.name: row for row in _stored(path)}

    def keep(name: str, row: FitRow) -> None:
        known[name] = row
        content = {"version": __version__, "rows": [asdict(each) for each in known.values()]}
        write_text(path, json.dumps(plain(content), indent=1, allow_nan=False) + "\n")

    measure = partial(measured_fit, with_icp=with_icp)
    return measured_rows(sources[:limit], measure, known=dict(known), keep=keep, jobs=jobs)


def fit_table(rows: Sequence[FitRow]) -> str:
    """The rows and means as text; errors times 100."""
    width = max([len(row.name) for row in rows], default=6) + 2
    head = "  seen hidden near cut turned  area new crossings  seconds"
    lines = [f"{'pair':<{width}}{'match':<10}{head}"]
    for row in rows:
        lines.append(f"{row.name:<{width}}{row.status:<10}{_words(row.fit)}")
        lines += [
            f"{'':<{width}}{way:<10}{_words(getattr(row, way))}"
            for way in WAYS[1:]
            if not math.isnan(getattr(row, way).seen)
        ]
    for group in [*sorted({row.group for row in rows}), "all"]:
        some = [row for row in rows if group in (row.group, "all")]
        for way in WAYS:
            measured = [getattr(row, way) for row in some]
            measured = [each for each in measured if not math.isnan(each.seen)]
            if measured:
                lines.append(f"{group}, {NAMES[way]} ({len(measured)}): {_words(_means(measured))}")
    lines += _calibration_lines(rows)
    if not has_libigl():
        lines.append("libigl is not installed, so ARAP was not measured: pip install libigl")
    return "\n".join(lines)


def _means(measured: Sequence[Quality]) -> Quality:
    """Means, but of turned faces the sum."""
    means: dict[str, Any] = {
        each.name: float(np.nanmean([getattr(m, each.name) for m in measured]))
        for each in fields(Quality)
    }
    return Quality(**(means | {"turned": sum(each.turned for each in measured)}))


def _words(each: Quality) -> str:
    return (
        f"{100 * each.seen:6.2f} {100 * each.hidden:6.2f} {100 * each.near_cut:8.2f} "
        f"{each.turned:6d} {each.area_kept:5.3f} {100 * each.intersecting:11.3f} % "
        f"{each.seconds:8.1f}"
    )


def _calibration_lines(rows: Sequence[FitRow]) -> list[str]:
    """How often vertices were near, beside the chance that was promised."""
    counts = np.array([row.calibration for row in rows if row.calibration])
    if not len(counts):
        return []
    total = counts.sum(axis=0)
    said = [
        f"{10 * k}-{10 * k + 10} %: {100 * hits / count:.0f} % of {count}"
        for k, (count, hits) in enumerate(total.tolist())
        if count
    ]
    return ["near where the chance was " + ", ".join(said)]


def _stored(path: Path) -> list[FitRow]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        if content["version"] != __version__:
            return []
        return [_row(row) for row in content["rows"]]
    except (OSError, ValueError, KeyError, TypeError):
        return []  # no file yet, or one of another version


def _row(stored: dict[str, Any]) -> FitRow:
    pairs = tuple((int(count), int(hits)) for count, hits in stored["calibration"])
    qualities = {way: _quality(stored[way]) for way in WAYS}
    return FitRow(**{**stored, **qualities, "calibration": pairs})


def _quality(stored: dict[str, Any]) -> Quality:
    known: dict[str, Any] = {
        name: math.nan if value is None else value for name, value in stored.items()
    }
    return Quality(**known)
