"""`sherd assemble`."""

from __future__ import annotations

import json
from pathlib import Path

import click
from click.core import ParameterSource

from sherd.assemble import assemble
from sherd.cli.exits import NOT_CONVERGED
from sherd.cli.first_run import prepare_first_run
from sherd.cli.inputs import (
    check_piece_outputs,
    command_line,
    show_assembly_notices,
    show_joined_notices,
    stored_template,
)
from sherd.cli.options import (
    json_option,
    overwrite_option,
    quiet_option,
    seed_option,
    side_option,
    template_option,
)
from sherd.join import join
from sherd.limits import require_seed
from sherd.output import Stages
from sherd.report.write import write_report
from sherd.results.puzzle.assemble_options import TOLERANCE, AssembleOptions
from sherd.results.puzzle.assembly import Assembly
from sherd.results.puzzle.joined import Joined
from sherd.results.status import Status
from sherd.scan.either_side import Side
from sherd.scan.intake import scan_intake

__all__ = ["assemble_command", "assembly_summary", "joined_summary"]

FILE = click.Path(path_type=Path)


@click.command("assemble")
@click.argument("shapes", type=FILE, nargs=-1, required=True, metavar="[FULL] PIECE...")
@click.option("-o", "--output", type=FILE, required=True, help="Folder.")
@click.option(
    "--may-overlap",
    is_flag=True,
    help="Pieces may lie on each other without limit, as scans of one region do.",
)
@click.option(
    "--no-full",
    is_flag=True,
    help="All files are pieces, which overlap: find groups, and their points on each other.",
)
@click.option("--rigid", is_flag=True, help="Pieces may only be turned and shifted.")
@click.option(
    "--tolerance",
    type=float,
    default=TOLERANCE,
    show_default=True,
    help="For rigid pieces: what is farther off is worn; in sqrt(area) of FULL, so 8 mm for a vase "
    "of 30 cm.",
)
@template_option
@side_option("all pieces")
@seed_option
@overwrite_option
@json_option
@quiet_option()
def assemble_command(  # noqa: PLR0913 - one for each word that can be typed
    shapes: tuple[Path, ...],
    output: Path,
    *,
    may_overlap: bool,
    no_full: bool,
    rigid: bool,
    tolerance: float,
    template: Path | None,
    side: Side,
    seed: int,
    overwrite: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Place all pieces on the mesh FULL together: what belongs where, what is missing or foreign.

    Writes labels.csv, piece_K/correspondence.csv for each placed piece, from 0 in the order given,
    full.ply and piece_K/part.ply in the colors of the pieces, assembly.png, report.html and
    result.json to the output folder; of rigid pieces piece_K/placed.ply, too, as they lie on FULL.
    Exit code 4 if a placed piece is in doubt or none has a place; that one is refused is an answer.

    With --no-full there is no whole: writes pairs.csv, piece_K/partners.csv with the points of each
    piece on the others, piece_K/part.ply, assembly.png, report.html and result.json. Exit code 4 if
    nothing surely belongs together.

    \b
    Examples:
      sherd assemble template.ply piece*.ply -o out/
      sherd assemble vase.ply sherd*.ply -o out/ --rigid
      sherd assemble template.ply scan1.ply scan2.ply -o out/ --may-overlap
      sherd assemble --no-full scan*.ply -o out/
    """  # noqa: D301
    require_seed(seed)
    needless = ("tolerance", "side")
    if no_full and (rigid or may_overlap or template is not None or any(map(_typed, needless))):
        raise click.UsageError(
            "--rigid, --tolerance, --may-overlap, --template and --side need a whole: leave "
            "--no-full out and name the whole first"
        )
    if _typed("tolerance") and not rigid:
        raise click.UsageError("--tolerance is for rigid pieces: give --rigid, or leave it out")
    options = AssembleOptions(
        may_overlap=may_overlap, rigid=rigid, tolerance=tolerance, side=side, seed=seed
    )
    if len(shapes) < 2:
        raise click.UsageError(
            "give a whole and at least one piece, or, with --no-full, two pieces"
        )
    full, pieces = (None, shapes) if no_full else (shapes[0], shapes[1:])
    check_piece_outputs(output, full, pieces, overwrite=overwrite, template=template)
    prepare_first_run(quiet=quiet)
    stages = Stages(visible=False if quiet else None)
    intakes = [scan_intake(piece) for piece in pieces]
    result: Assembly | Joined
    if full is None:
        result = join(intakes, options, stages=stages)
    else:
        described = stored_template(template, full, quiet=quiet)
        result = assemble(described, intakes, options, stages=stages)
    with stages("files"):
        document = write_report(
            result,
            output,
            command=command_line(),
            overwrite=True,  # check_piece_outputs has asked
        )
    stages.close()
    if isinstance(result, Joined):
        show_joined_notices(result, quiet=quiet)
    else:
        show_assembly_notices(result, quiet=quiet)
    if as_json:
        click.echo(json.dumps(document, indent=2))
    elif not quiet:
        summary = joined_summary if isinstance(result, Joined) else assembly_summary
        click.echo(summary(result, output))  # type: ignore[arg-type]
    return 0 if document["status"] == Status.GOOD.name.lower() else NOT_CONVERGED


def _typed(option: str) -> bool:
    """Whether an option was given, and is not the default."""
    source = click.get_current_context().get_parameter_source(option)
    return source not in (None, ParameterSource.DEFAULT)


def joined_summary(result: Joined, output: Path) -> str:
    """The answer in a few lines for the terminal."""
    lines = []
    for group in result.groups:
        names = ", ".join(f"{k} {result.named(k)}" for k in group)
        lines.append(f"together: {names}" if len(group) > 1 else f"alone: {names}")
    lines.append(f"Open {output / 'report.html'} to see it; numbers are in {output}.")
    return "\n".join(lines)


def assembly_summary(result: Assembly, output: Path) -> str:
    """The answer in a few lines for the terminal."""
    lines = [_piece_line(result, piece) for piece in range(len(result.pieces))]
    lines.append(f"{100 * result.gap_share:.1f} % of the full shape is covered by no piece.")
    if not result.proven:
        lines.append(
            "There may be a better choice of places for all pieces together; give fewer at a time."
        )
    lines.append(f"Open {output / 'report.html'} to see it; numbers are in {output}.")
    return "\n".join(lines)


def _piece_line(result: Assembly, number: int) -> str:
    piece = result.pieces[number]
    if not piece.placed:
        return f"{number} {piece.part.name}: refused; {piece.reason}."
    share = float(result.full.vertex_areas @ (result.labels == number)) / result.full.area
    said = f"{number} {piece.part.name}: {100 * share:.1f} % of the full shape"
    if not piece.sure:
        return f"{said}; {piece.reason}"
    return f"{said}, chance {piece.chance:.2f}"
