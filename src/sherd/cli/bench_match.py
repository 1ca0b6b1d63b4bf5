"""`sherd bench shrec16`, `faust` and `smal`: match over the pairs of a data set."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

from sherd.benchmark.faust import faust_benchmark
from sherd.benchmark.match_page import write_benchmark_page
from sherd.benchmark.match_row import BenchmarkSettings
from sherd.benchmark.match_summary import summary_table
from sherd.benchmark.shrec16 import KINDS, shrec16_benchmark
from sherd.benchmark.smal import smal_benchmark

__all__ = ["faust_command", "shrec16_command", "smal_command"]

Command = TypeVar("Command", bound=Callable[..., Any])

OPTIONS = (
    click.argument("directory", type=click.Path(path_type=Path)),
    click.option("--rotate", is_flag=True, help="Turn every part at random."),
    click.option("--unknown-scale", is_flag=True, help="Scale every part by 0.5 to 2, untold."),
    click.option("--only", multiple=True, help="Names of pairs; all if none."),
    click.option("--jobs", type=int, default=1, show_default=True, help="Processes."),
    click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="Folder."),
)


def _common(command: Command) -> Command:
    for option in reversed(OPTIONS):
        command = option(command)
    return command


def _finish(document: dict[str, Any], output: Path) -> int:
    write_benchmark_page(document, output)
    click.echo(f"{summary_table(document)}\nOpen {output / 'bench.html'} to see it.")
    return 0


@click.command("shrec16")
@_common
@click.option("--remeshed", type=click.Path(path_type=Path), help="Parts meshed anew.")
@click.option("--points", is_flag=True, help="Take the faces from every part.")
@click.option("--kind", type=click.Choice(KINDS), multiple=True, help="Both if none.")
def shrec16_command(
    directory: Path,
    *,
    remeshed: Path | None,
    kind: tuple[str, ...],
    only: tuple[str, ...],
    jobs: int,
    output: Path,
    **settings: bool,
) -> int:
    """Match every part of a SHREC'16 folder and report errors, regions and times.

    Writes bench.json and bench.html; goes on where an interrupted run stopped.

    \b
    Example:
      sherd bench shrec16 shrec16/ --kind cuts --rotate -o bench/
    """  # noqa: D301
    document = shrec16_benchmark(
        directory,
        output=output,
        kinds=kind or KINDS,
        settings=BenchmarkSettings(**settings),
        remeshed=remeshed,
        only=only,
        jobs=jobs,
    )
    return _finish(document, output)


@click.command("faust")
@_common
def faust_command(
    directory: Path,
    *,
    rotate: bool,
    unknown_scale: bool,
    only: tuple[str, ...],
    jobs: int,
    output: Path,
) -> int:
    """Match parts cut from one person with the body of another, in another pose.

    DIRECTORY holds tr_reg_<number>.off, each body meshed on its own, and corres/ with landmarks.
    Parts are balls, halves and bodies without limbs, cut here, 0.3 to 0.8 of the body. Bodies are
    brought to one area before the cut. Writes bench.json and bench.html; goes on where an
    interrupted run stopped.

    \b
    Example:
      sherd bench faust faust_5k/ --rotate -o bench/
    """  # noqa: D301
    settings = BenchmarkSettings(rotate=rotate, unknown_scale=unknown_scale)
    document = faust_benchmark(directory, output=output, settings=settings, only=only, jobs=jobs)
    return _finish(document, output)


@click.command("smal")
@_common
def smal_command(
    directory: Path,
    *,
    rotate: bool,
    unknown_scale: bool,
    only: tuple[str, ...],
    jobs: int,
    output: Path,
) -> int:
    """Match parts of animals with parts of other animals, often of another species.

    DIRECTORY holds shapes/ and maps/. The method takes the second shape of each map for a full one,
    although it is a part as well. Errors are those of vertices inside the overlap. Writes
    bench.json and bench.html; goes on where an interrupted run stopped.

    \b
    Example:
      sherd bench smal smal_parts/ --rotate --unknown-scale -o bench/
    """  # noqa: D301
    settings = BenchmarkSettings(rotate=rotate, unknown_scale=unknown_scale)
    document = smal_benchmark(directory, output=output, settings=settings, only=only, jobs=jobs)
    return _finish(document, output)
