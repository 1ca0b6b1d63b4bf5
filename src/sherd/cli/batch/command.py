"""`sherd batch`."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import asdict
from functools import partial
from pathlib import Path

import click

from sherd.batching.batch import BatchResult, batch
from sherd.batching.collect import collect_batch
from sherd.batching.dask_cluster import dask_executor
from sherd.batching.ledger.rows import FAILED, Row
from sherd.batching.options import BatchOptions
from sherd.batching.pairs.all_pairs import PairsResult
from sherd.batching.pairs.all_pairs import all_pairs as pairs_of
from sherd.batching.parts import PartSource
from sherd.batching.specimens import ANY_TEMPLATE, carried_to_parts, folders_by_template
from sherd.cli.batch.part_table import parts_of_table
from sherd.cli.exits import NOT_CONVERGED, SOME_FAILED
from sherd.cli.first_run import prepare_first_run
from sherd.cli.inputs import ScaleType
from sherd.cli.many.landmarking import landmarks_by_template, mesh_space_option
from sherd.cli.options import (
    overwrite_option,
    quiet_option,
    seed_option,
    side_option,
    template_option,
)
from sherd.landmarks.landmark_list import Landmarks, Space
from sherd.landmarks.landmark_table import landmark_table
from sherd.mesh.units import UNITS, Unit
from sherd.output import require_writable, write_text
from sherd.report.exports import MAP_EXPORTS, SHAPE_EXPORTS
from sherd.results.match_options import SCALES, MatchOptions, Scale
from sherd.results.overlap_options import OverlapOptions
from sherd.scan.either_side import Side

__all__ = ["batch_command"]

FILE = click.Path(path_type=Path)
LANDMARKS = "landmarks.csv"


@click.command("batch")
@click.argument("fulls", type=FILE, nargs=-1, metavar="FULL...")
@click.option(
    "--parts",
    metavar="FOLDER|GLOB|CSV",
    help="All shapes in a folder, those of a pattern (in quotes), or a table with a column part "
    "and, as you like, name, full, landmarks and ignore.",
)
@click.option("-o", "--output", type=FILE, help="Folder.")
@click.option(
    "--all-pairs",
    metavar="FOLDER|GLOB",
    help="Without FULL: what each two shapes of a collection share.",
)
@click.option("--jobs", type=int, help="Processes; as many as cores, or as memory is free for.")
@click.option("--memory", type=float, metavar="GB", help="What each process may hold.")
@click.option("--dask", metavar="ADDRESS", help="Compute on this Dask cluster; needs the extra.")
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
@side_option("all parts")
@click.option(
    "--min-confidence",
    type=float,
    default=0.0,
    show_default=True,
    help="Below it a vertex counts as unmatched; 0 to 1.",
)
@click.option(
    "--landmarks",
    "named",
    metavar="[FULL=]FILE",
    multiple=True,
    help="Landmarks of FULL (.mrk.json, .fcsv, .csv): on all parts in landmarks.csv. With several "
    "FULL each part is matched with all, and the median is taken.",
)
@mesh_space_option
@click.option(
    "--fit-scale/--no-fit-scale",
    default=None,
    help="Parts are of other individuals than FULL: match each again at the size that the first "
    "answer has. On with --landmarks.",
)
@seed_option
@click.option(
    "--export",
    "exports",
    type=click.Choice(SHAPE_EXPORTS + MAP_EXPORTS),
    multiple=True,
    help="Further files of each answer, as of sherd match. May be repeated.",
)
@click.option(
    "--format",
    "file_format",
    type=click.Choice(["csv", "parquet"]),
    default="csv",
    show_default=True,
    help="Parquet: correspondence and summary in this format too; needs the extra.",
)
@overwrite_option
@click.option("--json", "as_json", is_flag=True, help="Print a line of JSON for each part.")
@quiet_option()
def batch_command(  # noqa: PLR0913 - one for each word that can be typed
    fulls: tuple[Path, ...],
    *,
    parts: str | None,
    output: Path | None,
    all_pairs: str | None,
    jobs: int | None,
    memory: float | None,
    dask: str | None,
    shard: str | None,
    collect: Path | None,
    scale: Scale | float,
    part_unit: Unit | None,
    full_unit: Unit | None,
    template: Path | None,
    side: Side,
    min_confidence: float,
    named: tuple[str, ...],
    mesh_space: Space | None,
    fit_scale: bool | None,
    seed: int,
    exports: tuple[str, ...],
    file_format: str,
    overwrite: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Match many parts, each with the mesh FULL it belongs to, and go on after any interruption.

    FULL may be a library of sherd template, which stands for all its shapes.

    Writes parts/NAME for each part, as sherd match does, summary.csv, summary.json and gallery.html
    to the output folder. What has an answer there to the same question is not computed again. A
    part that fails is a row with its reason.

    With --all-pairs there is no FULL: writes shared_area.csv, likeness.csv, matrix.png, the
    summaries, and parts/A--B for each pair that is alike enough, as sherd overlap does.

    Exit code 0 if all parts are good, or all pairs answered; 4 if all parts have an answer but not
    all a good one; 6 if some have none.

    \b
    Examples:
      sherd batch template.ply --parts scans/ -o out/
      sherd batch cat.ply dog.ply --parts "scans/*.ply" -o out/ --jobs 4
      sherd batch library/ --parts scans/ -o out/
      sherd batch template.ply --parts scans/ -o out/ --shard 1/10
      sherd batch --collect out/
      sherd batch skull.ply --parts scans/ --landmarks skull.mrk.json -o out/
      sherd batch template.ply --parts scans/ -o out/ --dask tcp://10.0.0.1:8786
      sherd batch --all-pairs fragments/ -o pairs/
    """  # noqa: D301
    tell = _json_line if as_json else _nothing
    if collect is not None:
        if fulls or parts or output:
            raise click.UsageError("--collect takes nothing but the folder of a batch")
        collected = collect_batch(collect)
        for row in collected.rows:
            tell(row)
        return _finish(collected, quiet=quiet or as_json)
    pairs = all_pairs is not None
    if output is None or not (pairs or (fulls and parts is not None)):
        raise click.UsageError("FULL, --parts and -o are needed, or --all-pairs, or --collect")
    if pairs and (fulls or parts or template or part_unit or full_unit):
        raise click.UsageError("--all-pairs has no full shape: leave out what is about one")
    if template is not None and len(fulls) > 1:
        raise click.UsageError("--template is of one full shape; of several, -o keeps them")
    if named and (pairs or shard):
        raise click.UsageError(
            "--landmarks is for a whole batch with a full shape; of shards, use sherd landmarks "
            "when all are there"
        )
    lists = _landmarks_of(fulls, named)
    if dask is not None and jobs is not None:
        raise click.UsageError("--jobs are processes here; a Dask cluster brings its own")
    asked = BatchOptions(
        min_confidence=min_confidence,
        fit_scale=(bool(lists) and scale != "unknown") if fit_scale is None else fit_scale,
        exports=exports if file_format == "csv" else (*exports, "parquet"),
        template=template,
        shard=shard,
        memory=None if memory is None else round(memory * 1e9),
        overwrite=overwrite,
    )
    questions: list[Callable[..., BatchResult | PairsResult]]
    if all_pairs is not None:
        questions = [partial(pairs_of, all_pairs, output, OverlapOptions(scale=scale, seed=seed))]
    else:
        options = MatchOptions(
            scale=scale, side=side, seed=seed, part_unit=part_unit, full_unit=full_unit
        )
        source = _source(parts or "")
        shapes = {output: list(fulls)}
        if lists and len(fulls) > 1:  # what landmarks are on is of one kind: all are asked
            shapes = {own: [full] for full, own in folders_by_template(fulls, output).items()}
            require_writable(output / LANDMARKS)
        questions = [partial(batch, each, source, own, options) for own, each in shapes.items()]
    prepare_first_run(quiet=quiet)
    with nullcontext() if dask is None else dask_executor(dask) as executor:
        results = [
            ask(batch_options=asked, jobs=jobs, executor=executor, tell=tell) for ask in questions
        ]
    if lists:
        batches = [each for each in results if isinstance(each, BatchResult)]
        carried = carried_to_parts(batches, lists, mesh_space=mesh_space)
        write_text(output / LANDMARKS, landmark_table(carried))
    return max(_finish(each, quiet=quiet or as_json) for each in results)


