"""`sherd bench cp2p`, `smal`, `singleview` and `belonging`: what is shared, what is foreign."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from sherd.benchmark.belonging import belonging_benchmark, belonging_table
from sherd.benchmark.datasets.cut_pairs import cut_pair_set
from sherd.benchmark.datasets.overlaps import OverlapSet
from sherd.benchmark.datasets.pairs import BenchmarkSettings
from sherd.benchmark.datasets.single_view import single_view_set
from sherd.benchmark.datasets.smal import smal_overlap_set
from sherd.benchmark.overlap_benchmark import overlap_benchmark, overlap_table
from sherd.cli.bench.pair_set import measuring

__all__ = ["belonging_command", "cp2p_command", "singleview_command", "smal_command"]


def _overlapped(pairs: OverlapSet, *, output: Path, **which: Any) -> str:
    return overlap_table(overlap_benchmark(pairs, output, **which))


@click.command("cp2p")
@measuring(_overlapped)
@click.option("--remeshed", type=click.Path(path_type=Path), help="Parts meshed anew.")
def cp2p_command(
    directory: Path, settings: BenchmarkSettings, *, remeshed: Path | None
) -> OverlapSet:
    """Find what two cuts of one shape in two poses share: SHREC'16 cuts, two and two.

    20 pairs of each class that share 0.1 to 0.9 of the larger; the truth follows from where both
    lie on the whole. Writes bench.json; goes on where an interrupted run stopped.

    \b
    Example:
      sherd bench cp2p shrec16/ --remeshed shrec16_remeshed/ --rotate -o bench/
    """  # noqa: D301
    return cut_pair_set(directory, settings, remeshed=remeshed)


@click.command("singleview")
@measuring(_overlapped)
def singleview_command(directory: Path, settings: BenchmarkSettings) -> OverlapSet:
    """Find what two single-camera views share, often of different things.

    DIRECTORY holds one .npz file for each pair. Writes bench.json; goes on where an interrupted run
    stopped.

    \b
    Example:
      sherd bench singleview single_view/ --rotate -o bench/
    """  # noqa: D301
    return single_view_set(directory, settings)


@click.command("smal")
@measuring(_overlapped)
def smal_command(directory: Path, settings: BenchmarkSettings) -> OverlapSet:
    """Find what parts of two animals share, often of different species.

    DIRECTORY holds shapes/ and maps/. Writes bench.json; goes on where an interrupted run stopped.

    \b
    Example:
      sherd bench smal smal_parts/ --rotate -o bench/
    """  # noqa: D301
    return smal_overlap_set(directory, settings)


@click.command("belonging")
@click.argument("directory", type=click.Path(path_type=Path))
@click.option("--remeshed", type=click.Path(path_type=Path), help="Parts meshed anew.")
@click.option("--pairs", "limit", type=int, help="So many parts only.")
@click.option("--jobs", type=int, default=1, show_default=True, help="Processes.")
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="Folder.")
def belonging_command(
    directory: Path, *, remeshed: Path | None, limit: int | None, jobs: int, output: Path
) -> int:
    """Match and locate every cut on its own shape and on a foreign one.

    DIRECTORY is a SHREC'16 folder. Writes belonging.json; goes on where an interrupted run stopped.

    \b
    Example:
      sherd bench belonging shrec16/ --remeshed shrec16_remeshed/ -o bench/
    """  # noqa: D301
    rows = belonging_benchmark(directory, output, remeshed=remeshed, limit=limit, jobs=jobs)
    click.echo(belonging_table(rows))
    return 0
