"""`sherd identify`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import click

from sherd.cli.exits import NOT_CONVERGED
from sherd.cli.first_run import prepare_first_run
from sherd.cli.inputs import ScaleType, command_line, show_notices
from sherd.cli.options import json_option, overwrite_option, quiet_option, seed_option, side_option
from sherd.errors import InfeasibleError, OutputError
from sherd.library.folder import Library
from sherd.library.identify import STAGES, candidates, identify_among
from sherd.mesh.units import UNITS, Unit
from sherd.output import Stages
from sherd.report.stored.folder import MATCH_FORMAT
from sherd.report.write import write_report
from sherd.result_folder import NAMES, ResultKind, replaceable_files
from sherd.results.many.identification import Identification
from sherd.results.many.identify_options import MATCHES, IdentifyOptions
from sherd.results.match_options import SCALES, Scale
from sherd.results.status import Status
from sherd.scan.either_side import Side
from sherd.scan.intake import scan_intake

__all__ = ["identification_summary", "identify_command"]

FILE = click.Path(path_type=Path)


@click.command("identify")
@click.argument("fulls", metavar="FULL...|LIBRARY", type=FILE, nargs=-1, required=True)
@click.argument("part", type=FILE)
@click.option("-o", "--output", type=FILE, required=True, help="Folder.")
@click.option(
    "--scale",
    type=ScaleType(),
    metavar=f"[{'|'.join(SCALES)}|FACTOR]",
    default="same",
    show_default=True,
    help="As in sherd match; all full shapes have one unit.",
)
@click.option("--part-unit", type=click.Choice(UNITS), help="Unit of PART; with --full-unit.")
@click.option(
    "--full-unit", type=click.Choice(UNITS), help="Unit of the full shapes; with --part-unit."
)
@side_option()
@click.option(
    "--matches",
    type=int,
    default=MATCHES,
    show_default=True,
    help="So many full shapes are matched with PART at most; the others by cheap evidence.",
)
@seed_option
@overwrite_option
@json_option
@quiet_option()
def identify_command(  # noqa: PLR0913 - one for each word that can be typed
    fulls: tuple[Path, ...],
    part: Path,
    output: Path,
    *,
    scale: Scale | float,
    part_unit: Unit | None,
    full_unit: Unit | None,
    side: Side,
    matches: int,
    seed: int,
    overwrite: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Find which of the full shapes the piece PART belongs to, or that it belongs to none.

    The full shapes are meshes, or a library of them that `sherd template` made. The output folder
    reads as that of sherd match with the likeliest one; candidates.csv has all. The exit code is 4
    unless the answer is good.

    \b
    Examples:
      sherd identify cat.ply horse.ply wolf.ply scan.ply -o out/
      sherd identify library/ scan.ply -o out/
    """  # noqa: D301
    options = IdentifyOptions(
        scale=scale,
        side=side,
        seed=seed,
        part_unit=part_unit,
        full_unit=full_unit,
        matches=matches,
    )
    library = _library(fulls)
    names = [p.name for p in fulls] if library is None else [s.name for s in library.shelves]
    _require_free(output, names, part, overwrite=overwrite)
    prepare_first_run(quiet=quiet)
    stages = Stages(len(STAGES) + 1, visible=False if quiet else None)
    scan = scan_intake(part)
    with stages("full shapes"):
        known = candidates(fulls if library is None else library)
    result = identify_among(known, scan, options, stages)
    first = result.candidates[0].match
    if first is None:
        stages.close()
        raise InfeasibleError(f"{part}: {result.advice}")
    with stages("files"):
        document = write_report(result, output, command=command_line(), overwrite=True)
    stages.close()
    show_notices(first, quiet=quiet)
    if as_json:
        click.echo(json.dumps(document, indent=2))
    elif not quiet:
        click.echo(identification_summary(result, output))
    return 0 if result.status is Status.GOOD else NOT_CONVERGED


def identification_summary(result: Identification, output: Path) -> str:
    """The answer in a few lines for the terminal."""
    width = max(len(each.name) for each in result.candidates)
    lines = [
        f"{each.name:<{width}}  evidence {each.evidence:.2f}  {each.said}"
        for each in result.candidates
    ]
    lines.append(f"The result is {result.advice}.")
    lines.append(f"Open {output / 'report.html'} to see it; numbers are in {output}.")
    return "\n".join(lines)


def _library(fulls: Sequence[Path]) -> Library | None:
    """The library that is named; None if full shapes are."""
    folders = [path for path in fulls if path.is_dir()]
    if folders and len(fulls) > 1:
        raise click.UsageError(f"{folders[0]}: a library is named alone, before PART")
    return Library.open(folders[0]) if folders else None


def _require_free(folder: Path, names: Sequence[str], part: Path, *, overwrite: bool) -> None:
    """Refuse a folder that holds neither nothing nor an older answer about the same part."""
    if part.name in NAMES and part.resolve().parent == folder.resolve():
        raise OutputError(f"{part}: would be replaced by the result; choose another folder")
    refusals = []
    for name in names:
        try:
            replaceable_files(
                folder, ResultKind(MATCH_FORMAT, name, part.name), overwrite=overwrite
            )
        except OutputError as error:
            refusals.append(error)
    if refusals and len(refusals) == len(names):
        raise refusals[0]
