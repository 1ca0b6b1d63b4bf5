"""`sherd fit`."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import click

from sherd.assemble import assemble
from sherd.cli.exits import NOT_CONVERGED
from sherd.cli.first_run import prepare_first_run
from sherd.cli.inputs import (
    ScaleType,
    check_fit_outputs,
    command_line,
    show_fit_notices,
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
from sherd.files.obj_texture import has_texture
from sherd.fitting.fit import STAGES, fit
from sherd.library.fitted_scale import match_with_fitted_scale, sizing_after
from sherd.limits import require_seed
from sherd.match import STAGES as MATCH_STAGES
from sherd.match import match
from sherd.output import Stages
from sherd.report.fitted.fit_report import completion_words
from sherd.report.stored.stored_pieces import read_matches
from sherd.report.write import write_report
from sherd.results.fitted.fit_options import SIZINGS, FitOptions, Sizing
from sherd.results.fitted.fit_result import Fit
from sherd.results.match_options import SCALES, Scale
from sherd.results.match_result import MatchResult
from sherd.results.puzzle.assembly import Assembly
from sherd.results.status import Status
from sherd.scan.either_side import Side
from sherd.scan.intake import Intake, scan_intake
from sherd.surface.template import Template

__all__ = ["fit_command", "fit_summary"]

FILE = click.Path(path_type=Path)
NAMED = 4


@click.command("fit")
@click.argument("shapes", type=FILE, nargs=-1, metavar="[FULL PART...]")
@click.option("-o", "--output", type=FILE, required=True, help="Folder.")
@click.option(
    "--from",
    "source",
    type=FILE,
    help="Folder of an earlier match or assemble, instead of FULL and PART: nothing is matched.",
)
@click.option(
    "--sizing",
    type=click.Choice(SIZINGS),
    help="None: it is the same body, which bends only. Local: sized where PART asks for more than "
    "a pose may stretch. Individual: another one, as much larger as PART is. Not given: individual "
    "if one PART fits better at another size, otherwise local.",
)
@click.option(
    "--near",
    type=float,
    default=FitOptions.near,
    show_default=True,
    help="Chances are those to be within it; in sqrt(area) of FULL.",
)
@click.option(
    "--merge",
    is_flag=True,
    help="Also write completed.ply: the scan as it is, the fit where it has no surface.",
)
@click.option(
    "--texture",
    type=FILE,
    help="With --from, the OBJ file of FULL: fit.obj keeps its texture coordinates, groups and "
    "materials. Without, FULL itself is that file.",
)
@click.option(
    "--scale",
    type=ScaleType(),
    metavar=f"[{'|'.join(SCALES)}|FACTOR]",
    default="same",
    show_default=True,
    help="As for match; of one PART only.",
)
@template_option
@side_option()
@seed_option
@overwrite_option
@json_option
@quiet_option()
def fit_command(  # noqa: PLR0913 - one for each word that can be typed
    shapes: tuple[Path, ...],
    output: Path,
    *,
    source: Path | None,
    sizing: Sizing | None,
    near: float,
    merge: bool,
    texture: Path | None,
    scale: Scale | float,
    template: Path | None,
    side: Side,
    seed: int,
    overwrite: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Lay the mesh FULL onto the pieces PART, in their pose and place, with its own vertices.

    Matches first, or takes the match of an earlier run with --from. Several parts must lie in one
    coordinate system and pose, as scans of one body from several sides do. What no part shows
    continues as FULL is.

    Writes fit.ply, fit.obj, fit.glb (which morphs from FULL to the fit), fit.csv, full.ply,
    piece_K/part.ply and piece_K/distances.csv for each part, fit.png, report.html and result.json
    to the output folder. Exit code 4 if the fit is in doubt.

    \b
    Examples:
      sherd fit template.ply scan.ply -o out/
      sherd fit template.ply front.ply back.ply -o out/
      sherd fit --from matched/ -o out/
    """  # noqa: D301
    require_seed(seed)
    options = FitOptions(sizing=sizing or "local", near=near, merge=merge)
    if (source is None) == (not shapes):
        raise click.UsageError("give FULL and PART, or --from with a folder")
    if source is None and len(shapes) < 2:
        raise click.UsageError("give FULL and at least one PART")
    if source is not None and (template is not None or scale != "same"):
        raise click.UsageError("--template and --scale are for matching, which --from has done")
    if source is None and texture is not None:
        raise click.UsageError("--texture is for --from; FULL has its texture with it")
    if len(shapes) > 2 and scale != "same":
        raise click.UsageError("several parts must have the unit of FULL: --scale is for one")
    earlier = None if source is None else read_matches(source)
    check_fit_outputs(output, shapes, earlier, overwrite=overwrite, template=template)
    prepare_first_run(quiet=quiet)
    expected = len(STAGES) + 1 + (0 if earlier else len(MATCH_STAGES) * (len(shapes) - 1))
    stages = Stages(expected, visible=False if quiet else None)
    result: MatchResult | Assembly | tuple[MatchResult, ...]
    if earlier is not None:
        result = earlier
    else:
        parts = [scan_intake(part) for part in shapes[1:]]
        described = stored_template(template, shapes[0], quiet=quiet)
        ask = match if sizing == "none" or scale == "unknown" else match_with_fitted_scale
        result = _matched(described, parts, stages, ask=ask, scale=scale, side=side, seed=seed)
        if sizing is None and isinstance(result, MatchResult):
            options = replace(options, sizing=sizing_after(result, scale))
    if texture is None and shapes and has_texture(shapes[0]):
        texture = shapes[0]
    fitted = fit(result, options, stages=stages)
    with stages("files"):
        document = write_report(
            fitted,
            output,
            command=command_line(),
            texture=texture,
            overwrite=True,  # check_fit_outputs has asked
        )
    stages.close()
    show_fit_notices(fitted, quiet=quiet)
    if as_json:
        click.echo(json.dumps(document, indent=2))
    elif not quiet:
        click.echo(fit_summary(fitted, output))
    return 0 if fitted.status is Status.GOOD else NOT_CONVERGED


def _matched(
    full: Template,
    parts: Sequence[Intake],
    stages: Stages,
    *,
    ask: Callable[..., MatchResult],
    scale: Scale | float,
    side: Side,
    seed: int,
) -> MatchResult | Assembly:
    """One part matched; several placed together, since they may overlap but not contradict."""
    if len(parts) == 1:
        return ask(full, parts[0], scale=scale, side=side, seed=seed, stages=stages)
    return assemble(full, parts, may_overlap=True, side=side, seed=seed, stages=stages)


def fit_summary(result: Fit, output: Path) -> str:
    """The answer in a few lines for the terminal."""
    scan = result.scan_summary
    lines = [
        f"{100 * result.seen_share:.1f} % of the full shape was seen; scan to fit {scan.mean:.3g} "
        f"on average, 95 % below {scan.most:.3g}, at most {scan.largest:.3g}."
    ]
    lines += [
        f"Never seen, pose unknown: {100 * region.area:.1f} % around vertex {region.vertex}."
        for region in result.hidden[:NAMED]
    ]
    if result.completion is not None:
        lines.append(f"{output / 'completed.ply'} is {completion_words(result.completion)}.")
    if result.status is not Status.GOOD:
        lines.append(f"The result is {result.advice}.")
    lines.append(f"Open {output / 'report.html'} to see it; numbers are in {output}.")
    return "\n".join(lines)
