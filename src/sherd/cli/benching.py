"""`sherd bench`."""

from __future__ import annotations

from pathlib import Path

import click

from sherd.benchmark.region import region_benchmark, region_table
from sherd.region.options import METHODS, LocateOptions

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
