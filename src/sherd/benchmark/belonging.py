"""Does the chance say whether a part belongs? Every part against its own and foreign shapes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import rankdata

from sherd.arrays import Floats
from sherd.benchmark.datasets.pairs import seed_of
from sherd.benchmark.datasets.shrec16 import PairFiles, shrec16_pairs
from sherd.benchmark.runner import measured_and_kept
from sherd.errors import InfeasibleError
from sherd.files.mesh_files import read_mesh
from sherd.limits import require_whole
from sherd.locate import locate
from sherd.match import match
from sherd.results.status import Status
from sherd.shapes.rotation import rotated
from sherd.spectral.surface_distances import SurfaceDistances
from sherd.surface.template import Template

__all__ = ["BelongingRow", "belonging_benchmark", "belonging_summary", "belonging_table"]

# A placement is right if its mean error is below this, in sqrt(area).
RIGHT = 0.05
TENTHS = 10


@dataclass(frozen=True)
class BelongingCase:
    """One part asked about on one full shape, its own or another's of the same area."""

    files: PairFiles
    full: Path

    @property
    def name(self) -> str:
        """Both names."""
        return f"{self.files.name} on {self.full.stem}"

    @property
    def own(self) -> bool:
        """Whether the part was cut from the full shape."""
        return self.full == self.files.full


@dataclass(frozen=True)
class BelongingRow:
    """What was said of one case.

    Attributes
    ----------
    case, own
        Its name, and whether the part was cut from the full shape.
    error
        Mean error of the match in sqrt(area) of the part's own shape; None on another's.
    chance, status
        Of the match; the status is ``"REFUSED"`` where it was infeasible, the chance then 0.
    locate_chance, locate_status
        The same of locate.
    """

    case: str
    own: bool
    error: float | None
    chance: float
    status: str
    locate_chance: float
    locate_status: str

    @property
    def right(self) -> bool:
        """Whether the placement is right."""
        return self.error is not None and self.error < RIGHT


def belonging_benchmark(
    directory: Path,
    output: Path,
    *,
    remeshed: Path | None = None,
    limit: int | None = None,
    jobs: int = 1,
) -> list[BelongingRow]:
    """Match and locate every cut of a SHREC'16 folder on its own shape and on one of another class.

    Parts are turned at random, and foreign ones scaled as if both wholes had one area. Writes
    ``belonging.json`` after every case, and goes on where an interrupted run stopped.

    Raises
    ------
    MeshFileError
        If a file is missing or damaged.
    OptionError
        If `limit` or `jobs` is below 1.
    OutputError
        If the result cannot be written.
    """
    if limit is not None:
        require_whole("pairs", limit, 1, 10**6, "no data set has more parts")
    parts = shrec16_pairs(directory, kind="cuts", remeshed=remeshed)
    fulls = sorted({part.full for part in parts})
    chosen = sorted(parts, key=lambda part: seed_of(part.name, 0))[:limit]
    cases = [BelongingCase(part, part.full) for part in chosen]
    for part in chosen:
        others = [full for full in fulls if full != part.full]
        if others:
            cases.append(BelongingCase(part, others[seed_of(part.name, 1) % len(others)]))
    cases.sort(key=lambda case: str(case.full))  # each full shape is prepared once
    return measured_and_kept(
        cases,
        _measured,
        kind=BelongingRow,
        name=lambda row: row.case,
        path=output / "belonging.json",
        inputs=[path for part in parts for path in part.inputs],
        settings={"remeshed": remeshed is not None},
        jobs=jobs,
    )


