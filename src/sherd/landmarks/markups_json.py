"""Files of 3D Slicer, ``.mrk.json``: its markups, of which lists of points are read and written.

Version 1.0 of its schema (Slicer 4.11 and later). Points without a position are known by their
`positionStatus`.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sherd.arrays import Floats
from sherd.errors import InputError
from sherd.landmarks.landmark_list import Landmarks, Space

__all__ = ["markups_text", "read_markups"]

SCHEMA = (
    "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/"
    "Schema/markups-schema-v1.0.3.json#"
)
# The names of axes, and the numbers that older files have for them.
SPACE_NAMES: dict[str, Space] = {"LPS": "LPS", "RAS": "RAS", "0": "RAS", "1": "LPS"}
POINTS = "Fiducial"


def read_markups(path: Path) -> Landmarks:
    """The points of all point lists in a file, by label, or by number where there is no label.

    Raises
    ------
    InputError
        If the file cannot be read, is no markups file, holds curves or planes only, or an entry is
        damaged; the message names it.
    """
    try:
        document = json.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); check the path") from error
    except ValueError as error:
        raise InputError(f"{path}: is no JSON ({error}); save it anew from 3D Slicer") from error
    lists = document.get("markups") if isinstance(document, Mapping) else None
    if not isinstance(lists, list) or not all(isinstance(each, Mapping) for each in lists):
        raise InputError(f"{path}: has no list of markups, so it is no .mrk.json of 3D Slicer")
    point_lists = [each for each in lists if each.get("type") == POINTS]
    if not point_lists:
        found = ", ".join(sorted({str(each.get("type")) for each in lists})) or "nothing"
        raise InputError(f"{path}: holds {found}, but a point list (type {POINTS}) is needed")
    spaces = {_space(path, each) for each in point_lists}
    if len(spaces) > 1:
        raise InputError(f"{path}: its point lists differ in coordinateSystem; save them apart")
    names: list[str] = []
    positions: list[Floats] = []
    for each in point_lists:
        for point in each.get("controlPoints") or []:
            name = _name(path, point, len(names))
            names.append(name)
            positions.append(_position(path, point, name))
    return Landmarks(names, np.array(positions), space=spaces.pop(), source=str(path))


def markups_text(landmarks: Landmarks, notes: Sequence[str] | None = None) -> str:
    """The content of a ``.mrk.json`` file; `notes` (p,) become the points' descriptions."""
    said = [""] * len(landmarks) if notes is None else list(notes)
    points = []
    for number, (name, position, known) in enumerate(
        zip(landmarks.names, landmarks.positions.tolist(), landmarks.known.tolist(), strict=True)
    ):
        where = {"position": position} if known else {}  # nothing is made up where nothing is known
        points.append(
            {
                "id": str(number + 1),
                "label": name,
                "description": said[number],
                **where,
                "selected": True,
                "locked": False,
                "visibility": True,
                "positionStatus": "defined" if known else "undefined",
            }
        )
    markup = {
        "type": POINTS,
        "coordinateSystem": landmarks.space or "LPS",
        "locked": False,
        "labelFormat": "%N-%d",
        "controlPoints": points,
    }
    return json.dumps({"@schema": SCHEMA, "markups": [markup]}, indent=2, allow_nan=False) + "\n"


def _space(path: Path, markup: Mapping[str, Any]) -> Space:
    said = str(markup.get("coordinateSystem", "LPS"))  # the schema's default
    if said not in SPACE_NAMES:
        raise InputError(f"{path}: coordinateSystem is {said!r}, but LPS or RAS is read")
    return SPACE_NAMES[said]


def _name(path: Path, point: Any, number: int) -> str:
    if not isinstance(point, Mapping):
        raise InputError(f"{path}: control point {number + 1} is no object; save the file anew")
    return str(point.get("label") or point.get("id") or number + 1)


def _position(path: Path, point: Mapping[str, Any], name: str) -> Floats:
    if point.get("positionStatus", "defined") != "defined":
        return np.full(3, np.nan)
    try:
        position = np.array(point["position"], dtype=np.float64)
    except (KeyError, TypeError, ValueError):
        position = np.empty(0)
    if position.shape != (3,) or not np.isfinite(position).all():
        raise InputError(f"{path}: the position of landmark {name!r} is not three finite numbers")
    return position
