"""Time and memory of `sherd match` against the number of vertices, from files to written answers.

Each size is a process of its own, so reading, repair, the report and the peak of memory count.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sherd._version import __version__
from sherd.benchmark.metrics import evenly_spread
from sherd.benchmark.paper.drawing import check_plotting, draw_curves
from sherd.benchmark.row_file import write_rows
from sherd.benchmark.timed_command import THIS, timed
from sherd.files.mesh_files import write_mesh
from sherd.mesh.surface_points import SurfacePoints, closest_points
from sherd.shapes.creature import SMALLEST, creature
from sherd.shapes.fragment import Fragment, cut_by_plane, decimated, largest_piece, moved, whole
from sherd.spectral.surface_distances import SurfaceDistances

__all__ = ["SIZES", "SizeRow", "size_benchmark", "size_table"]

SIZES = (2_000, 5_000, 10_000, 20_000, 50_000, 100_000, 200_000, 500_000, 1_000_000)
# The part is what lies in front of a slanted plane with this share of the vertices.
PART_SHARE = 0.3
# Errors of larger shapes are measured on the same surface with so many vertices. It is also where
# matching begins to work on a proxy, so the rows below and above tell what the proxy costs.
MEASURED_ON = 20_000


@dataclass(frozen=True)
class SizeRow:
    """One size.

    Attributes
    ----------
    full_vertices, part_vertices
        Of the files.
    wall_seconds, cpu_seconds
        Of the whole process; on a busy machine the wall time says little.
    peak_gigabytes
        Largest resident memory.
    error
        Mean geodesic error x100 of 600 vertices.
    stages
        Seconds by stage, as in result.json.
    """

    full_vertices: int
    part_vertices: int
    wall_seconds: float
    cpu_seconds: float
    peak_gigabytes: float
    error: float
    stages: dict[str, float]


def size_benchmark(output: Path, *, sizes: Sequence[int] = SIZES) -> list[SizeRow]:
    """Match a third of an animal with the whole at each size; write size.json and size.png.

    Raises
    ------
    OutputError
        If the folder cannot be written.
    OptionError
        If matplotlib is missing.
    SherdError
        If a match ends in an error.
    """
    check_plotting()
    rows: list[SizeRow] = []
    for size in sizes:
        rows.append(_measured(size))
        write_rows(output / "size.json", {"sherd": __version__}, rows)
    counts = [float(row.full_vertices) for row in rows]
    draw_curves(
        output / "size.png",
        {
            "wall seconds": (counts, [row.wall_seconds for row in rows]),
            "CPU seconds": (counts, [row.cpu_seconds for row in rows]),
            "peak gigabytes": (counts, [row.peak_gigabytes for row in rows]),
        },
        labels=("vertices of the full shape", "seconds, gigabytes"),
        heading="sherd match: from files to report",
        logarithmic=(True, True),
    )
    return rows


def size_table(rows: Sequence[SizeRow]) -> str:
    """The rows as text."""
    lines = ["     full      part     wall s      CPU s    peak GB   error x100"]
    lines += [
        f"{row.full_vertices:9,d} {row.part_vertices:9,d} {row.wall_seconds:10.1f} "
        f"{row.cpu_seconds:10.1f} {row.peak_gigabytes:10.2f} {row.error:12.2f}"
        for row in rows
    ]
    return "\n".join(lines)


def _pair(size: int) -> Fragment:
    """A third of the walking animal, and the standing one."""
    full, posed = creature(max(size, SMALLEST)), creature(max(size, SMALLEST), pose="walk")
    fragment = whole(posed, full)
    if size < SMALLEST:
        thin = decimated(whole(full, full), size)
        posed = thin.mesh.with_vertices(thin.truth.positions(posed))
        fragment = whole(posed, thin.mesh)
    normal = np.array([1.0, 0.3, 0.1])
    height = fragment.mesh.vertices @ normal
    place = np.quantile(height, 1 - PART_SHARE) * normal / (normal @ normal)
    return moved(largest_piece(cut_by_plane(fragment, place, normal)), np.random.default_rng(0))


def _measured(size: int) -> SizeRow:
    fragment = _pair(size)
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        write_mesh(fragment.full, folder / "full.ply")
        write_mesh(fragment.mesh, folder / "part.ply")
        shapes = [str(folder / "full.ply"), str(folder / "part.ply")]
        run = timed([*THIS, "match", "-q", *shapes, "-o", str(folder / "out")])
        found = np.loadtxt(folder / "out" / "correspondence.csv", delimiter=",", skiprows=1)
        stages = json.loads((folder / "out" / "result.json").read_text(encoding="utf-8"))
    answers = SurfacePoints(found[:, 1].astype(np.int64), found[:, 2:5])
    return SizeRow(
        full_vertices=fragment.full.vertex_count,
        part_vertices=fragment.mesh.vertex_count,
        wall_seconds=run.wall_seconds,
        cpu_seconds=run.cpu_seconds,
        peak_gigabytes=run.peak_gigabytes,
        error=_error(fragment, answers),
        stages=stages["timings"],
    )


def _error(fragment: Fragment, answers: SurfacePoints) -> float:
    full, some = fragment.full, evenly_spread(len(answers))
    truth, found = fragment.truth[some], answers[some]
    if full.vertex_count > 1.1 * MEASURED_ON:
        ruler = creature(MEASURED_ON)
        truth = closest_points(ruler, truth.positions(full))
        found = closest_points(ruler, found.positions(full))
        full = ruler
    return 100 * float(SurfaceDistances(full).between(truth, found).mean())
