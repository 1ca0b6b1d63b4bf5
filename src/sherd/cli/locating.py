"""`sherd locate`."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import numpy as np

from sherd.cli.exits import NOT_CONVERGED
from sherd.cli.inputs import (
    PreparedMesh,
    command_line,
    prepared_mesh,
    prepared_part,
    show_notices,
)
from sherd.output import Stages
from sherd.region.locate import locate
from sherd.region.options import DESCRIPTORS, METHODS, SOLVERS, LocateOptions
from sherd.region.region import Placement, Region
from sherd.report.exports import SHAPE_EXPORTS
from sherd.report.region_report import write_region_report

__all__ = ["locate_and_write", "locate_command"]

# samples, eigenbasis, descriptors, votes, region, alternatives, files
STAGE_COUNT = 7
DEFAULTS = LocateOptions()


@click.command("locate")
@click.argument("full", type=click.Path(path_type=Path))
@click.argument("part", type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True, help="Folder.")
@click.option("--method", type=click.Choice(METHODS), default=DEFAULTS.method, show_default=True)
@click.option(
    "--descriptor",
    type=click.Choice(DESCRIPTORS),
    default=DEFAULTS.descriptor,
    show_default=True,
    help="Of the methods that match integrals; voting has its own.",
)
@click.option(
    "--solver",
    type=click.Choice(SOLVERS),
    default=DEFAULTS.solver,
    show_default=True,
    help="Of --method subspace.",
)
@click.option("--basis-size", type=int, default=DEFAULTS.basis_size, show_default=True)
@click.option("--regularity", type=float, help="lambda_r of the paper; automatic if not given.")
@click.option("--smoothness", type=float, help="lambda_s of the paper; automatic if not given.")
@click.option("--boundary", type=float, help="lambda_b of the paper; automatic if not given.")
@click.option("--phase-width", type=float, help="epsilon of the paper; automatic if not given.")
@click.option("--iterations", type=int, default=DEFAULTS.iterations, show_default=True)
@click.option("--vocabulary-size", type=int, default=DEFAULTS.vocabulary_size, show_default=True)
@click.option("--seed", type=int, default=DEFAULTS.seed, show_default=True)
@click.option(
    "--export",
    "exports",
    type=click.Choice(SHAPE_EXPORTS),
    multiple=True,
    help="Further files: ParaView, NumPy, MATLAB. May be repeated.",
)
@click.option("--json", "as_json", is_flag=True, help="Print result.json on standard output.")
@click.option("-q", "--quiet", is_flag=True, help="Print errors only.")
def locate_command(
    full: Path,
    part: Path,
    output: Path,
    *,
    exports: tuple[str, ...],
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
    stages = Stages(STAGE_COUNT, visible=False if quiet else None)
    region, result = locate_and_write(
        prepared_mesh(full),
        prepared_part(part),
        output,
        options=options,
        stages=stages,
        exports=exports,
    )
    stages.close()
    if as_json:
        click.echo(json.dumps(result, indent=2))
    elif not quiet:
        click.echo(summary(region, output))
    return 0 if region.status.succeeded else NOT_CONVERGED


def locate_and_write(
    full: PreparedMesh,
    part: PreparedMesh,
    output: Path,
    *,
    options: LocateOptions,
    stages: Stages,
    exports: tuple[str, ...] = (),
) -> tuple[Region, dict[str, Any]]:
    """Locate on the repaired meshes and write the answer in the numbering of the files."""
    found = locate(full.repaired, part.repaired, options, stages=stages)
    if part.one_sided:  # points without normals: the side on which neighborhoods agree is outside
        turned = part.turned()
        other = locate(full.repaired, turned.repaired, options, stages=stages)
        if other.score > found.score:
            found, part = other, turned
    show_notices(full, part)
    region = _as_read(found, full, part)
    with stages("files"):
        notices = {"full": full.notices, "part": part.notices}
        result = write_region_report(
            region, output, command=command_line(), notices=notices, exports=exports
        )
    return region, result


def summary(region: Region, output: Path) -> str:
    """The answer in a few lines for the terminal."""
    lines = [
        f"The part is {100 * region.area_fraction:.1f} % of the full shape; "
        f"score {region.score:.3f}, {region.status.name.lower().replace('_', ' ')}."
    ]
    lines += [
        f"Alternative: {other.name}, score {other.score:.3f}" for other in region.alternatives
    ]
    lines.append(f"Open {output / 'report.html'} to see it; numbers are in {output}.")
    return "\n".join(lines)


def _as_read(region: Region, full: PreparedMesh, part: PreparedMesh) -> Region:
    """The region on the vertices of the user's files; vertices without a face are outside."""
    if not full.report.changed:
        return replace(region, full=full.original, part=part.original)
    lift = full.report.to_original
    return replace(
        region,
        full=full.original,
        part=part.original,
        membership=np.asarray(lift(region.membership, fill=0.0), dtype=np.float64),
        mask=np.asarray(lift(region.mask, fill=False), dtype=bool),
        phase_field=np.asarray(lift(region.phase_field, fill=1.0), dtype=np.float64),
        alternatives=tuple(
            Placement(
                other.name,
                np.asarray(lift(other.membership, fill=0.0), dtype=np.float64),
                np.asarray(lift(other.mask, fill=False), dtype=bool),
                other.score,
                other.mirrored,
            )
            for other in region.alternatives
        ),
    )
