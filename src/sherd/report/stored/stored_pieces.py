"""The placed pieces of what `sherd assemble` wrote, each as the match that it is."""

from __future__ import annotations

import json
import os
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sherd.errors import InputError, SherdError
from sherd.files.mesh_files import read_mesh
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.known_layers import own_fields
from sherd.report.stored.folder import ASSEMBLY_FORMAT, MATCH_FORMAT, folder_problems
from sherd.report.stored.stored_match import read_match
from sherd.results.match_options import MatchOptions
from sherd.results.match_result import MatchResult
from sherd.results.placement import Placement
from sherd.results.status import Status

__all__ = ["read_matches"]


def read_matches(folder: str | os.PathLike[str]) -> tuple[MatchResult, ...]:
    """The match in a folder of `sherd match`, or those of the placed pieces of `sherd assemble`.

    Raises
    ------
    InputError
        If the folder is missing, holds neither, mixes two runs, or no piece has a place.
    """
    path = Path(folder)
    problems = folder_problems(path)
    if problems:
        raise InputError(problems[0])
    try:
        document = json.loads((path / "result.json").read_text(encoding="utf-8"))
        kind = document.get("format")
        if kind == MATCH_FORMAT:
            return (read_match(path),)
        if kind != ASSEMBLY_FORMAT:
            raise InputError(f"{path}: holds {kind!r}, not the result of match or assemble")
        found = _pieces(path, document)
    except SherdError:
        raise
    except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile) as error:
        raise InputError(f"{path}: cannot be read as a result ({error}); run again") from error
    if not found:
        raise InputError(f"{path}: no piece has a place there, so there is nothing to fit to")
    return found


def _pieces(path: Path, document: Mapping[str, Any]) -> tuple[MatchResult, ...]:
    full = _shape(path / "full.ply", document["full"])
    labels = np.genfromtxt(path / "labels.csv", delimiter=",", names=True)["piece"]
    return tuple(
        _match(path, full, labels == number, number, facts, str(document["version"]))
        for number, facts in enumerate(document["pieces"])
        if facts["placed"]
    )


def _match(
    path: Path, full: TriangleMesh, mask: Any, number: int, facts: Mapping[str, Any], version: str
) -> MatchResult:
    table = np.genfromtxt(
        path / f"piece_{number}" / "correspondence.csv", delimiter=",", names=True
    )
    weights = np.column_stack([table[f"b{k}"] for k in range(3)])
    faces = table["full_face"].astype(np.int64)
    return MatchResult(
        full=full,
        part=_shape(path / f"piece_{number}" / "part.ply", facts),
        best=Placement(
            mask=mask,
            membership=mask.astype(np.float64),
            score=float(facts["score"]),
            points=SurfacePoints(faces, weights / weights.sum(axis=1, keepdims=True)),
            matched=table["matched"] > 0,
            confidence=table["confidence"],
        ),
        alternatives=(),
        scale=1.0,  # pieces of a puzzle have the unit of the full shape
        second_score=None,
        twin_score=None,
        status=Status[str(facts["status"]).upper()],
        timings={},
        options=MatchOptions(),
        version=version,
        chance=facts["chance"],
    )


def _shape(path: Path, facts: Mapping[str, Any]) -> TriangleMesh:
    mesh = read_mesh(path)
    return TriangleMesh(
        mesh.vertices, mesh.faces, fields=own_fields(mesh.fields), name=str(facts["name"])
    )
