"""`sherd match`."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
import numpy as np

from sherd.cli.exits import NOT_CONVERGED
from sherd.cli.first_run import prepare_first_run
from sherd.cli.inputs import (
    ScaleType,
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
from sherd.cli.tables import read_ground_truth, read_ignored, read_landmarks
from sherd.library.fitted_scale import match_with_fitted_scale
from sherd.limits import require_finite, require_seed
from sherd.match import STAGES, match
from sherd.mesh.units import UNITS, Unit
from sherd.output import Stages
from sherd.report.exports import MAP_EXPORTS, SHAPE_EXPORTS, require_exports
from sherd.report.stored.folder import MATCH_FORMAT
from sherd.report.write import write_report
from sherd.results.match_options import SCALES, MatchOptions, Scale
from sherd.results.match_result import MatchResult
from sherd.results.status import Status
from sherd.scan.either_side import Side
from sherd.scan.intake import Intake, scan_intake
from sherd.scan.numbering import repaired_vertices
from sherd.spectral.surface_distances import SurfaceDistances
from sherd.surface.template import Template

__all__ = ["match_and_write", "match_command", "match_summary"]

FILE = click.Path(path_type=Path)


@click.command("match")
@click.argument("full", type=FILE)
@click.argument("part", type=FILE)
@click.option("-o", "--output", type=FILE, required=True, help="Folder.")
@click.option(
    "--scale",
    type=ScaleType(),
    metavar=f"[{'|'.join(SCALES)}|FACTOR]",
    default="same",
    show_default=True,
    help="Unknown: the part's scale is estimated, whatever its unit; it may have 0.01 to 1.3 times "
    "the area of FULL. A number: lengths of PART are multiplied by it.",
)
@click.option(
    "--fit-scale",
    is_flag=True,
    help="PART is of another individual: match again at the size that the first answer has.",
)
@click.option("--part-unit", type=click.Choice(UNITS), help="Unit of PART; with --full-unit.")
@click.option("--full-unit", type=click.Choice(UNITS), help="Unit of FULL; with --part-unit.")
@click.option("--landmarks", type=FILE, help="CSV with columns part_vertex,full_vertex.")
@click.option("--ignore", type=FILE, help="CSV with a column part_vertex: clothing, support.")
@click.option("--ground-truth", type=FILE, help="CSV as written here, or SHREC'16 .baryc_gt.")
@template_option
@side_option()
@click.option(
    "--min-confidence",
    type=float,
    default=0.0,
    show_default=True,
    help="Below it a vertex counts as unmatched; 0 to 1.",
)
@seed_option
@click.option(
    "--export",
    "exports",
    type=click.Choice(SHAPE_EXPORTS + MAP_EXPORTS),
    multiple=True,
    help="Further files: ParaView (vtp), web viewers (glb), NumPy, MATLAB, vertex maps from 0 "
    "(map) or 1 (vts), correspondence as Parquet. May be repeated.",
)
@overwrite_option
@json_option
@quiet_option()
def match_command(  # noqa: PLR0913 - one for each word that can be typed
    full: Path,
    part: Path,
    output: Path,
    *,
    scale: Scale | float,
    fit_scale: bool,
    part_unit: Unit | None,
    full_unit: Unit | None,
    landmarks: Path | None,
    ignore: Path | None,
    ground_truth: Path | None,
    template: Path | None,
    side: Side,
    min_confidence: float,
    seed: int,
    exports: tuple[str, ...],
    overwrite: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Find for every vertex of the piece PART its point on the mesh FULL.

    Writes correspondence.csv, region.csv, full.ply, part.ply, match.png, report.html and
    result.json to the output folder.

    \b
    Examples:
      sherd match template.ply scan.ply -o out/
      sherd match template.ply scan.ply -o out/ --scale unknown
      sherd match template.ply scan.ply -o out/ --part-unit mm --full-unit m
      sherd match template.ply scan.ply -o out/ --landmarks pairs.csv --export vtp
    """  # noqa: D301
    require_finite("min_confidence", min_confidence, 0, 1, "it is a chance")
    require_seed(seed)
    require_exports(exports)
    check_outputs(output, MATCH_FORMAT, full, part, overwrite=overwrite, template=template)
    prepare_first_run(quiet=quiet)
    stages = Stages(len(STAGES) + 1, visible=False if quiet else None)
    template_read = begun_template(template, full, quiet=quiet)
    scan = scan_intake(part)
    described = template_read()
    options = MatchOptions(
        scale=scale,
        landmarks=_landmarks(landmarks, described.intake, scan),
        ignore=_ignored(ignore, scan),
        side=side,
        seed=seed,
        part_unit=part_unit,
        full_unit=full_unit,
    )
    result, document = match_and_write(
        described,
        scan,
        output,
        options=options,
        stages=stages,
        truth=ground_truth,
        exports=exports,
        min_confidence=min_confidence,
        ask=match_with_fitted_scale if fit_scale else match,
    )
    stages.close()
    show_notices(result, quiet=quiet)
    if as_json:
        click.echo(json.dumps(document, indent=2))
    elif not quiet:
        click.echo(match_summary(result, document, output))
    return 0 if result.status is Status.GOOD else NOT_CONVERGED


