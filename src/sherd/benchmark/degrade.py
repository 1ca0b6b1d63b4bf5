"""Accuracy of match against what is wrong with the part: noise, uneven density, clutter and so on.

One part of the generated animal is spoiled in one way at a time, a little more at each step; the
first level of each kind is the clean part. Everything has exact ground truth.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from sherd._version import __version__
from sherd.benchmark.metrics import evenly_spread
from sherd.benchmark.paper.drawing import check_plotting, draw_curves
from sherd.benchmark.row_file import stored_rows, write_rows
from sherd.match import match
from sherd.mesh.point_cloud import PointCloud
from sherd.scan.intake import scan_intake
from sherd.scan.surface_from_points import surface_from_points
from sherd.shapes.creature import creature
from sherd.shapes.fragment import (
    Fragment,
    cut_by_plane,
    cut_in_pieces,
    largest_piece,
    moved,
    noisy,
    punch_holes,
    remeshed,
    reordered,
    unevenly_sampled,
    whole,
    with_clutter,
    with_flipped_faces,
)
from sherd.spectral.surface_distances import SurfaceDistances
from sherd.surface.template import Template

__all__ = ["KINDS", "DegradeRow", "degrade_benchmark", "degrade_table"]

Spoil = Callable[[Fragment, float, np.random.Generator], Fragment]

HOLE_RADIUS = 0.02
BAND = 0.03


@dataclass(frozen=True)
class Kind:
    """One way to spoil a part: what is varied, its levels (the first is clean), and how.

    From level `blind` on the part does not tell its outside, and both sides are tried.
    """

    label: str
    levels: tuple[float, ...]
    spoil: Spoil
    blind: float = np.inf


def _clutter(fragment: Fragment, level: float, rng: np.random.Generator) -> Fragment:
    return with_clutter(fragment, level, rng=rng) if level > 0 else fragment


def _cloud(fragment: Fragment, level: float, rng: np.random.Generator) -> Fragment:
    """From level 1 on without faces, in random order; from 2 on without normals."""
    if level < 1:
        return fragment
    shuffled = reordered(fragment, rng)
    normals = shuffled.mesh.vertex_normals if level < 2 else None
    return replace(shuffled, mesh=surface_from_points(PointCloud(shuffled.mesh.vertices, normals)))


def _noisy_cloud(fragment: Fragment, level: float, rng: np.random.Generator) -> Fragment:
    """From above level 0 on without faces and normals."""
    return _cloud(noisy(fragment, level / 100, rng=rng), 2.0, rng) if level > 0 else fragment


KINDS: dict[str, Kind] = {
    "noise": Kind(
        "Gaussian noise, % of sqrt(area)",
        (0.0, 0.1, 0.2, 0.3, 0.5),
        lambda part, level, rng: noisy(part, level / 100, rng=rng),
    ),
    "density": Kind(
        "densest over sparsest sampling",
        (1.0, 3.0, 10.0, 30.0),
        lambda part, level, rng: unevenly_sampled(part, level),  # noqa: ARG005 nothing is random
    ),
    "clutter": Kind(
        "area that belongs nowhere, share of the part", (0.0, 0.02, 0.05, 0.1), _clutter
    ),
    "holes": Kind(
        "number of small holes",
        (0.0, 5.0, 10.0, 20.0),
        lambda part, level, rng: punch_holes(part, int(level), radius=HOLE_RADIUS, rng=rng),
    ),
    "flipped": Kind(
        "share of the faces turned over",
        (0.0, 0.1, 0.3, 0.5),
        lambda part, level, rng: with_flipped_faces(part, level, rng=rng),
    ),
    "pieces": Kind(
        "number of slices",
        (1.0, 2.0, 3.0),
        lambda part, level, rng: cut_in_pieces(part, int(level), width=BAND),  # noqa: ARG005
    ),
    "points": Kind(
        "0: mesh, 1: its points and normals, 2: its points alone",
        (0.0, 1.0, 2.0),
        _cloud,
        blind=2.0,
    ),
    "noisy-points": Kind(
        "0: mesh; Gaussian noise of its points alone, % of sqrt(area)",
        (0.0, 0.1, 0.2, 0.3),
        _noisy_cloud,
        blind=0.1,
    ),
}


@dataclass(frozen=True)
class DegradeRow:
    """One spoiled part, matched.

    Attributes
    ----------
    kind, level
        Which of KINDS, and how much of it.
    error
        Mean geodesic error x100 over vertices that have a true place.
    coverage
        Share of these that are matched.
    recognized
        Share of the clutter's vertices that are unmatched; None without clutter.
    score
        Of the match.
    seconds
        Wall time of the match, the template being ready.
    """

    kind: str
    level: float
    error: float
    coverage: float
    recognized: float | None
    score: float
    seconds: float


def degrade_benchmark(
    output: Path,
    *,
    kinds: Sequence[str] = tuple(KINDS),
    vertex_count: int = 10_000,
    seed: int = 0,
) -> list[DegradeRow]:
    """Spoil, match and measure; write degrade.json and a curve for each kind as PNG.

    Rows that degrade.json holds already for the same version, size and seed are not computed
    again, so an interrupted run goes on.

    Raises
    ------
    OutputError
        If the folder cannot be written.
    OptionError
        If matplotlib is missing.
    """
    check_plotting()
    settings = {"sherd": __version__, "vertices": vertex_count, "seed": seed}
    path = output / "degrade.json"
    rows = stored_rows(path, settings, DegradeRow)
    animal = creature(vertex_count)
    template = Template(animal)
    distances = SurfaceDistances(animal)
    posed = whole(creature(vertex_count, pose="walk"), animal)
    middle = np.median(posed.mesh.vertices, axis=0)
    clean = remeshed(largest_piece(cut_by_plane(posed, middle, [1.0, 0.3, 0.1])), 1.1)
    for kind in kinds:
        for level in KINDS[kind].levels:
            if any(row.kind == kind and row.level == level for row in rows):
                continue
            rng = np.random.default_rng(seed)
            part = moved(KINDS[kind].spoil(clean, level, rng), rng)
            rows.append(_measured(kind, level, part, template, distances))
            write_rows(path, settings, rows)
        _draw(output, kind, [row for row in rows if row.kind == kind])
    return rows


def degrade_table(rows: Sequence[DegradeRow]) -> str:
    """The rows as text, each error also relative to the clean part of its kind."""
    lines = ["kind           level   error x100   of clean   coverage   clutter found   seconds"]
    clean: dict[str, float] = {}
    for row in rows:
        first = clean.setdefault(row.kind, row.error)
        found = "-" if row.recognized is None else f"{row.recognized:.2f}"
        lines.append(
            f"{row.kind:13s} {row.level:6g} {row.error:12.2f} {row.error / first:10.2f} "
            f"{row.coverage:10.2f} {found:>15s} {row.seconds:9.1f}"
        )
    return "\n".join(lines)


def _measured(
    kind: str,
    level: float,
    part: Fragment,
    template: Template,
    distances: SurfaceDistances,
) -> DegradeRow:
    template.prepare()
    start = time.perf_counter()
    scan = scan_intake(part.mesh)
    blind = level >= KINDS[kind].blind
    answers = match(template, replace(scan, side_known=scan.side_known and not blind))
    seconds = time.perf_counter() - start
    truth, present = part.truth, part.present
    clutter = ~present
    there = np.flatnonzero(present)
    some = there[evenly_spread(len(there))]
    errors = distances.between(truth[some], answers.points[some])
    return DegradeRow(
        kind=kind,
        level=level,
        error=100 * float(errors.mean()),
        coverage=float(answers.matched[present].mean()),
        recognized=float((~answers.matched[clutter]).mean()) if clutter.any() else None,
        score=answers.best.score,
        seconds=seconds,
    )


def _draw(output: Path, kind: str, rows: Sequence[DegradeRow]) -> None:
    ordered = sorted(rows, key=lambda row: row.level)
    levels = [row.level for row in ordered]
    series = {
        "error": (levels, [row.error for row in ordered]),
        "twice the clean error": (levels, [2 * ordered[0].error] * len(levels)),
    }
    draw_curves(
        output / f"degrade-{kind}.png",
        series,
        labels=(KINDS[kind].label, "mean geodesic error x100"),
        heading=f"Match of half an animal: {kind}",
    )
