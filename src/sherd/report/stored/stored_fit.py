"""Read back what `sherd fit` wrote."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sherd.errors import InputError, SherdError
from sherd.files.mesh_files import read_mesh
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.known_layers import own_fields
from sherd.report.stored.folder import FIT_FORMAT, folder_problems
from sherd.results.fitted.fit_options import FitOptions
from sherd.results.fitted.fit_result import Fit, FitCheck, FittedPiece, HiddenRegion
from sherd.results.status import Status

__all__ = ["read_fit"]


def read_fit(folder: str | os.PathLike[str]) -> Fit:
    """Read the output folder of `sherd fit`: all that the result said, to the printed digits.

    Raises
    ------
    InputError
        If the folder is missing, holds no fit, or mixes the files of two runs.

    Examples
    --------
    >>> read_fit("nowhere")
    Traceback (most recent call last):
        ...
    sherd.errors.InputError: nowhere holds no result.json: nothing was finished there; run again
    """
    path = Path(folder)
    problems = folder_problems(path)
    if problems:
        raise InputError(problems[0])
    try:
        document = json.loads((path / "result.json").read_text(encoding="utf-8"))
        if document.get("format") != FIT_FORMAT:
            raise InputError(f"{path}: holds {document.get('format')!r}, not the result of a fit")
        return _fit(path, document)
    except SherdError:
        raise
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(f"{path}: cannot be read as the result of a fit ({error})") from error


def _fit(path: Path, document: Mapping[str, Any]) -> Fit:
    table = np.genfromtxt(path / "fit.csv", delimiter=",", names=True)
    return Fit(
        full=_shape(path / "full.ply", document["full"]),
        pieces=tuple(
            _piece(path / f"piece_{number}", facts)
            for number, facts in enumerate(document["pieces"])
        ),
        positions=np.column_stack([table[axis] for axis in "xyz"]),
        seen=table["seen"] > 0,
        chance=table["chance"],
        distances=table["distance"],
        strain=table["strain"],
        sizes=table["size"],
        check=FitCheck(**document["check"]),
        hidden=tuple(HiddenRegion(**region) for region in document["hidden"]),
        status=Status[document["status"].upper()],
        advice=document["advice"],
        timings=document["timings"],
        options=FitOptions(**document["options"]),
        version=document["version"],
        notices=tuple(document["full"]["notices"]),
    )


def _piece(path: Path, facts: Mapping[str, Any]) -> FittedPiece:
    table = np.genfromtxt(path / "distances.csv", delimiter=",", names=True)
    weights = np.column_stack([table[f"b{k}"] for k in range(3)])
    return FittedPiece(
        part=_shape(path / "part.ply", facts),
        points=SurfacePoints(
            table["face"].astype(np.int64), weights / weights.sum(axis=1, keepdims=True)
        ),
        matched=table["matched"] > 0,
        distances=table["distance"],
        scale=float(facts["scale"]),
    )


def _shape(path: Path, facts: Mapping[str, Any]) -> TriangleMesh:
    mesh = read_mesh(path)
    return TriangleMesh(
        mesh.vertices, mesh.faces, fields=own_fields(mesh.fields), name=str(facts["name"])
    )
