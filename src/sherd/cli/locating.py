"""`sherd locate`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from sherd.cli.exits import NOT_CONVERGED
from sherd.cli.first_run import prepare_first_run
from sherd.cli.inputs import (
    begun_template,
    check_outputs,
    command_line,
    show_notices,
)
from sherd.cli.options import (
    json_option,
    overwrite_option,
    quiet_option,
    seed_option,
    side_option,
    template_option,
)
from sherd.locate import STAGES, locate
from sherd.output import Stages
from sherd.report.exports import SHAPE_EXPORTS
from sherd.report.stored.folder import REGION_FORMAT
from sherd.report.write import write_report
from sherd.results.locate_options import DESCRIPTORS, METHODS, SOLVERS, LocateOptions
from sherd.results.locate_result import LocateResult
from sherd.results.status import Status
from sherd.scan.intake import scan_intake

__all__ = ["locate_command"]

DEFAULTS = LocateOptions()
FILE = click.Path(path_type=Path)


@click.command("locate")
@click.argument("full", type=FILE)
@click.argument("part", type=FILE)
@click.option("-o", "--output", type=FILE, required=True, help="Folder.")
@click.option("--method", type=click.Choice(METHODS), default=DEFAULTS.method, show_default=True)
@click.option(
    "--descriptor",
    type=click.Choice(DESCRIPTORS),
    help="Of the methods that match integrals, shot if not given; voting has its own.",
)
@click.option(
    "--solver",
    type=click.Choice(SOLVERS),
    help="Of --method subspace, active-set if not given.",
)
@click.option("--basis-size", type=int, default=DEFAULTS.basis_size, show_default=True)
@click.option("--regularity", type=float, help="lambda_r of the paper; automatic if not given.")
@click.option("--smoothness", type=float, help="lambda_s of the paper; automatic if not given.")
@click.option("--boundary", type=float, help="lambda_b of the paper; automatic if not given.")
@click.option("--phase-width", type=float, help="epsilon of the paper; automatic if not given.")
@click.option("--iterations", type=int, help="Of --method subspace and full, 5 if not given.")
@click.option(
    "--vocabulary-size", type=int, help="Of the methods that match integrals, 160 if not given."
)
@side_option()
@template_option
@seed_option
@click.option(
    "--export",
    "exports",
    type=click.Choice(SHAPE_EXPORTS),
    multiple=True,
    help="Further files: ParaView (vtp), web viewers (glb), NumPy, MATLAB. May be repeated.",
)
@overwrite_option
@json_option
@quiet_option()
def locate_command(
    full: Path,
    part: Path,
    output: Path,
    *,
    template: Path | None,
    exports: tuple[str, ...],
    overwrite: bool,
    as_json: bool,
    quiet: bool,
    **parameters: Any,
) -> int:
    """Find the region of the mesh FULL where the deformed piece PART belongs.

    Writes region.csv, region.ply, part.ply, region.png, report.html and result.json to the
    output folder.

    \b
    Examples:
      sherd locate template.ply scan.ply -o out/
      sherd locate template.ply scan.ply -o out/ --export vtp --export mat
      sherd locate template.ply scan.ply -o out/ --method subspace
    """  # noqa: D301
    options = LocateOptions(**parameters)
    check_outputs(output, REGION_FORMAT, full, part, overwrite=overwrite, template=template)
    prepare_first_run(quiet=quiet)
    stages = Stages(len(STAGES) + 1, visible=False if quiet else None)
    template_read = begun_template(template, full, quiet=quiet)
    scan = scan_intake(part)
    result = locate(template_read(), scan, options, stages=stages)
    show_notices(result, quiet=quiet)
    with stages("files"):
        document = write_report(
            result,
            output,
            command=command_line(),
            exports=exports,
            overwrite=True,  # check_outputs has asked
        )
    stages.close()
    if as_json:
        click.echo(json.dumps(document, indent=2))
    elif not quiet:
        click.echo(summary(result, output))
    return 0 if result.trusted else NOT_CONVERGED


def summary(result: LocateResult, output: Path) -> str:
    """The answer in a few lines for the terminal."""
    lines = [
        f"The part is {100 * result.area_fraction:.1f} % of the full shape; "
        f"score {result.score:.3f}, {result.convergence.name.lower().replace('_', ' ')}."
    ]
    lines += [
        f"Alternative: {other.name}, score {other.score:.3f}" for other in result.alternatives
    ]
    if result.doubts.status is not Status.GOOD:
        lines.append(f"The result is {result.advice}.")
    lines.append(f"Open {output / 'report.html'} to see it; numbers are in {output}.")
    return "\n".join(lines)