def belonging_summary(rows: Sequence[BelongingRow]) -> dict[str, Any]:
    """Areas under the ROC, shares of wrong verdicts, and the calibration by tenth of the chance.

    A foreign part is one on a shape that it was not cut from; a right one has an error below 0.05.
    """
    right = [row for row in rows if row.right]
    foreign = [row for row in rows if not row.own]
    summary: dict[str, Any] = {"right": len(right), "foreign": len(foreign)}
    for name, chance, status in (
        ("match", "chance", "status"),
        ("locate", "locate_chance", "locate_status"),
    ):
        good = np.array([getattr(row, chance) for row in right])
        bad = np.array([getattr(row, chance) for row in foreign])
        said = [getattr(row, status) == Status.GOOD.name for row in foreign]
        unsaid = [getattr(row, status) != Status.GOOD.name for row in right]
        summary[name] = {
            "area_under_roc": _area_under_roc(good, bad),
            "foreign_called_good": float(np.mean(said)) if said else None,
            "right_not_called_good": float(np.mean(unsaid)) if unsaid else None,
            "calibration": _calibration(good, bad),
        }
    return summary


def belonging_table(rows: Sequence[BelongingRow]) -> str:
    """The rows and the summary as text."""
    width = max([len(row.case) for row in rows], default=4) + 2
    lines = [f"{'case':<{width}}{'error':>7}{'match':>8}{'locate':>8}"]
    for row in rows:
        error = "-" if row.error is None else f"{100 * row.error:.2f}"
        lines.append(
            f"{row.case:<{width}}{error:>7}{row.chance:>8.2f}{row.locate_chance:>8.2f}  "
            f"{row.status.lower()}, {row.locate_status.lower()}"
        )
    summary = belonging_summary(rows)
    lines.append(f"{summary['right']} right placements, {summary['foreign']} foreign parts")
    for name in ("match", "locate"):
        found = summary[name]
        numbers = ", ".join(
            f"{key.replace('_', ' ')} {'-' if found[key] is None else format(found[key], '.3f')}"
            for key in ("area_under_roc", "foreign_called_good", "right_not_called_good")
        )
        lines.append(f"{name}: {numbers}")
        lines += [
            f"  said {low:.1f} to {low + 1 / TENTHS:.1f}: {count} cases, {kept:.0%} right"
            for low, count, kept in found["calibration"]
        ]
    return "\n".join(lines)


def _measured(case: BelongingCase) -> BelongingRow:
    template, distances = _full_shape(case.full)
    pair = case.files.load()
    rng = np.random.default_rng(seed_of(case.name, 0))
    part = rotated(pair.part, rng)
    part = part.with_vertices(part.vertices * template.length / pair.full.length)
    error, chance, status = None, 0.0, "REFUSED"
    try:
        result = match(template, part)
        chance, status = float(result.chance or 0.0), result.status.name
        if case.own:
            error = float(distances.between(pair.truth, result.points).mean())
    except InfeasibleError:
        pass
    where, verdict = 0.0, "REFUSED"
    try:
        region = locate(template, part)
        where, verdict = float(region.chance or 0.0), region.doubts.status.name
    except InfeasibleError:
        pass
    return BelongingRow(case.name, case.own, error, chance, status, where, verdict)


@lru_cache(maxsize=1)
def _full_shape(path: Path) -> tuple[Template, SurfaceDistances]:
    template = Template(read_mesh(path))
    template.prepare()
    return template, SurfaceDistances(template.full)


def _area_under_roc(good: Floats, bad: Floats) -> float | None:
    """Chance that a right placement has the larger number (Mann and Whitney's statistic)."""
    if not len(good) or not len(bad):
        return None
    ranks = rankdata(np.concatenate([good, bad]))[: len(good)]
    return float((ranks.sum() - len(good) * (len(good) + 1) / 2) / (len(good) * len(bad)))


def _calibration(good: Floats, bad: Floats) -> list[tuple[float, int, float]]:
    """By tenth of the chance: its lower end, the number of cases, and the share of right ones."""
    chances = np.concatenate([good, bad])
    right = np.concatenate([np.ones(len(good)), np.zeros(len(bad))])
    tenth = np.minimum((chances * TENTHS).astype(np.int64), TENTHS - 1)
    return [
        (float(k / TENTHS), int((tenth == k).sum()), float(right[tenth == k].mean()))
        for k in range(TENTHS)
        if (tenth == k).any()
    ]
