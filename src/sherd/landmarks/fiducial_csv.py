"""Files of older versions of 3D Slicer, ``.fcsv``: a table of points under a commented header."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from sherd.errors import InputError
from sherd.landmarks.landmark_list import Landmarks, Space
from sherd.landmarks.markups_json import SPACE_NAMES

__all__ = ["fiducials_text", "read_fiducials"]

COLUMNS = (
    "id", "x", "y", "z", "ow", "ox", "oy", "oz", "vis", "sel", "lock", "label", "desc",
    "associatedNodeID",
)  # fmt: skip


def read_fiducials(path: Path) -> Landmarks:
    """The points of a ``.fcsv`` file, by label, or by id where there is no label.

    Without a header the columns are those of Slicer, and the axes RAS, as its first versions wrote.

    Raises
    ------
    InputError
        If the file cannot be read, or a row or the coordinate system is none that is known.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); check the path") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is no text ({error}); save it anew from 3D Slicer") from error
    header = dict(_header_entry(line) for line in lines if line.startswith("#"))
    columns = tuple(header.get("columns", ",".join(COLUMNS)).replace(" ", "").split(","))
    if not {"x", "y", "z"} <= set(columns):
        raise InputError(f"{path}: its columns are {', '.join(columns)}, without x, y and z")
    rows = [(k + 1, line) for k, line in enumerate(lines) if line.strip() and line[0] != "#"]
    names: list[str] = []
    positions: list[list[float]] = []
    for number, line in rows:
        cells = dict(zip(columns, next(csv.reader([line])), strict=False))
        names.append((cells.get("label") or cells.get("id") or str(len(names) + 1)).strip())
        try:
            position = [float(cells[axis]) for axis in "xyz"]
        except (KeyError, ValueError) as error:
            raise InputError(f"{path}: line {number} has no numbers x, y and z") from error
        positions.append(position)
    space = _space(path, header.get("CoordinateSystem", "RAS"))
    return Landmarks(names, np.array(positions), space=space, source=str(path))


def fiducials_text(landmarks: Landmarks, notes: Sequence[str] | None = None) -> str:
    """The content of a ``.fcsv`` file, which has no way to say that a position is unknown.

    Points without one are left out; `notes` (p,) become descriptions.
    """
    said = [""] * len(landmarks) if notes is None else list(notes)
    stream = io.StringIO()
    stream.write("# Markups fiducial file version = 4.11\n")
    stream.write(f"# CoordinateSystem = {landmarks.space or 'LPS'}\n")
    stream.write(f"# columns = {','.join(COLUMNS)}\n")
    writer = csv.writer(stream, lineterminator="\n")
    for number in np.flatnonzero(landmarks.known).tolist():
        place = [repr(float(value)) for value in landmarks.positions[number]]
        orientation = ("0", "0", "0", "1")
        name = landmarks.names[number]
        writer.writerow([number + 1, *place, *orientation, "1", "1", "0", name, said[number], ""])
    return stream.getvalue()


def _header_entry(line: str) -> tuple[str, str]:
    name, _, value = line.lstrip("# ").partition("=")
    return name.strip(), value.strip()


def _space(path: Path, said: str) -> Space:
    if said not in SPACE_NAMES:
        raise InputError(f"{path}: CoordinateSystem is {said!r}, but LPS or RAS is read")
    return SPACE_NAMES[said]