def match_and_write(  # noqa: PLR0913 - all by name
    full: Template,
    part: Intake,
    output: Path,
    *,
    options: MatchOptions,
    stages: Stages,
    truth: Path | None = None,
    exports: tuple[str, ...] = (),
    min_confidence: float = 0.0,
    ask: Callable[..., MatchResult] = match,
) -> tuple[MatchResult, dict[str, Any]]:
    """Match and write the answer into a folder that `check_outputs` has found free."""
    true_points = None if truth is None else read_ground_truth(truth, full.full, part.original)
    result = ask(full, part, options, stages=stages).with_min_confidence(min_confidence)
    with stages("files"):
        errors = None
        if true_points is not None:
            errors = SurfaceDistances(result.full).between(true_points, result.points)
        document = write_report(
            result,
            output,
            command=command_line(),
            errors=errors,
            exports=exports,
            overwrite=True,  # check_outputs has asked
        )
    return result, document


def match_summary(result: MatchResult, document: dict[str, Any], output: Path) -> str:
    """The answer in a few lines for the terminal."""
    lines = [
        f"The part is {100 * document['area_fraction']:.1f} % of the full shape; "
        f"{document['unmatched']} of {result.part.vertex_count} vertices unmatched, mean "
        f"confidence {document['mean_confidence']:.2f}."
    ]
    if result.scale != 1.0 or result.options.scale == "unknown":
        lines.append(f"Lengths of the part were multiplied by {result.scale:.4g} to fit.")
    lines += [
        f"Alternative: {other.name}, score {other.score:.3f}" for other in result.alternatives
    ]
    if result.status is not Status.GOOD:
        lines.append(f"The result is {result.advice}.")
    if "ground_truth" in document:
        mean = document["ground_truth"]["mean_error_x100"]
        lines.append(f"Mean error against the ground truth: {mean:.2f} % of sqrt(area).")
    lines.append(f"Open {output / 'report.html'} to see it; numbers are in {output}.")
    return "\n".join(lines)


def _landmarks(path: Path | None, full: Intake, part: Intake) -> tuple[tuple[int, int], ...]:
    if path is None:
        return ()
    on_part, on_full = read_landmarks(path)
    # refused here, where the file has a name
    repaired_vertices(part, on_part, what=f"{path}:")
    repaired_vertices(full, on_full, what=f"{path}:")
    return tuple(zip(on_part.tolist(), on_full.tolist(), strict=True))


def _ignored(path: Path | None, part: Intake) -> tuple[int, ...]:
    if path is None:
        return ()
    vertices = read_ignored(path)
    known = np.clip(vertices, 0, part.original.vertex_count - 1)
    # a vertex that repair left out is ignored anyway
    kept = vertices[(part.report.new_vertices[known] >= 0) | (known != vertices)]
    repaired_vertices(part, kept, what=f"{path}:")
    return tuple(kept.tolist())
