"""Skulls laid onto damaged ones of other strains, measured by landmarks that hands set."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import permutations
from pathlib import Path

import numpy as np

from sherd.arrays import Floats
from sherd.benchmark.datasets.pairs import seed_of
from sherd.benchmark.fit.baselines import (
    arap_positions,
    has_libigl,
    nonrigid_icp_positions,
    require_icp,
)
from sherd.benchmark.fit.measurement import WAYS
from sherd.benchmark.runner import measured_and_kept
from sherd.benchmark.skulls import half_of_skull, motion_of, on_skull, read_skull
from sherd.errors import InfeasibleError, MeshFileError
from sherd.fitting.fit import fit
from sherd.fitting.targets import targets_of
from sherd.library.fitted_scale import match_with_fitted_scale, sizing_after
from sherd.limits import require_whole
from sherd.mesh.surface_points import closest_points
from sherd.mesh.topology import component_labels
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.match_options import MatchOptions
from sherd.scan.intake import mesh_intake
from sherd.shapes.rotation import rotated
from sherd.spectral.sampling import decimate

__all__ = ["SkullFitRow", "holds_skulls", "skull_fit_benchmark", "skull_fit_table"]

# The template as it is fitted, for all ways alike: trimesh's ICP solves for 4 unknowns a vertex.
VERTICES = 10_000
NAMES = {"fit": "sherd fit", "arap": "libigl ARAP, same map", "icp": "nricp_amberg, same map"}


@dataclass(frozen=True)
class SkullCase:
    """One template to be laid onto half of one specimen."""

    template: Path
    specimen: Path

    @property
    def name(self) -> str:
        """Both."""
        return f"half of {self.specimen.stem} by {self.template.stem}"


@dataclass(frozen=True)
class SkullFitRow:
    """What came of one case; lengths in the unit of the files.

    Attributes
    ----------
    name
        Of the case.
    vertices
        Of the template that was fitted.
    status, scale
        Of the match, at the size that fits.
    seen
        Of each landmark, whether the half has it.
    fit, arap, icp
        Distance of each landmark to where a hand set it on the whole skull; empty if not measured.
    seconds
        Wall time of each of these ways after matching, NaN if not measured.
    """

    name: str
    vertices: int
    status: str
    scale: float
    seen: list[bool]
    fit: list[float]
    arap: list[float]
    icp: list[float]
    seconds: list[float | None]


def holds_skulls(directory: Path) -> bool:
    """Whether the folder is one of skulls with landmarks.

    Raises
    ------
    MeshFileError
        If its first file cannot be read.
    """
    first = next(iter(sorted(directory.glob("*.npz"))), None)
    if first is None:
        return False
    try:
        with np.load(first, allow_pickle=False) as stored:
            return "landmarks" in stored
    except (OSError, ValueError) as error:
        raise MeshFileError(f"{first}: cannot be read ({error})") from error


def skull_fit_benchmark(
    directory: Path,
    output: Path,
    *,
    limit: int | None = None,
    with_icp: bool = False,
    jobs: int = 1,
) -> list[SkullFitRow]:
    """Fit every skull to a half of every other one, with the baselines in the same run.

    Halves are those of ``bench skulls``, turned at random. Writes ``skull_fits.json`` after every
    case, and goes on where an interrupted run stopped.

    Raises
    ------
    MeshFileError
        If a file is missing or damaged.
    OptionError
        If `limit` or `jobs` is below 1, or the ICP cannot run.
    OutputError
        If the result cannot be written.
    """
    if with_icp:
        require_icp()
    if limit is not None:
        require_whole("pairs", limit, 1, 10**6, "no folder has more pairs")
    files = sorted(directory.glob("*.npz"))
    cases = [SkullCase(*pair) for pair in permutations(files, 2)]
    cases.sort(key=lambda case: seed_of(case.name, 0))
    return measured_and_kept(
        cases[:limit],
        partial(_measured, with_icp=with_icp),
        kind=SkullFitRow,
        name=lambda row: row.name,
        path=output / "skull_fits.json",
        inputs=files,
        settings={"icp": with_icp, "arap": has_libigl()},
        jobs=jobs,
    )


def skull_fit_table(rows: Sequence[SkullFitRow]) -> str:
    """The rows and means as text: landmarks on the half that was given, and on the rest."""
    width = max([len(row.name) for row in rows], default=4) + 2
    lines = [f"{'case':<{width}}{'way':<6}    seen  median  hidden  seconds"]
    for row in rows:
        lines += [
            f"{row.name:<{width}}{way:<6}{_words(row, way)}  {row.status.lower()}"
            for way in WAYS
            if getattr(row, way)
        ]
    for way in WAYS:
        some = [row for row in rows if getattr(row, way)]
        if some:
            seen = float(np.mean([_errors(row, way, seen=True).mean() for row in some]))
            hidden = float(np.mean([_errors(row, way, seen=False).mean() for row in some]))
            lines.append(f"{NAMES[way]} ({len(some)}): seen {seen:.3f}, hidden {hidden:.3f}")
    return "\n".join(lines)


def _words(row: SkullFitRow, way: str) -> str:
    seen, hidden = _errors(row, way, seen=True), _errors(row, way, seen=False)
    seconds = row.seconds[WAYS.index(way)]
    return (
        f"{seen.mean():8.3f}{np.median(seen):8.3f}{hidden.mean():8.3f}"
        f"{np.nan if seconds is None else seconds:9.1f}"
    )


def _errors(row: SkullFitRow, way: str, *, seen: bool) -> Floats:
    chosen = np.array(row.seen) == seen
    errors = np.array(getattr(row, way))[chosen]
    return errors if len(errors) else np.array([np.nan])


def _measured(case: SkullCase, *, with_icp: bool) -> SkullFitRow:
    whole, landmarks = read_skull(case.template)
    template = _one_surface(decimate(_one_surface(whole), VERTICES)[0])
    specimen, truth = read_skull(case.specimen)
    rng = np.random.default_rng(seed_of(f"{case.specimen.stem} half", 0))
    half = half_of_skull(specimen, rng)
    part = rotated(half, rng)
    turn, shift = motion_of(half.vertices, part.vertices)
    there = truth.positions @ turn + shift
    seen = on_skull(half, truth.positions)
    try:
        result = match_with_fitted_scale(template, part)
    except InfeasibleError:
        none: list[float] = []
        nothing: list[float | None] = [None] * len(WAYS)
        return SkullFitRow(
            case.name, template.vertex_count, "none", 1.0, seen.tolist(), none, none, none, nothing
        )
    sizing = sizing_after(result, MatchOptions.scale)
    points = closest_points(template, landmarks.positions)
    targets = targets_of([result])
    unit = result.full.length / result.scale
    shape = result.full.with_vertices(result.full.vertices / result.full.length)
    ways: dict[str, Callable[[], Floats]] = {"fit": lambda: fit(result, sizing=sizing).positions}
    if has_libigl():
        ways["arap"] = lambda: arap_positions(shape, targets) * unit
    if with_icp:
        ways["icp"] = lambda: nonrigid_icp_positions(shape, targets, result) * unit
    errors: dict[str, list[float]] = {}
    seconds: list[float | None] = []
    for way in WAYS:
        start = time.perf_counter()
        try:
            positions = ways[way]() if way in ways else None
        except InfeasibleError:
            positions = None
        seconds.append(None if positions is None else time.perf_counter() - start)
        errors[way] = []
        if positions is not None:
            off = points.positions(template.with_vertices(positions)) - there
            errors[way] = np.linalg.norm(off, axis=1).tolist()
    return SkullFitRow(
        name=case.name,
        vertices=template.vertex_count,
        status=result.status.name,
        scale=result.scale,
        seen=seen.tolist(),
        seconds=seconds,
        **errors,
    )


def _one_surface(mesh: TriangleMesh) -> TriangleMesh:
    """The largest component, repaired: libigl and trimesh have no solution for all of a skull."""
    repaired = mesh_intake(mesh).mesh
    labels = component_labels(repaired.faces, repaired.vertex_count)
    areas = np.bincount(labels, repaired.vertex_areas)
    return repaired.submesh(labels[repaired.faces[:, 0]] == areas.argmax())[0]
