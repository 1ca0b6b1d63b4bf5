"""`sherd bench puzzle`, `sherd bench join` and `sherd bench sherds`."""

from __future__ import annotations

from pathlib import Path

import click

from sherd.benchmark.puzzle.benchmark import puzzle_benchmark, puzzle_table
from sherd.benchmark.puzzle.joining import join_benchmark, join_table
from sherd.benchmark.puzzle.sherds import KINDS, sherd_benchmark, sherd_table
from sherd.benchmark.puzzle.sources import CUTS, OVERLAP

__all__ = ["join_command", "puzzle_command", "sherds_command"]


@click.command("puzzle")
@click.argument("directory", type=click.Path(path_type=Path))
@click.option(
    "--individuals",
    type=click.Path(path_type=Path),
    help="Another such folder, with other individuals of the same kinds.",
)
@click.option("--only", multiple=True, help="Names of puzzles; all if none.")
@click.option(
    "--pieces", "counts", type=int, multiple=True, help="Of each whole; 2, 4, 8 and 12 if none."
)
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


@click.command("join")
@click.argument("directory", type=click.Path(path_type=Path))
@click.option("--pieces", "count", type=int, default=6, show_default=True, help="Of each whole.")
@click.option(
    "--overlap",
    type=float,
    default=OVERLAP,
    show_default=True,
    help="Share of its area that each piece reaches beyond its cell.",
)
@click.option(
    "--cut",
    type=click.Choice(tuple(CUTS)),
    default="cells",
    show_default=True,
    help="Cells of points that lie far apart, or balls about these, all of one area.",
)
@click.option(
    "--per-shape",
    type=int,
    default=2,
    show_default=True,
    help="Puzzles of each shape, each cut from elsewhere and in other poses; ten at most.",
)
@click.option("--puzzles", "limit", type=int, help="First puzzles only; all if none.")
@click.option("--jobs", type=int, default=1, show_default=True, help="Processes.")
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="Folder.")
def join_command(
    directory: Path,
    *,
    count: int,
    overlap: float,
    cut: str,
    per_shape: int,
    limit: int | None,
    jobs: int,
    output: Path,
) -> int:
    """Join overlapping pieces of animated shapes and a foreign one, without a whole.

    DIRECTORY holds an .npz file or a folder of meshes for each shape, two at least. Each piece has
    a pose of its own and shares some of its area with its neighbors; one more is of another shape.
    Writes join.json; goes on where an interrupted run stopped.

    \b
    Example:
      sherd bench join tosca_poses/ --overlap 0.3 -o bench/
    """  # noqa: D301
    rows = join_benchmark(
        directory,
        output,
        count=count,
        overlap=overlap,
        cut=cut,
        per_shape=per_shape,
        limit=limit,
        jobs=jobs,
    )
    click.echo(join_table(rows))
    return 0


@click.command("sherds")
@click.option(
    "--kind", "kinds", multiple=True, type=click.Choice(tuple(KINDS)), help="All if none."
)
@click.option("--vases", type=int, default=3, show_default=True, help="Of each kind.")
@click.option("--jobs", type=int, default=1, show_default=True, help="Processes.")
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="Folder.")
def sherds_command(*, kinds: tuple[str, ...], vases: int, jobs: int, output: Path) -> int:
    """Put sherds of generated vases on the whole ones with `assemble --rigid`.

    Four of seven sherds, solid and with faces of fracture, and three of another vase of the same
    profile. Clean, of shallow relief, noisy, worn and coarse. Writes sherds.json; goes on where an
    interrupted run stopped.

    \b
    Example:
      sherd bench sherds -o bench/
    """  # noqa: D301
    click.echo(sherd_table(sherd_benchmark(output, kinds=kinds, vases=vases, jobs=jobs)))
    return 0
