"""`sherd transfer`."""

from __future__ import annotations

from pathlib import Path
from typing import TypeAlias

import click
import numpy as np
from numpy.typing import NDArray

from sherd.arrays import Floats
from sherd.cli.many.landmarking import (
    fitted_landmarks,
    mesh_space_option,
    transferred_landmarks,
)
from sherd.cli.options import quiet_option
from sherd.cli.tables import columns_of, refuse_repeated, whole_numbers_of
from sherd.cli.vertex_tables import field_of, labels_of, rows_of_vertices, text_table
from sherd.errors import InputError
from sherd.files.mesh_files import read_mesh, write_mesh
from sherd.landmarks.landmark_files import is_landmark_file
from sherd.landmarks.landmark_list import Space
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import require_writable, write_text
from sherd.report.stored.folder import FIT_FORMAT, result_format
from sherd.report.stored.stored_fit import read_fit
from sherd.report.stored.stored_match import read_match
from sherd.results.fitted.fit_result import Fit, PieceMap
from sherd.results.match_result import MatchResult

__all__ = ["transfer_command"]

FILE = click.Path(path_type=Path)

Mapped: TypeAlias = MatchResult | PieceMap


@click.command("transfer")
@click.argument("folder", type=FILE)
@click.argument("values", type=FILE)
@click.option(
    "-o", "--output", type=FILE, required=True, help="CSV, PLY or landmark file to write."
)
@click.option(
    "--to",
    type=click.Choice(["part", "full"]),
    default="part",
    show_default=True,
    help="Which shape gets the values; they come from the other.",
)
@click.option("--labels", is_flag=True, help="Values are labels: never interpolate.")
@click.option(
    "--min-confidence",
    type=float,
    default=0.0,
    show_default=True,
    help="Below it a vertex counts as unmatched; 0 to 1.",
)
@mesh_space_option
@click.option(
    "--piece",
    type=int,
    default=0,
    show_default=True,
    help="Which part of a fit to several, from 0.",
)
@quiet_option()
def transfer_command(  # noqa: PLR0913 - one for each word that can be typed
    folder: Path,
    values: Path,
    output: Path,
    *,
    to: str,
    labels: bool,
    min_confidence: float,
    mesh_space: Space | None,
    piece: int,
    quiet: bool,
) -> int:
    """Carry VALUES from one shape to the other along the match, or the fit, in FOLDER.

    VALUES is a mesh with vertex fields or colors (written as .ply), a CSV with a column `vertex`
    and columns of numbers, or with --labels of text, a CSV with the columns `name,vertex` of
    landmarks, or landmarks of 3D Slicer (.mrk.json, .fcsv), written as such or as a table. Vertices
    that are not named, and what has no partner, are unknown: nan, for labels -1 or empty.

    Of a fit, landmarks of the full shape get places where nothing was seen, too, and are marked as
    extrapolated; their places are those of the fit, in the coordinates of the part.

    \b
    Examples:
      sherd transfer out/ template-painted.ply -o scan-painted.ply
      sherd transfer out/ muscles.csv -o scan-muscles.csv --labels
      sherd transfer out/ landmarks.csv -o scan-landmarks.csv
      sherd transfer out/ template.mrk.json -o scan.mrk.json
    """  # noqa: D301
    require_writable(output)
    fitted = read_fit(folder) if result_format(folder) == FIT_FORMAT else None
    if mesh_space is not None and not is_landmark_file(values):
        raise click.UsageError("--mesh-space is for landmarks of 3D Slicer")
    if is_landmark_file(values):
        map_from = fitted or read_match(folder).with_min_confidence(min_confidence)
        write_text(output, _slicer_landmarks(map_from, values, output, to, mesh_space))
        return _written(output, quiet=quiet)
    if fitted is None:
        stored: Mapped = read_match(folder).with_min_confidence(min_confidence)
    else:
        stored = _map_of_fit(fitted, piece, min_confidence)
    if values.suffix.lower() == ".csv":
        columns = columns_of(values)
        if set(columns) == {"name", "vertex"} and fitted is not None and to == "part":
            write_text(output, _fitted_landmarks(fitted, values, columns))
        elif set(columns) == {"name", "vertex"}:
            write_text(output, _landmarks(stored, values, columns, to))
        else:
            write_text(output, _table(stored, values, columns, to=to, labels=labels))
    else:
        _mesh(stored, values, output, to=to, labels=labels)
    return _written(output, quiet=quiet)


def _written(output: Path, *, quiet: bool) -> int:
    if not quiet:
        click.echo(f"written: {output}")
    return 0


