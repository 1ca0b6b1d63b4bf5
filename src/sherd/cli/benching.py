"""`sherd bench`."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import click

from sherd.benchmark.region import region_benchmark, region_table
from sherd.benchmark.robustness import RobustnessRow, check_command, robustness
from sherd.cli.exits import INTERNAL
from sherd.mesh.files import write_mesh
from sherd.region.options import METHODS, LocateOptions
from sherd.shapes.creature import creature
from sherd.shapes.fragment import cut_by_ball, whole

__all__ = ["bench_group"]


@click.group("bench")
def bench_group() -> None:
    """Measure accuracy and speed on data sets and generated shapes."""


@bench_group.command("region")
@click.argument("directory", type=click.Path(path_type=Path))
@click.option("--remeshed", type=click.Path(path_type=Path), help="Parts meshed anew.")
@click.option("--kind", type=click.Choice(["cuts", "holes"]), default="cuts", show_default=True)
@click.option("--method", type=click.Choice(METHODS), default="voting", show_default=True)
@click.option("--limit", type=int, help="First pairs only.")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Folder for bench.json.")
def region_command(
    directory: Path,
    *,
    remeshed: Path | None,
    kind: str,
    method: str,
    limit: int | None,
    output: Path | None,
) -> int:
    """Locate every part of a SHREC'16 folder, randomly rotated, and report the overlap."""
    rows = region_benchmark(
        directory,
        remeshed=remeshed,
        kind=kind,
        options=LocateOptions(method=method),
        limit=limit,
        output=output,
    )
    click.echo(region_table(rows))
    return 0


@bench_group.command("robustness")
@click.argument("directory", type=click.Path(path_type=Path, exists=True, file_okay=False))
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="Folder.")
@click.option("--seconds", type=float, default=60.0, show_default=True, help="Limit for one run.")
def robustness_command(directory: Path, *, output: Path, seconds: float) -> int:
    """Run every file of a folder through check and locate, as full shape and as part.

    Writes robustness.csv and robustness.json: file, what was wrong, what sherd said. Exit code 70
    if any run ended in a traceback, a hang, a wrong exit code or a broken output.
    """
    failures = 0

    def tell(row: RobustnessRow) -> None:
        nonlocal failures
        failures += row.verdict == "failed"
        if row.verdict == "failed":
            click.echo(f"FAILED {row.command} {row.file}: {row.failure}")

    with tempfile.TemporaryDirectory() as scratch:
        animal = creature(5000)
        full, part = Path(scratch) / "animal.ply", Path(scratch) / "head.ply"
        write_mesh(animal, full)
        write_mesh(cut_by_ball(whole(animal, animal), 0, 0.3).mesh, part)
        sherd = [sys.executable, "-m", "sherd"]
        commands = {
            "check": check_command,
            "locate as part": lambda mesh, out: [
                *sherd, "locate", str(full), str(mesh), "-o", str(out)
            ],
            "locate as full shape": lambda mesh, out: [
                *sherd, "locate", str(mesh), str(part), "-o", str(out)
            ],
        }  # fmt: skip
        rows = robustness(directory, output, commands=commands, seconds=seconds, progress=tell)
    click.echo(f"{len(rows)} runs, {failures} failed; the table is in {output}")
    return INTERNAL if failures else 0
