"""Read back what `sherd match` wrote: the same result, without matching again."""

from __future__ import annotations

import csv
import io
import os
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from sherd.mesh.surface_points import SurfacePoints
from sherd.report.stored.folder import MATCH_FORMAT
from sherd.report.stored.reading import read_back, stored_points, stored_shape
from sherd.results.advice import UnfollowedLandmark
from sherd.results.match_options import MatchOptions
from sherd.results.match_result import MatchResult
from sherd.results.placement import Placement
from sherd.results.status import Status

__all__ = ["read_match", "stored_alternatives"]


def stored_alternatives(alternatives: tuple[Placement, ...]) -> bytes:
    """An ``.npz`` file: of each ``faces_K``, ``barycentric_K``, ``mask_K``, ``membership_K``."""
    arrays: dict[str, Any] = {}
    for k, other in enumerate(alternatives):
        arrays[f"mask_{k}"], arrays[f"membership_{k}"] = other.mask, other.membership
        if other.points is not None:
            arrays[f"faces_{k}"] = other.points.faces
            arrays[f"barycentric_{k}"] = other.points.barycentric
    stream = io.BytesIO()
    np.savez_compressed(stream, **arrays)
    return stream.getvalue()


def read_match(folder: str | os.PathLike[str]) -> MatchResult:
    """Read the output folder of `sherd match`: all that the result said, to the printed digits.

    Raises
    ------
    InputError
        If the folder is missing, holds no match, or mixes the files of two runs.

    Examples
    --------
    >>> read_match("nowhere")
    Traceback (most recent call last):
        ...
    sherd.errors.InputError: nowhere holds no result.json: nothing was finished there; run again
    """
    return read_back(folder, {MATCH_FORMAT: _result}, "a match")


def _result(path: Path, document: dict[str, Any]) -> MatchResult:
    scores = document["scores"]
    notices = {which: tuple(document[which]["notices"]) for which in ("full", "part")}
    return MatchResult(
        full=stored_shape(path / "full.ply", document["full"]),
        part=stored_shape(path / "part.ply", document["part"]),
        best=_best(path, float(scores["best"])),
        alternatives=_alternatives(path, document["alternatives"]),
        scale=float(document["scale"]),
        second_score=scores.get("other"),
        twin_score=scores.get("mirrored twin"),
        status=Status[document["status"].upper()],
        timings=MappingProxyType(document["timings"]),
        options=_options(document["options"]),
        version=document["version"],
        working_vertices=MappingProxyType(document["working_vertices"]),
        notices=MappingProxyType(notices),
        advice=document["advice"],
        unfollowed_landmarks=tuple(
            UnfollowedLandmark(**{**each, "contradicts": tuple(each["contradicts"])})
            for each in document.get("unfollowed_landmarks", ())
        ),
        min_confidence=float(document.get("min_confidence", 0.0)),
        chance=document.get("chance"),
    )


def _best(path: Path, score: float) -> Placement:
    answers, region = _rows(path / "correspondence.csv"), _rows(path / "region.csv")
    weights = np.array([[float(row[f"b{k}"]) for k in range(3)] for row in answers])
    faces = np.array([int(row["full_face"]) for row in answers])
    return Placement(
        mask=np.array([row["in_region"] == "1" for row in region]),
        membership=np.array([float(row["membership"]) for row in region]),
        score=score,
        points=stored_points(faces, weights),
        matched=np.array([row["matched"] == "1" for row in answers]),
        confidence=np.array([float(row["confidence"]) for row in answers]),
    )


def _alternatives(path: Path, facts: list[dict[str, Any]]) -> tuple[Placement, ...]:
    if not facts:
        return ()
    with np.load(path / "alternatives.npz", allow_pickle=False) as stored:
        return tuple(
            Placement(
                mask=stored[f"mask_{k}"],
                membership=stored[f"membership_{k}"],
                score=float(fact["score"]),
                mirrored=bool(fact["mirrored"]),
                points=SurfacePoints(stored[f"faces_{k}"], stored[f"barycentric_{k}"]),
            )
            for k, fact in enumerate(facts)
        )


def _options(stored: dict[str, Any]) -> MatchOptions:
    pairs = tuple((int(part), int(full)) for part, full in stored["landmarks"])
    return MatchOptions(**{**stored, "landmarks": pairs, "ignore": tuple(stored["ignore"])})


def _rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))
