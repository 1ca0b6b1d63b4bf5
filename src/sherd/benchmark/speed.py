"""How long commands take on generated shapes, alone or in turn with another version of sherd."""

from __future__ import annotations

import shlex
import statistics
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.sparse import csgraph

from sherd._version import __version__
from sherd.arrays import Floats
from sherd.benchmark.row_file import write_rows
from sherd.benchmark.timed_command import THIS, Timing, timed
from sherd.files.mesh_files import write_mesh
from sherd.mesh.geometry import edge_graph
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import Stages
from sherd.shapes.creature import creature
from sherd.shapes.fragment import Fragment, cut_by_level, moved, whole
from sherd.spectral.geodesics import Geodesics

__all__ = ["WORKS", "SpeedRow", "speed_benchmark", "speed_table"]

# Of the walking animal, a geodesic ball of this share of the area is the part.
PART_SHARE = 0.5
FULL_VERTICES, LARGE_VERTICES = 10_000, 1_000_000
# Brought back by `--scale unknown`.
SCALE = 0.6


@dataclass(frozen=True)
class SpeedRow:
    """One kind of work.

    Attributes
    ----------
    work
        Its name.
    wall_seconds, cpu_seconds, peak_gigabytes
        Medians of this installation.
    other_wall_seconds, other_peak_gigabytes
        Medians of the other one, None without it.
    ratio, least_ratio, largest_ratio
        Wall seconds of this one over those of the other, run one after the other: median and
        range, None without it.
    """

    work: str
    wall_seconds: float
    cpu_seconds: float
    peak_gigabytes: float
    other_wall_seconds: float | None = None
    other_peak_gigabytes: float | None = None
    ratio: float | None = None
    least_ratio: float | None = None
    largest_ratio: float | None = None


@dataclass(frozen=True)
class _Scene:
    """A folder with files, and where one of the installations writes."""

    folder: Path
    own: Path

    def arguments(self, command: str, full: str, part: str, *more: str) -> list[str]:
        shapes = [str(self.folder / full), str(self.folder / part)]
        return [command, "-q", *shapes, "-o", str(self.own / "out"), *more]


def _cold(scene: _Scene) -> list[str]:
    return scene.arguments("match", "full.ply", "part.ply")


def _prepared(scene: _Scene) -> list[str]:
    return [*_cold(scene), "--template", str(scene.own / "full.npz")]


def _locate(scene: _Scene) -> list[str]:
    return scene.arguments("locate", "full.ply", "part.ply")


def _unknown_scale(scene: _Scene) -> list[str]:
    return scene.arguments("match", "full.ply", "small.ply", "--scale", "unknown")


def _points(scene: _Scene) -> list[str]:
    return scene.arguments("match", "full.ply", "points.xyz")


def _large(scene: _Scene) -> list[str]:
    return scene.arguments("match", "large_full.ply", "large_part.ply")


def _help(_: _Scene) -> list[str]:
    return ["--help"]


# Each as a command line of both installations; "first run" is the first one with no compiled code.
WORKS: dict[str, Callable[[_Scene], list[str]]] = {
    "match": _cold,
    "match, template": _prepared,
    "locate": _locate,
    "unknown scale": _unknown_scale,
    "points": _points,
    "million": _large,
    "first run": _cold,
    "help": _help,
}


def speed_benchmark(
    output: Path,
    *,
    works: Sequence[str] = tuple(WORKS),
    repeats: int = 5,
    against: str | None = None,
    stages: Stages | None = None,
) -> list[SpeedRow]:
    """Time each kind of work and write speed.json.

    Every work runs once before it is measured, so that compiled code and a template are there.

    Parameters
    ----------
    output
        Folder.
    works
        Names from `WORKS`.
    repeats
        Runs of each work, of each installation.
    against
        Command line of another installation, which runs in turn with this one.
    stages
        Shows progress; a silent one if None.

    Raises
    ------
    OutputError
        If the folder cannot be written.
    SherdError
        If a command cannot be started or ends in an error.
    """
    stages = stages or Stages(visible=False)
    commands = [THIS] if against is None else [THIS, tuple(shlex.split(against))]
    rows: list[SpeedRow] = []
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        with stages("shapes"):
            _write_shapes(folder, large="million" in works)
        scenes = []
        for number in range(len(commands)):
            scenes.append(_Scene(folder, folder / f"installation_{number}"))
            scenes[-1].own.mkdir()
        for work in works:
            with stages(work):
                runs = _runs(work, commands, scenes, repeats)
            rows.append(_row(work, runs))
            header = {"sherd": __version__, "repeats": repeats, "against": against}
            write_rows(output / "speed.json", header, rows)
    return rows


