"""Files of landmarks by the ends of their names: .mrk.json, .fcsv, or a table name,x,y,z."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from sherd.errors import InputError
from sherd.landmarks.fiducial_csv import fiducials_text, read_fiducials
from sherd.landmarks.landmark_list import Landmarks
from sherd.landmarks.markups_json import markups_text, read_markups
from sherd.output import write_text

__all__ = [
    "LANDMARK_ENDS",
    "is_landmark_file",
    "landmark_text",
    "read_landmarks",
    "write_landmarks",
]

COLUMNS = ["name", "x", "y", "z"]


def read_landmarks(path: str | os.PathLike[str]) -> Landmarks:
    """Landmarks of 3D Slicer (``.mrk.json``, ``.fcsv``) or of a table ``name,x,y,z`` (``.csv``).

    Coordinates are taken as they stand; see :meth:`Landmarks.in_space`.

    Raises
    ------
    InputError
        If the file cannot be read or is of another kind.
    """
    return _reader(Path(path))(Path(path))


def write_landmarks(
    landmarks: Landmarks, path: str | os.PathLike[str], *, notes: Sequence[str] | None = None
) -> None:
    """Write landmarks as the end of the name says, atomically; `notes` (p,) as descriptions.

    Where a position is unknown it is left undefined (``.mrk.json``), empty (``.csv``), or the
    point is left out (``.fcsv``).

    Raises
    ------
    InputError
        If the name ends otherwise.
    OutputError
        If the file cannot be written.
    """
    write_text(path, landmark_text(landmarks, Path(path), notes=notes))


def landmark_text(landmarks: Landmarks, path: Path, *, notes: Sequence[str] | None = None) -> str:
    """What :func:`write_landmarks` writes."""
    _reader(path)
    if _end(path) == ".mrk.json":
        return markups_text(landmarks, notes)
    if _end(path) == ".fcsv":
        return fiducials_text(landmarks, notes)
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(COLUMNS)
    for name, position in zip(landmarks.names, landmarks.positions.tolist(), strict=True):
        known = np.isfinite(position).all()
        writer.writerow([name, *(f"{value:.9g}" if known else "" for value in position)])
    return stream.getvalue()


def is_landmark_file(path: Path) -> bool:
    """Whether a name is that of a file of 3D Slicer; a ``.csv`` may hold anything."""
    return _end(path) in (".mrk.json", ".fcsv")


def _read_table(path: Path) -> Landmarks:
    try:
        with path.open(newline="", encoding="utf-8-sig") as stream:
            rows = [row for row in csv.reader(stream) if row]
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); check the path") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: is no CSV file ({error}); save it as UTF-8 text") from error
    header = [cell.strip() for cell in rows[0]] if rows else []
    if not set(COLUMNS) <= set(header):
        raise InputError(f"{path}: needs the columns {', '.join(COLUMNS)}")
    at = [header.index(name) for name in COLUMNS]
    names, positions = [], []
    for number, row in enumerate(rows[1:], start=2):
        try:
            name, *place = (row[k].strip() for k in at)
            numbers = [float(value) if value else np.nan for value in place]
        except (IndexError, ValueError) as error:
            raise InputError(f"{path}: row {number} has no name and three numbers") from error
        names.append(name)
        positions.append(numbers)
    return Landmarks(names, np.array(positions).reshape(-1, 3), source=str(path))


LANDMARK_ENDS: dict[str, Callable[[Path], Landmarks]] = {
    ".mrk.json": read_markups,
    ".fcsv": read_fiducials,
    ".csv": _read_table,
}


def _end(path: Path) -> str:
    name = path.name.lower()
    return next((end for end in LANDMARK_ENDS if name.endswith(end)), "")


def _reader(path: Path) -> Callable[[Path], Landmarks]:
    end = _end(path)
    if not end:
        raise InputError(
            f"{path}: is no file of landmarks by its name; known are {', '.join(LANDMARK_ENDS)}"
        )
    return LANDMARK_ENDS[end]
