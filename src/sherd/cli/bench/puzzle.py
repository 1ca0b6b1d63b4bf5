"""`sherd bench puzzle`."""

from __future__ import annotations

from pathlib import Path

import click

from sherd.benchmark.puzzle.benchmark import puzzle_benchmark, puzzle_table

__all__ = ["puzzle_command"]


@click.command("puzzle")
@click.argument("directory", type=click.Path(path_type=Path))
@click.option(
    "--individuals",
    type=click.Path(path_type=Path),
    help="Another such folder, with other individuals of the same kinds.",
)
@click.option("--only", multiple=True, help="Names of puzzles; all if none.")
@click.option("--pieces", "counts", type=int, multiple=True, help="2, 4, 8 or 12; all if none.")
@click.option("--puzzles", "limit", type=int, help="First puzzles only, which are of all kinds.")
@click.option("--jobs", type=int, default=1, show_default=True, help="Processes.")
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="Folder.")
def puzzle_command(
    directory: Path,
    *,
    individuals: Path | None,
    only: tuple[str, ...],
    counts: tuple[int, ...],
    limit: int | None,
    jobs: int,
    output: Path,
) -> int:
    """Put puzzles together that are cut from animated shapes, each piece in a pose of its own.

    DIRECTORY holds an .npz file or a folder of meshes for each shape. Pieces are meshed anew and
    turned; some puzzles overlap, lack pieces, have foreign ones or clutter. Beside it each piece is
    matched alone. Writes puzzle.json; goes on where an interrupted run stopped.

    \b
    Example:
      sherd bench puzzle tosca_poses/ --puzzles 20 -o bench/
    """  # noqa: D301
    rows = puzzle_benchmark(
        directory,
        output,
        individuals=individuals,
        only=only,
        counts=counts,
        limit=limit,
        jobs=jobs,
    )
    click.echo(puzzle_table(rows))
    return 0
