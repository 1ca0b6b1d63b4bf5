"""`sherd match`."""

from __future__ import annotations

import json
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
from sherd.cli.lifting import as_read, repaired_vertices
from sherd.cli.tables import read_ground_truth, read_ignored, read_landmarks
from sherd.either_side import is_sure_of_side
from sherd.errors import InputError
from sherd.match import MatchOptions, MatchResult, MatchStatus, match
from sherd.output import Stages
from sherd.report.exports import MAP_EXPORTS, SHAPE_EXPORTS
from sherd.report.match_report import write_match_report
from sherd.spectral.surface_distances import SurfaceDistances
from sherd.template import Template

__all__ = ["match_and_write", "match_command", "match_summary"]

# the seven of match, and files
STAGE_COUNT = 8
FILE = click.Path(path_type=Path)


@click.command("match")
@click.argument("full", type=FILE)
@click.argument("part", type=FILE)
@click.option("-o", "--output", type=FILE, required=True, help="Folder.")
@click.option(
    "--scale",
    type=click.Choice(["same", "unknown"]),
    default="same",
    show_default=True,
    help="Unknown: the part's scale is estimated within half and twice that of FULL.",
)
@click.option("--landmarks", type=FILE, help="CSV with columns part_vertex,full_vertex.")
@click.option("--ignore", type=FILE, help="CSV with a column part_vertex: clothing, support.")
@click.option("--ground-truth", type=FILE, help="CSV as written here, or SHREC'16 .baryc_gt.")
@click.option(
    "--template",
    type=FILE,
    help="File (.npz) that keeps what depends on FULL alone: made if missing, used if there.",
)
@click.option("--seed", type=int, default=0, show_default=True)
@click.option(
    "--export",
    "exports",
    type=click.Choice(SHAPE_EXPORTS + MAP_EXPORTS),
    multiple=True,
    help="Further files: ParaView, NumPy, MATLAB, vertex maps from 0 (map) or 1 (vts). May be "
    "repeated.",
)
@click.option("--json", "as_json", is_flag=True, help="Print result.json on standard output.")
@click.option("-q", "--quiet", is_flag=True, help="Print errors only.")
def match_command(
    full: Path, part: Path, output: Path, *, as_json: bool, quiet: bool, **hints: Any
) -> int:
    """Find for every vertex of the piece PART its point on the mesh FULL.

    Writes correspondence.csv, region.csv, full.ply, part.ply, match.png, report.html and
    result.json to the output folder.

    \b
    Examples:
      sherd match template.ply scan.ply -o out/
      sherd match template.ply scan.ply -o out/ --scale unknown
      sherd match template.ply scan.ply -o out/ --landmarks pairs.csv --export vtp
    """  # noqa: D301
    stages = Stages(STAGE_COUNT, visible=False if quiet else None)
    meshes = prepared_mesh(full), prepared_part(part)
    options = MatchOptions(
        scale=hints["scale"],
        landmarks=_landmarks(hints["landmarks"], *meshes),
        ignore=_ignored(hints["ignore"], meshes[1]),
        seed=hints["seed"],
    )
    template = _template(hints["template"], meshes[0])
    result, document = match_and_write(
        *meshes,
        output,
        options=options,
        stages=stages,
        template=template,
        truth=hints["ground_truth"],
        exports=hints["exports"],
    )
    stages.close()
    if as_json:
        click.echo(json.dumps(document, indent=2))
    elif not quiet:
        click.echo(match_summary(result, document, output))
    return 0 if result.status is not MatchStatus.DOUBTFUL else NOT_CONVERGED


def match_and_write(
    full: PreparedMesh,
    part: PreparedMesh,
    output: Path,
    *,
    options: MatchOptions,
    stages: Stages,
    template: Template | None = None,
    truth: Path | None = None,
    exports: tuple[str, ...] = (),
) -> tuple[MatchResult, dict[str, Any]]:
    """Match the repaired meshes and write the answer in the numbering of the files."""
    true_points = None if truth is None else read_ground_truth(truth, full.original, part.original)
    template = template or Template(full.repaired)
    found = match(template, part.repaired, options, stages=stages)
    # where the faces do not tell, the side on which neighborhoods agree is outside
    inside_out = found.status is MatchStatus.DOUBTFUL and len(part.repaired.boundary_vertices) > 0
    if inside_out or (part.one_sided and not is_sure_of_side(found)):
        turned = part.turned()
        other = match(template, turned.repaired, options, stages=stages)
        if other.scores["best"] > found.scores["best"]:
            found, part = other, turned
    show_notices(full, part)
    result = as_read(found, full, part)
    with stages("files"):
        errors = None
        if true_points is not None:
            measure = SurfaceDistances(full.original)
            errors = measure.between(true_points, result.point_map.points)
        document = write_match_report(
            result,
            output,
            command=command_line(),
            notices={"full": full.notices, "part": part.notices},
            errors=errors,
            check=found.check(),
            exports=exports,
        )
    return result, document


def match_summary(result: MatchResult, document: dict[str, Any], output: Path) -> str:
    """The answer in a few lines for the terminal."""
    lines = [
        f"The part is {100 * document['area_fraction']:.1f} % of the full shape; "
        f"{document['unmatched']} of {result.part.vertex_count} vertices unmatched, mean "
        f"confidence {document['mean_confidence']:.2f}."
    ]
    if result.options.scale == "unknown":
        lines.append(f"The part was enlarged {result.scale:.3f} times to fit.")
    lines += [
        f"Alternative: {other.name}, score {other.score:.3f}" for other in result.alternatives
    ]
    if result.status is MatchStatus.DOUBTFUL:
        lines.append(f"The result is {result.status.advice}.")
    if "ground_truth" in document:
        mean = document["ground_truth"]["mean_error_x100"]
        lines.append(f"Mean error against the ground truth: {mean:.2f} % of sqrt(area).")
    lines.append(f"Open {output / 'report.html'} to see it; numbers are in {output}.")
    return "\n".join(lines)


def _landmarks(
    path: Path | None, full: PreparedMesh, part: PreparedMesh
) -> tuple[tuple[int, int], ...]:
    if path is None:
        return ()
    on_part, on_full = read_landmarks(path)
    part_vertices = repaired_vertices(part, on_part, what=str(path))
    full_vertices = repaired_vertices(full, on_full, what=str(path))
    return tuple(zip(part_vertices.tolist(), full_vertices.tolist(), strict=True))


def _ignored(path: Path | None, part: PreparedMesh) -> tuple[int, ...]:
    if path is None:
        return ()
    vertices = read_ignored(path)
    # a vertex that repair left out is ignored anyway
    kept = vertices[part.report.new_vertices[np.clip(vertices, 0, None).astype(int)] >= 0]
    return tuple(repaired_vertices(part, kept, what=str(path)).tolist())


def _template(path: Path | None, full: PreparedMesh) -> Template | None:
    if path is None:
        return None
    if not path.exists():
        template = Template(full.repaired)
        template.save(path)
        return template
    template = Template.load(path)
    same = np.array_equal(template.full.faces, full.repaired.faces) and np.array_equal(
        template.full.vertices, full.repaired.vertices
    )
    if not same:
        raise InputError(
            f"{path}: was made for another mesh than {full.original.name}; name another file"
        )
    return template
