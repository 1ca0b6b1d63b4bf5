"""`sherd overlap`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click
import numpy as np

from sherd.cli.exits import NOT_CONVERGED
from sherd.cli.first_run import prepare_first_run
from sherd.cli.inputs import ScaleType, check_outputs, command_line, show_overlap_notices
from sherd.cli.options import json_option, overwrite_option, quiet_option, seed_option
from sherd.cli.tables import read_ignored, read_landmarks
from sherd.limits import require_seed
from sherd.output import Stages
from sherd.overlap import STAGES, overlap
from sherd.report.exports import SHAPE_EXPORTS
from sherd.report.stored.folder import OVERLAP_FORMAT
from sherd.report.write import write_report
from sherd.results.match_options import SCALES, Scale
from sherd.results.overlap_options import STRAIN, OverlapOptions
from sherd.results.overlap_result import Overlap
from sherd.results.status import Status
from sherd.scan.intake import Intake, scan_intake
from sherd.scan.numbering import repaired_vertices

__all__ = ["overlap_and_write", "overlap_command", "overlap_summary"]

FILE = click.Path(path_type=Path)


@click.command("overlap")
@click.argument("first", type=FILE)
@click.argument("second", type=FILE)
@click.option("-o", "--output", type=FILE, required=True, help="Folder.")
@click.option(
    "--scale",
    type=ScaleType(),
    metavar=f"[{'|'.join(SCALES)}|FACTOR]",
    default="same",
    show_default=True,
    help="Unknown: the scale of SECOND is estimated within half and twice that of FIRST. A number: "
    "SECOND is enlarged by it.",
)
@click.option(
    "--strain",
    type=float,
    default=STRAIN,
    show_default=True,
    help="How alike is enough: 0.1 accepts what must be stretched or bent in its plane by a tenth.",
)
@click.option("--landmarks", type=FILE, help="CSV with columns first_vertex,second_vertex.")
@click.option("--ignore-first", type=FILE, help="CSV with a column first_vertex.")
@click.option("--ignore-second", type=FILE, help="CSV with a column second_vertex.")
@seed_option
@click.option(
    "--export",
    "exports",
    type=click.Choice(SHAPE_EXPORTS),
    multiple=True,
    help="Further files: ParaView (vtp), web viewers (glb). May be repeated.",
)
@overwrite_option
@json_option
@quiet_option()
def overlap_command(  # noqa: PLR0913 - one for each word that can be typed
    first: Path,
    second: Path,
    output: Path,
    *,
    scale: Scale | float,
    strain: float,
    landmarks: Path | None,
    ignore_first: Path | None,
    ignore_second: Path | None,
    seed: int,
    exports: tuple[str, ...],
    overwrite: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Find what the incomplete shapes FIRST and SECOND share, and which point is which.

    Writes correspondence.csv, inverse.csv, first_region.csv, second_region.csv, first.ply,
    second.ply, overlap.png, report.html and result.json to the output folder.

    \b
    Examples:
      sherd overlap left.ply right.ply -o out/
      sherd overlap left.ply right.ply -o out/ --scale unknown
      sherd overlap cat.ply dog.ply -o out/ --strain 0.3
    """  # noqa: D301
    require_seed(seed)
    check_outputs(output, OVERLAP_FORMAT, first, second, overwrite=overwrite)
    prepare_first_run(quiet=quiet)
    stages = Stages(len(STAGES) + 1, visible=False if quiet else None)
    shapes = (scan_intake(first), scan_intake(second))
    options = OverlapOptions(
        scale=scale,
        strain=strain,
        landmarks=_landmarks(landmarks, *shapes),
        ignore_first=_ignored(ignore_first, shapes[0], "first_vertex"),
        ignore_second=_ignored(ignore_second, shapes[1], "second_vertex"),
        seed=seed,
    )
    result, document = overlap_and_write(*shapes, output, options, stages, exports=exports)
    stages.close()
    show_overlap_notices(result, quiet=quiet)
    if as_json:
        click.echo(json.dumps(document, indent=2))
    elif not quiet:
        click.echo(overlap_summary(result, output))
    return 0 if result.status is Status.GOOD else NOT_CONVERGED


def overlap_and_write(
    first: Intake,
    second: Intake,
    output: Path,
    options: OverlapOptions,
    stages: Stages,
    *,
    exports: tuple[str, ...] = (),
) -> tuple[Overlap, dict[str, Any]]:
    """Ask, and write the answer into a folder that `check_outputs` has found free."""
    result = overlap(first, second, options, stages=stages)
    with stages("files"):
        document = write_report(
            result,
            output,
            command=command_line(),
            exports=exports,
            overwrite=True,  # check_outputs has asked
        )
    return result, document


def overlap_summary(result: Overlap, output: Path) -> str:
    """The answer in a few lines for the terminal."""
    lines = [
        f"{100 * result.shared_of_first:.1f} % of the first shape and "
        f"{100 * result.shared_of_second:.1f} % of the second are shared; the chance that this is "
        f"right is {result.chance:.2f}."
    ]
    if result.scale != 1.0 or result.options.scale == "unknown":
        lines.append(f"The second shape was enlarged {result.scale:.4g} times to fit.")
    if result.status is not Status.GOOD:
        lines.append(f"The result is {result.advice}.")
    lines.append(f"Open {output / 'report.html'} to see it; numbers are in {output}.")
    return "\n".join(lines)


def _landmarks(path: Path | None, first: Intake, second: Intake) -> tuple[tuple[int, int], ...]:
    if path is None:
        return ()
    on_first, on_second = read_landmarks(path, names=("first_vertex", "second_vertex"))
    # refused here, where the file has a name
    repaired_vertices(first, on_first, what=f"{path}:")
    repaired_vertices(second, on_second, what=f"{path}:")
    return tuple(zip(on_first.tolist(), on_second.tolist(), strict=True))


def _ignored(path: Path | None, shape: Intake, column: str) -> tuple[int, ...]:
    if path is None:
        return ()
    vertices = read_ignored(path, column=column)
    known = np.clip(vertices, 0, shape.original.vertex_count - 1)
    # a vertex that repair left out is ignored anyway
    kept = vertices[(shape.report.new_vertices[known] >= 0) | (known != vertices)]
    repaired_vertices(shape, kept, what=f"{path}:")
    return tuple(kept.tolist())
