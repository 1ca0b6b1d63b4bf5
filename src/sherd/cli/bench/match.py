"""`sherd bench shrec16`, `faust` and `smal-match`: match over the pairs of a data set."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from sherd.benchmark.datasets.faust import faust_set
from sherd.benchmark.datasets.pairs import BenchmarkSettings, PairSet
from sherd.benchmark.datasets.shrec16 import KINDS, shrec16_set
from sherd.benchmark.datasets.smal import smal_set
from sherd.benchmark.match.benchmark import match_benchmark
from sherd.benchmark.match.summary import summary_table
from sherd.cli.bench.pair_set import measuring

__all__ = ["faust_command", "shrec16_command", "smal_match_command"]


def _matched(pairs: PairSet, *, output: Path, **which: Any) -> str:
    document = match_benchmark(pairs, output, **which)
    return f"{summary_table(document)}\nOpen {output / 'bench.html'} to see it."


@click.command("shrec16")
@measuring(_matched)
@click.option("--remeshed", type=click.Path(path_type=Path), help="Parts meshed anew.")
@click.option("--points", is_flag=True, help="Take the faces from every part.")
@click.option("--kind", type=click.Choice(KINDS), multiple=True, help="Both if none.")
def shrec16_command(
    directory: Path,
    settings: BenchmarkSettings,
    *,
    remeshed: Path | None,
    points: bool,
    kind: tuple[str, ...],
) -> PairSet:
    """Match every part of a SHREC'16 folder and report errors, regions and times.

    Writes bench.json and bench.html; goes on where an interrupted run stopped.

    \b
    Example:
      sherd bench shrec16 shrec16/ --kind cuts --rotate -o bench/
    """  # noqa: D301
    settings = replace(settings, points=points)
    return shrec16_set(directory, settings, kinds=kind or KINDS, remeshed=remeshed)


@click.command("faust")
@measuring(_matched)
def faust_command(directory: Path, settings: BenchmarkSettings) -> PairSet:
    """Match parts cut from one person with the body of another, in another pose.

    DIRECTORY holds tr_reg_<number>.off, each body meshed on its own, and corres/ with landmarks.
    Parts are balls, halves and bodies without limbs, cut here, 0.3 to 0.8 of the body. Bodies are
    brought to one area before the cut. Writes bench.json and bench.html; goes on where an
    interrupted run stopped.

    \b
    Example:
      sherd bench faust faust_5k/ --rotate -o bench/
    """  # noqa: D301
    return faust_set(directory, settings)


@click.command("smal-match")
@measuring(_matched)
def smal_match_command(directory: Path, settings: BenchmarkSettings) -> PairSet:
    """Match parts of animals with parts of other animals, often of another species.

    DIRECTORY holds shapes/ and maps/. The method takes the second shape of each map for a full one,
    although it is a part as well. Errors are those of vertices inside the overlap. Writes
    bench.json and bench.html; goes on where an interrupted run stopped.

    \b
    Example:
      sherd bench smal-match smal_parts/ --rotate --unknown-scale -o bench/
    """  # noqa: D301
    return smal_set(directory, settings)
