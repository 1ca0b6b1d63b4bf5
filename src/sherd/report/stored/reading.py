"""What all results have in common that are read back from their folders."""

from __future__ import annotations

import json
import os
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from sherd.arrays import Floats
from sherd.errors import InputError, SherdError
from sherd.files.mesh_files import read_mesh
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.known_layers import own_fields
from sherd.report.stored.folder import folder_problems
from sherd.result_folder import RESULT

__all__ = ["read_back", "stored_points", "stored_shape"]

Result = TypeVar("Result")


def read_back(
    folder: str | os.PathLike[str],
    readers: Mapping[str, Callable[[Path, dict[str, Any]], Result]],
    kind: str,
) -> Result:
    """The result in a folder, by the reader of its format.

    Parameters
    ----------
    folder
        Of a command.
    readers
        By format of ``result.json``: called with the folder and the content of that file.
    kind
        What is wanted, in words: "a match".

    Raises
    ------
    InputError
        If the folder is missing, holds something else, cannot be read, or mixes two runs.
    """
    path = Path(folder)
    problems = folder_problems(path)
    if problems:
        raise InputError(problems[0])
    try:
        document = json.loads((path / RESULT).read_text(encoding="utf-8"))
        found = document.get("format")
        if found not in readers:
            raise InputError(f"{path}: holds {found!r}, not the result of {kind}")
        return readers[found](path, document)
    except SherdError:
        raise
    except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile) as error:
        raise InputError(f"{path}: cannot be read as the result of {kind} ({error})") from error


def stored_shape(path: Path, facts: Mapping[str, Any]) -> TriangleMesh:
    """The mesh as it was given: what the result has painted on it is taken off."""
    mesh = read_mesh(path)
    return TriangleMesh(
        mesh.vertices, mesh.faces, fields=own_fields(mesh.fields), name=str(facts["name"])
    )


def stored_points(faces: Floats, weights: Floats) -> SurfacePoints:
    """Points of printed faces (n,) and weights (n, 3), which add up to 1 again."""
    return SurfacePoints(faces.astype(np.int64), weights / weights.sum(axis=1, keepdims=True))
