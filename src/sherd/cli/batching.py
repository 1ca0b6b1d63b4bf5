"""`sherd batch`."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import click

from sherd.batch import BatchResult, batch, collect_batch
from sherd.batching.options import BatchOptions
from sherd.batching.parts import PartSource
from sherd.batching.rows import BatchRow
from sherd.cli.exits import NOT_CONVERGED, SOME_FAILED
from sherd.cli.first_run import prepare_first_run
from sherd.cli.inputs import ScaleType
from sherd.cli.options import overwrite_option, quiet_option, template_option
from sherd.cli.part_table import parts_of_table
from sherd.mesh.units import UNITS, Unit
from sherd.report.exports import MAP_EXPORTS, SHAPE_EXPORTS
from sherd.results.match_options import SCALES, MatchOptions, Scale
from sherd.scan.either_side import SIDES, Side

__all__ = ["batch_command"]

FILE = click.Path(path_type=Path)


@click.command("batch")
@click.argument("fulls", type=FILE, nargs=-1, metavar="FULL...")
@click.option(
    "--parts",
    metavar="FOLDER|GLOB|CSV",
    help="All shapes in a folder, those of a pattern (in quotes), or a table with a column part "
    "and, as you like, name, full, landmarks and ignore.",
)
@click.option("-o", "--output", type=FILE, help="Folder.")
@click.option("--jobs", type=int, help="Processes; as many as cores, or as memory is free for.")
@click.option("--memory", type=float, metavar="GB", help="What each process may hold.")
@click.option("--shard", metavar="I/N", help="Only the I-th of N shares, from 1; then --collect.")
@click.option("--collect", type=FILE, metavar="DIR", help="Make the summary of all shares in DIR.")
@click.option(
    "--scale",
    type=ScaleType(),
    metavar=f"[{'|'.join(SCALES)}|FACTOR]",
    default="same",
    show_default=True,
    help="As of sherd match.",
)
@click.option("--part-unit", type=click.Choice(UNITS), help="Unit of the parts.")
@click.option("--full-unit", type=click.Choice(UNITS), help="Unit of the full shapes.")
@template_option
@click.option("--side", type=click.Choice(SIDES), default="either", show_default=True)
@click.option(
    "--min-confidence",
    type=float,
    default=0.0,
    show_default=True,
    help="Below it a vertex counts as unmatched; 0 to 1.",
)
@click.option("--seed", type=int, default=0, show_default=True)
@click.option(
    "--export",
    "exports",
    type=click.Choice(SHAPE_EXPORTS + MAP_EXPORTS),
    multiple=True,
    help="Further files of each answer, as of sherd match. May be repeated.",
)
@overwrite_option
@click.option("--json", "as_json", is_flag=True, help="Print a line of JSON for each part.")
@quiet_option()
def batch_command(  # noqa: PLR0913 - one for each word that can be typed
    fulls: tuple[Path, ...],
    *,
    parts: str | None,
    output: Path | None,
    jobs: int | None,
    memory: float | None,
    shard: str | None,
    collect: Path | None,
    scale: Scale | float,
    part_unit: Unit | None,
    full_unit: Unit | None,
    template: Path | None,
    side: Side,
    min_confidence: float,
    seed: int,
    exports: tuple[str, ...],
    overwrite: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Match many parts, each with the mesh FULL it belongs to, and go on after any interruption.

    Writes parts/NAME for each part, as sherd match does, summary.csv, summary.json and gallery.html
    to the output folder. What has an answer there to the same question is not computed again. A
    part that fails is a row with its reason.

    Exit code 0 if all parts are good, 4 if all have an answer but not all a good one, 6 if some
    have none.

    \b
    Examples:
      sherd batch template.ply --parts scans/ -o out/
      sherd batch cat.ply dog.ply --parts "scans/*.ply" -o out/ --jobs 4
      sherd batch template.ply --parts scans/ -o out/ --shard 1/10
      sherd batch --collect out/
    """  # noqa: D301
    tell = _json_line if as_json else _nothing
    if collect is not None:
        if fulls or parts or output:
            raise click.UsageError("--collect takes nothing but the folder of a batch")
        result = collect_batch(collect)
        for row in result.rows:
            tell(row)
        return _finish(result, quiet=quiet or as_json)
    if not fulls or parts is None or output is None:
        raise click.UsageError("FULL, --parts and -o are needed, or --collect")
    if template is not None and len(fulls) > 1:
        raise click.UsageError("--template is of one full shape; of several, -o keeps them")
    options = MatchOptions(
        scale=scale, side=side, seed=seed, part_unit=part_unit, full_unit=full_unit
    )
    asked = BatchOptions(
        min_confidence=min_confidence,
        exports=exports,
        template=template,
        shard=shard,
        memory=None if memory is None else round(memory * 1e9),
        overwrite=overwrite,
    )
    prepare_first_run(quiet=quiet)
    result = batch(
        list(fulls),
        _source(parts),
        output,
        options,
        batch_options=asked,
        jobs=jobs,
        tell=tell,
    )
    return _finish(result, quiet=quiet or as_json)


def _source(parts: str) -> PartSource:
    path = Path(parts)
    return parts_of_table(path) if path.suffix.lower() == ".csv" else parts


def _finish(result: BatchResult, *, quiet: bool) -> int:
    if not quiet:
        failed = [row for row in result.rows if row.status == "failed"]
        for row in failed:
            click.echo(f"{click.style('failed:', fg='red')} {row.name}: {row.reason}", err=True)
        click.echo(f"{result.words}.")
        if (result.folder / "gallery.html").exists():
            click.echo(f"Open {result.folder / 'gallery.html'} to see them.")
    if not result.all_answered:
        return SOME_FAILED
    return 0 if result.all_good else NOT_CONVERGED


def _json_line(row: BatchRow) -> None:
    click.echo(json.dumps(asdict(row), allow_nan=False))


def _nothing(_row: BatchRow) -> None:
    """Rows are in the summary."""
