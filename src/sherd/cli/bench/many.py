"""`sherd bench skulls`: landmarks carried to other individuals."""

from __future__ import annotations

from pathlib import Path

import click

from sherd.benchmark.skulls import KINDS, median_rows, skull_benchmark, skull_table

__all__ = ["skulls_command"]


@click.command("skulls")
@click.argument("directory", type=click.Path(path_type=Path))
@click.option("--kind", "kinds", type=click.Choice(KINDS), multiple=True, help="Both if none.")
@click.option("--limit", type=int, help="So many cases only, drawn by their names.")
@click.option("--jobs", type=int, default=1, show_default=True, help="Processes.")
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="Folder.")
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