def _slicer_landmarks(
    stored: MatchResult | Fit, values: Path, output: Path, to: str, mesh_space: Space | None
) -> str:
    if isinstance(stored, MatchResult):
        return transferred_landmarks(stored, values, output, to=to, mesh_space=mesh_space)
    if to == "full":
        raise click.UsageError("landmarks go to the full shape along a match, not along a fit")
    return fitted_landmarks(stored, values, output, mesh_space=mesh_space)


def _map_of_fit(fitted: Fit, piece: int, min_confidence: float) -> PieceMap:
    if min_confidence > 0:
        raise click.UsageError("a fit has chances, no confidence: --min-confidence is of a match")
    if not 0 <= piece < len(fitted.pieces):
        raise click.UsageError(f"--piece is {piece}, but the fit has 0..{len(fitted.pieces) - 1}")
    return fitted.piece_map(piece)


def _fitted_landmarks(fitted: Fit, path: Path, columns: dict[str, list[str]]) -> str:
    """Name, vertex, place in the coordinates of the part, and whether nothing was seen there."""
    vertices = whole_numbers_of(path, columns, "vertex")
    refuse_repeated(path, columns["name"], "name")
    positions, extrapolated, chance = fitted.landmarks(vertices)
    table = {
        "name": np.array(columns["name"]),
        "vertex": vertices,
        **{axis: positions[:, k] for k, axis in enumerate("xyz")},
        "extrapolated": extrapolated.astype(np.int64),
        "chance": chance,
    }
    return text_table(table)


def _carried(
    stored: Mapped, array: NDArray[np.generic], *, to: str, labels: bool
) -> NDArray[np.generic]:
    if labels:
        return stored.labels_to_part(array) if to == "part" else stored.labels_to_full(array)
    return stored.field_to_part(array) if to == "part" else stored.field_to_full(array)


def _table(
    stored: Mapped, path: Path, columns: dict[str, list[str]], *, to: str, labels: bool
) -> str:
    source, target = (stored.full, stored.part) if to == "part" else (stored.part, stored.full)
    rows = rows_of_vertices(path, columns, source)
    values = labels_of if labels else field_of
    carried: dict[str, NDArray[np.generic]] = {"vertex": np.arange(target.vertex_count)}
    for name in columns:
        if name != "vertex":
            array = values(path, columns, name, rows)
            carried[name] = _carried(stored, array, to=to, labels=labels)
    return text_table(carried)


def _landmarks(stored: Mapped, path: Path, columns: dict[str, list[str]], to: str) -> str:
    vertices = whole_numbers_of(path, columns, "vertex")
    refuse_repeated(path, columns["name"], "name")
    target = stored.part if to == "part" else stored.full
    if to == "part":
        points, misses = stored.landmarks_to_part(vertices)
    else:
        points, misses = stored.landmarks_to_full(vertices), None
    return _landmark_text(columns["name"], target, points, misses)


def _landmark_text(
    names: list[str],
    mesh: TriangleMesh,
    points: SurfacePoints,
    misses: Floats | None,
) -> str:
    positions = points.positions(mesh)
    table = {
        "vertex": points.nearest_vertices(mesh),
        "face": points.faces,
        **{f"b{k}": points.barycentric[:, k] for k in range(3)},
        **{axis: positions[:, k] for k, axis in enumerate("xyz")},
    }
    if misses is not None:
        table["miss"] = misses
    return text_table({"name": np.array(names), **table})


def _mesh(stored: Mapped, path: Path, output: Path, *, to: str, labels: bool) -> None:
    painted = read_mesh(path)
    source, target = (stored.full, stored.part) if to == "part" else (stored.part, stored.full)
    if painted.vertex_count != source.vertex_count:
        raise InputError(
            f"{path}: has {painted.vertex_count} vertices, but {source.name} {source.vertex_count}"
        )
    if not painted.fields:
        raise InputError(f"{path}: has no vertex fields or colors to carry; use a .ply file")
    fields: dict[str, NDArray[np.generic]] = {}
    for name, values in painted.fields.items():
        if name == "color":
            # gray where there is no partner
            fields[name] = np.nan_to_num(
                stored.field_to_part(values) if to == "part" else stored.field_to_full(values),
                nan=0.6,
            )
        else:
            fields[name] = _carried(stored, values, to=to, labels=labels)
    write_mesh(
        target,
        output,
        fields={k: v for k, v in fields.items() if k != "color"},
        colors=fields.get("color"),
    )