def _landmarks_of(fulls: Sequence[Path], named: Sequence[str]) -> dict[str, Landmarks]:
    lists = landmarks_by_template(named)
    without = {full.name for full in fulls} - set(lists)
    libraries = [full for full in fulls if full.is_dir()]
    if lists and libraries:
        raise click.UsageError(f"{libraries[0]}: landmarks are of files; name those of the library")
    if lists and ANY_TEMPLATE not in lists and without:
        raise click.UsageError(f"--landmarks: none are given for {', '.join(sorted(without))}")
    return lists


def _source(parts: str) -> PartSource:
    path = Path(parts)
    return parts_of_table(path) if path.suffix.lower() == ".csv" else parts


def _finish(result: BatchResult | PairsResult, *, quiet: bool) -> int:
    page = result.folder / ("gallery.html" if isinstance(result, BatchResult) else "matrix.png")
    if not quiet:
        for row in result.rows:
            if row.status == FAILED:
                click.echo(f"{click.style('failed:', fg='red')} {row.name}: {row.reason}", err=True)
        click.echo(f"{result.words}.")
        if page.exists():
            click.echo(f"Open {page} to see them.")
    if not result.all_answered:
        return SOME_FAILED
    good = isinstance(result, PairsResult) or result.all_good
    return 0 if good else NOT_CONVERGED


def _json_line(row: Row) -> None:
    click.echo(json.dumps(asdict(row), allow_nan=False))


def _nothing(_row: Row) -> None:
    """Rows are in the summary."""
