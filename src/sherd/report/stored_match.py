"""Read back what `sherd match` wrote, to carry values over without matching again."""

from __future__ import annotations

import csv
import json
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sherd.correspondence.point_map import PointMap
from sherd.errors import InputError, SherdError
from sherd.files.mesh_files import read_mesh
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.folder import folder_problems

__all__ = ["StoredMatch", "read_match"]


@dataclass(frozen=True, eq=False)
class StoredMatch:
    """What :mod:`sherd.transfer` needs of a match: both meshes, the map and the scale."""

    full: TriangleMesh
    part: TriangleMesh
    point_map: PointMap
    scale: float


def read_match(folder: str | os.PathLike[str]) -> StoredMatch:
    """Read the output folder of `sherd match`.

    Raises
    ------
    InputError
        If the folder is missing, holds no match, or mixes the files of two runs.
    """
    path = Path(folder)
    problems = folder_problems(path)
    if problems:
        raise InputError(problems[0])
    try:
        result = json.loads((path / "result.json").read_text(encoding="utf-8"))
        if result.get("format") != "sherd match 1":
            raise InputError(f"{path}: holds {result.get('format')!r}, not the result of a match")
        full, part = read_mesh(path / "full.ply"), read_mesh(path / "part.ply")
        with (path / "correspondence.csv").open(newline="", encoding="utf-8") as stream:
            rows = list(csv.DictReader(stream))
        weights = np.array([[float(row[f"b{k}"]) for k in range(3)] for row in rows])
        point_map = PointMap(
            np.array([int(row["full_face"]) for row in rows]),
            weights / weights.sum(axis=1, keepdims=True),
            np.array([row["matched"] == "1" for row in rows]),
            np.array([float(row["confidence"]) for row in rows]),
        )
    except SherdError:
        raise
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"{path}: cannot be read as the result of a match ({error})") from error
    return StoredMatch(full, part, point_map, float(result["scale"]))
