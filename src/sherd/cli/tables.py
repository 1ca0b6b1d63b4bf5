"""Small files that users write: landmarks, vertices to ignore, ground truth, values to carry."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.errors import InputError
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = [
    "columns_of",
    "numbers_of",
    "read_ground_truth",
    "read_ignored",
    "read_landmarks",
    "refuse_repeated",
    "whole_numbers_of",
]

LARGEST_WHOLE = 2.0**53  # beyond it float64 skips whole numbers


def columns_of(path: Path) -> dict[str, list[str]]:
    """A CSV file with a header as lists of strings by column name.

    Raises
    ------
    InputError
        If the file cannot be read, has no header, two columns of one name or a row of another
        length.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as stream:
            rows = [row for row in csv.reader(stream) if row]
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); check the path") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: is no CSV file ({error}); save it as UTF-8 text") from error
    if not rows:
        raise InputError(f"{path}: is empty; a header and rows of values are needed")
    header = [name.strip() for name in rows[0]]
    refuse_repeated(path, header, "column")
    for number, row in enumerate(rows[1:], start=2):
        if len(row) != len(header):
            raise InputError(
                f"{path}: row {number} has {len(row)} values, but the header names {len(header)}"
            )
    return {name: [row[k].strip() for row in rows[1:]] for k, name in enumerate(header)}


def read_landmarks(
    path: Path, *, names: tuple[str, str] = ("part_vertex", "full_vertex")
) -> tuple[Ints, Ints]:
    """Vertices of both shapes from two columns of a CSV file."""
    columns = columns_of(path)
    return whole_numbers_of(path, columns, names[0]), whole_numbers_of(path, columns, names[1])


def read_ignored(path: Path, *, column: str = "part_vertex") -> Ints:
    """Vertices from a column of a CSV file."""
    return whole_numbers_of(path, columns_of(path), column)


def read_ground_truth(path: Path, full: TriangleMesh, part: TriangleMesh) -> SurfacePoints:
    """True points on the full shape, a row per vertex of the part.

    Either CSV with the columns ``full_face,b0,b1,b2`` (faces from 0, as `sherd match` writes) or
    four numbers a row separated by blanks, faces from 1, as in SHREC'16 (``.baryc_gt``).

    Raises
    ------
    InputError
        If the file cannot be read or does not fit the meshes.
    """
    if path.suffix.lower() == ".csv":
        columns = columns_of(path)
        faces = whole_numbers_of(path, columns, "full_face")
        weights = np.column_stack([numbers_of(path, columns, name) for name in ("b0", "b1", "b2")])
    else:
        try:
            table = np.loadtxt(path, ndmin=2)
        except (OSError, ValueError) as error:
            raise InputError(f"{path}: cannot be read as a table of numbers ({error})") from error
        if table.shape[1] != 4:
            raise InputError(f"{path}: has {table.shape[1]} columns, but a face and three weights")
        if not (np.abs(table) < LARGEST_WHOLE).all():
            raise InputError(f"{path}: holds a number that is not finite or far too large")
        faces, weights = table[:, 0].astype(np.int64) - 1, table[:, 1:]
    if len(faces) != part.vertex_count:
        raise InputError(f"{path}: has {len(faces)} rows, but {part.name} {part.vertex_count}")
    if not 0 <= faces.min() <= faces.max() < full.face_count:
        raise InputError(f"{path}: names a face that {full.name} does not have")
    weights = np.clip(weights, 0.0, 1.0)
    total = weights.sum(axis=1, keepdims=True)
    if not (total > 0).all():
        raise InputError(f"{path}: row {int(np.argmin(total)) + 1} has no positive weight")
    return SurfacePoints(faces, weights / total)


def whole_numbers_of(path: Path, columns: dict[str, list[str]], name: str) -> Ints:
    """One column as whole numbers.

    Raises
    ------
    InputError
        If the column is missing or an entry is no whole number.
    """
    values = numbers_of(path, columns, name)
    whole = np.where(np.abs(values) < LARGEST_WHOLE, values, -1).astype(np.int64)
    if not np.array_equal(whole, values):
        row = int(np.argmax(whole != values)) + 2
        raise InputError(f"{path}: row {row} of column {name} is no whole number")
    return whole


def refuse_repeated(path: Path, names: Sequence[object], what: str) -> None:
    """Refuse names that stand twice in a file.

    Raises
    ------
    InputError
        With the first of them.
    """
    seen = set()
    for name in names:
        if name in seen:
            raise InputError(f"{path}: {what} {name!r} is there twice; keep one")
        seen.add(name)


def numbers_of(path: Path, columns: dict[str, list[str]], name: str) -> Floats:
    """One column as finite numbers.

    Raises
    ------
    InputError
        If the column is missing or an entry is no finite number.
    """
    if name not in columns:
        raise InputError(f"{path}: has no column {name!r}; it has {', '.join(columns)}")
    values = np.empty(len(columns[name]))
    for row, text in enumerate(columns[name]):
        try:
            values[row] = float(text)
        except ValueError:
            raise InputError(
                f"{path}: row {row + 2} of column {name} is {text!r}, not a number"
            ) from None
    if not np.isfinite(values).all():
        raise InputError(f"{path}: column {name} holds a number that is not finite")
    return values
