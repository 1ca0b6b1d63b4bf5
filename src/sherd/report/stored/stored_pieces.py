"""The placed pieces of what `sherd assemble` wrote, each as the match that it is."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sherd.errors import InputError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.stored.folder import ASSEMBLY_FORMAT, MATCH_FORMAT
from sherd.report.stored.reading import read_back, stored_points, stored_shape
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
    readers = {MATCH_FORMAT: lambda path, _: (read_match(path),), ASSEMBLY_FORMAT: _pieces}
    found = read_back(folder, readers, "match or assemble")
    if not found:
        raise InputError(f"{folder}: no piece has a place there, so there is nothing to fit to")
    return found


def _pieces(path: Path, document: Mapping[str, Any]) -> tuple[MatchResult, ...]:
    full = stored_shape(path / "full.ply", document["full"])
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
    return MatchResult(
        full=full,
        part=stored_shape(path / f"piece_{number}" / "part.ply", facts),
        best=Placement(
            mask=mask,
            membership=mask.astype(np.float64),
            score=float(facts["score"]),
            points=stored_points(table["full_face"], weights),
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