def speed_table(rows: Sequence[SpeedRow]) -> str:
    """The rows as text."""
    lines = [
        "work               wall s    CPU s  peak GB   other s  other GB   ratio (least to largest)"
    ]
    for row in rows:
        line = (
            f"{row.work:16s} {row.wall_seconds:8.2f} {row.cpu_seconds:8.2f} "
            f"{row.peak_gigabytes:8.2f}"
        )
        if row.ratio is not None:
            line += (
                f" {row.other_wall_seconds:9.2f} {row.other_peak_gigabytes:9.2f} "
                f"{row.ratio:7.2f} ({row.least_ratio:.2f} to {row.largest_ratio:.2f})"
            )
        lines.append(line)
    return "\n".join(lines)


def _write_shapes(folder: Path, *, large: bool) -> None:
    sizes = {"": FULL_VERTICES, "large_": LARGE_VERTICES} if large else {"": FULL_VERTICES}
    for name, size in sizes.items():
        full = creature(size)
        posed = whole(creature(size, pose="walk"), full)
        # to factorize a million equations takes minutes, and paths along edges cut as well
        distances = _along_edges if name else _along_surface
        part = moved(_ball(posed, distances(posed.mesh)), np.random.default_rng(0)).mesh
        write_mesh(full, folder / f"{name}full.ply")
        write_mesh(part, folder / f"{name}part.ply")
        if not name:
            write_mesh(part.with_vertices(SCALE * part.vertices), folder / "small.ply")
            _write_points(part, folder / "points.xyz")


def _along_surface(mesh: TriangleMesh) -> Floats:
    distances: Floats = Geodesics(mesh).distances_from(0)[0]
    return distances


def _along_edges(mesh: TriangleMesh) -> Floats:
    graph = edge_graph(mesh.vertices, mesh.edges)
    first = np.array([0])
    return np.asarray(csgraph.dijkstra(graph, directed=False, indices=first, min_only=True))


def _ball(posed: Fragment, distance: Floats) -> Fragment:
    order = np.argsort(distance)
    share = np.cumsum(posed.mesh.vertex_areas[order]) / posed.mesh.area
    reach = distance[order[np.searchsorted(share, PART_SHARE)]]
    return cut_by_level(posed, reach - distance)


def _write_points(mesh: TriangleMesh, path: Path) -> None:
    np.savetxt(path, mesh.vertices, fmt="%.9g")


def _runs(
    work: str, commands: Sequence[tuple[str, ...]], scenes: Sequence[_Scene], repeats: int
) -> list[list[Timing]]:
    """Timings of each installation; they take turns."""
    runs: list[list[Timing]] = [[] for _ in commands]
    for repeat in range(repeats + 1):
        for number, (command, scene) in enumerate(zip(commands, scenes, strict=True)):
            if work == "first run" and repeat == 0:
                continue
            own = {"NUMBA_CACHE_DIR": str(scene.own / f"cache_{repeat}")}
            out = scene.own / "out"
            if out.exists():
                out.rename(scene.own / f"{work} {repeat}".replace(" ", "_"))
            timing = timed(
                [*command, *WORKS[work](scene)], environment=own if work == "first run" else None
            )
            if repeat > 0:  # before, there may be something to compile
                runs[number].append(timing)
    return runs


def _row(work: str, runs: Sequence[Sequence[Timing]]) -> SpeedRow:
    own = runs[0]
    row = SpeedRow(
        work,
        statistics.median(run.wall_seconds for run in own),
        statistics.median(run.cpu_seconds for run in own),
        statistics.median(run.peak_gigabytes for run in own),
    )
    if len(runs) == 1:
        return row
    ratios = [a.wall_seconds / b.wall_seconds for a, b in zip(*runs, strict=True)]
    return SpeedRow(
        row.work,
        row.wall_seconds,
        row.cpu_seconds,
        row.peak_gigabytes,
        statistics.median(run.wall_seconds for run in runs[1]),
        statistics.median(run.peak_gigabytes for run in runs[1]),
        statistics.median(ratios),
        min(ratios),
        max(ratios),
    )
