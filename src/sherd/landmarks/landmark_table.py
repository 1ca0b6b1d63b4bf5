"""One table of the landmarks of many specimens, for geometric morphometrics."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable

import numpy as np

from sherd.arrays import Floats
from sherd.landmarks.carried import CarriedLandmarks

__all__ = ["LANDMARK_COLUMNS", "landmark_table"]

LANDMARK_COLUMNS = (
    "specimen", "landmark", "x", "y", "z", "confidence", "status", "spread", "templates",
)  # fmt: skip


def landmark_table(carried: Iterable[CarriedLandmarks]) -> str:
    """CSV, a row for each specimen and landmark; what is missing is empty.

    Columns: ``specimen``, ``landmark``, ``x``, ``y``, ``z`` in the coordinates of the specimen's
    file, ``confidence``, ``status`` (good, doubtful, missing, foreign), ``spread`` between
    templates in the unit of the specimen, empty with one, and the number of ``templates``. The rows
    of one specimen stand together, in the order of the landmarks, so the table is an array of shape
    (specimens, landmarks, 3) as it stands.

    Examples
    --------
    >>> print(landmark_table([]), end="")
    specimen,landmark,x,y,z,confidence,status,spread,templates
    """
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(LANDMARK_COLUMNS)
    for each in carried:
        for row, name in enumerate(each.landmarks.names):
            writer.writerow(
                [
                    each.specimen,
                    name,
                    *_cells(each.landmarks.positions[row]),
                    *_cells(each.confidence[[row]], digits=3),
                    each.status[row],
                    *_cells(each.spread[[row]]),
                    len(each.templates),
                ]
            )
    return stream.getvalue()


def _cells(values: Floats, *, digits: int = 9) -> list[str]:
    return [f"{value:.{digits}g}" if np.isfinite(value) else "" for value in values.tolist()]
