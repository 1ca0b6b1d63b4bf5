"""Tables of values by vertex, which `sherd transfer` carries; not every vertex needs a row."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sherd.arrays import Floats, Ints
from sherd.cli.tables import refuse_repeated, whole_numbers_of
from sherd.errors import InputError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.files import table_csv
from sherd.results.transfer import UNKNOWN_LABEL, Labels

__all__ = ["field_of", "labels_of", "rows_of_vertices", "text_table"]

# What spreadsheets and this program write for a value that is not known.
UNKNOWN = ("", "nan", "NaN")
Columns = dict[str, list[str]]


def rows_of_vertices(path: Path, columns: Columns, mesh: TriangleMesh) -> Ints:
    """(n,) row of each vertex of `mesh` in a table with a column ``vertex``, -1 if it has none.

    Raises
    ------
    InputError
        If a vertex is named twice, or does not exist.
    """
    named = whole_numbers_of(path, columns, "vertex")
    refuse_repeated(path, named.tolist(), "vertex")
    last = mesh.vertex_count - 1
    outside = named[(named < 0) | (named > last)]
    if len(outside):
        raise InputError(f"{path}: names vertex {outside[0]}, but {mesh.name} has 0..{last}")
    rows = np.full(mesh.vertex_count, -1)
    rows[named] = np.arange(len(named))
    return rows


def field_of(path: Path, columns: Columns, name: str, rows: Ints) -> Floats:
    """(n,) numbers of a column by vertex; NaN where the table says nothing.

    Raises
    ------
    InputError
        If an entry is neither a finite number nor unknown.
    """
    values = np.full(len(columns[name]) + 1, np.nan)  # the last stands for vertices without a row
    for row, text in enumerate(columns[name]):
        if text in UNKNOWN:
            continue
        number = _number(text)
        if number is None:
            raise InputError(
                f"{path}: row {row + 2} of column {name} is {text!r}, not a number; for text add "
                "--labels"
            )
        values[row] = number
    return values[rows]


def labels_of(path: Path, columns: Columns, name: str, rows: Ints) -> Labels:
    """(n,) labels of a column by vertex: whole numbers if all are, else text.

    Unknown are -1 and "", where the table says nothing.

    Raises
    ------
    InputError
        If all are numbers, but not whole ones.
    """
    texts = ["" if text in UNKNOWN else text for text in columns[name]]
    numbers = [UNKNOWN_LABEL if text == "" else _number(text) for text in texts]
    values = [number for number in numbers if number is not None]
    if len(values) < len(texts):
        return np.array([*texts, ""])[rows]
    broken = next((row for row, value in enumerate(values) if value != int(value)), None)
    if broken is not None:
        raise InputError(
            f"{path}: row {broken + 2} of column {name} is {texts[broken]!r}, no whole number; "
            "leave out --labels to carry numbers"
        )
    return np.array([*map(int, values), UNKNOWN_LABEL])[rows]


def text_table(columns: dict[str, NDArray[np.generic]]) -> str:
    """CSV with a header; numbers as in all tables of sherd, text quoted where needed."""
    cells = [
        values.tolist() if values.dtype.kind == "U" else table_csv({"x": values}).split()[1:]
        for values in columns.values()
    ]
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*cells, strict=True))
    return stream.getvalue()


def _number(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    return number if np.isfinite(number) else None
