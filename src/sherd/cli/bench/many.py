"""`sherd bench skulls` and `identify`: landmarks of many specimens, one of many shapes."""

from __future__ import annotations

from pathlib import Path

import click

from sherd.benchmark.identification import identification_benchmark, identification_table
from sherd.benchmark.skulls import KINDS, median_rows, skull_benchmark, skull_table

__all__ = ["identify_bench_command", "skulls_command"]

FILE = click.Path(path_type=Path)


@click.command("skulls")
@click.argument("directory", type=FILE)
@click.option("--kind", "kinds", type=click.Choice(KINDS), multiple=True, help="Both if none.")
@click.option("--limit", type=int, help="So many cases only, drawn by their names.")
@click.option("--jobs", type=int, default=1, show_default=True, help="Processes.")
@click.option("-o", "--output", type=FILE, required=True, help="Folder.")
def skulls_command(
    directory: Path, *, kinds: tuple[str, ...], limit: int | None, jobs: int, output: Path
) -> int:
    """Carry the landmarks of every skull to every other one, whole and cut in half.

    Each file .npz has vertices, faces and landmarks, the same points in all, set by hand. Distances
    are in the unit of the files. Writes skulls.json; goes on where an interrupted run stopped.

    \b
    Example:
      sherd bench skulls mouse_skulls/ -o skulls/
    """  # noqa: D301
    rows = skull_benchmark(directory, output, kinds=kinds or KINDS, limit=limit, jobs=jobs)
    click.echo(skull_table(rows, median_rows(rows, directory)))
    return 0


@click.command("identify")
@click.argument("directory", type=FILE)
@click.option("--also", type=FILE, multiple=True, help="Further full shape, which no part is of.")
@click.option("--remeshed", type=FILE, help="Parts meshed anew.")
@click.option("--limit", type=int, help="So many parts only, drawn by their names.")
@click.option("--jobs", type=int, default=1, show_default=True, help="Processes.")
@click.option("-o", "--output", type=FILE, required=True, help="Folder.")
def identify_bench_command(
    directory: Path,
    *,
    also: tuple[Path, ...],
    remeshed: Path | None,
    limit: int | None,
    jobs: int,
    output: Path,
) -> int:
    """Identify every cut of a SHREC'16 folder among all its full shapes, and without its own.

    Full shapes are brought to one area. Writes identification.json; goes on where an interrupted
    run stopped.

    \b
    Example:
      sherd bench identify shrec16/ --also lion.obj --also person.off -o identify/
    """  # noqa: D301
    rows = identification_benchmark(
        directory, output, also=also, remeshed=remeshed, limit=limit, jobs=jobs
    )
    click.echo(identification_table(rows))
    return 0
