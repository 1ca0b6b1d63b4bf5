"""An output folder of any of the questions as something to look at again."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from sherd.arrays import Bools
from sherd.drawing.colors import correspondence_layer
from sherd.drawing.exhibit import Exhibit, Partner, SharedCurve, Verdict
from sherd.energy.convergence import Convergence
from sherd.errors import InputError, SherdError
from sherd.files.mesh_files import read_mesh
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.fitted.fit_report import fitted_exhibit
from sherd.report.known_layers import file_layers, located_part_layers, stored_layers
from sherd.report.stored.folder import (
    ASSEMBLY_FORMAT,
    FIT_FORMAT,
    JOINED_FORMAT,
    MATCH_FORMAT,
    OVERLAP_FORMAT,
    REGION_FORMAT,
    folder_problems,
)
from sherd.report.stored.stored_assembly import assembly_exhibit, joined_stored_exhibit
from sherd.report.stored.stored_fit import read_fit
from sherd.report.stored.stored_match import read_match
from sherd.results.status import Status

__all__ = ["read_exhibit"]

CONVERGED = Convergence.CONVERGED.name.lower()


def read_exhibit(folder: str | os.PathLike[str]) -> Exhibit:
    """Both shapes with their layers and, for a match, the map; without the alternatives.

    Raises
    ------
    InputError
        If the folder is missing, mixes two runs, or holds no result.
    """
    path = Path(folder)
    problems = folder_problems(path)
    if problems:
        raise InputError(problems[0])
    try:
        document = json.loads((path / "result.json").read_text(encoding="utf-8"))
        kind = document.get("format")
        if kind == MATCH_FORMAT:
            return _match_exhibit(path, document)
        if kind == REGION_FORMAT:
            return _region_exhibit(path, document)
        if kind == OVERLAP_FORMAT:
            return _overlap_exhibit(path, document)
        if kind == ASSEMBLY_FORMAT:
            return assembly_exhibit(path, document)
        if kind == FIT_FORMAT:
            return fitted_exhibit(read_fit(path), document)
        if kind == JOINED_FORMAT:
            return joined_stored_exhibit(path, document)
    except SherdError:
        raise
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(f"{path}: cannot be read as a result ({error}); run again") from error
    raise InputError(
        f"{path}: holds {kind!r}, no result of match, locate, overlap, assemble or fit"
    )


def _match_exhibit(path: Path, document: Mapping[str, Any]) -> Exhibit:
    stored = read_match(path)
    on_full, on_part = read_mesh(path / "full.ply"), read_mesh(path / "part.ply")
    full, part = _named(on_full, document["full"]), _named(on_part, document["part"])
    return Exhibit(
        title=f"{part.name} on {full.name}",
        full=full,
        part=part,
        full_layers=(
            correspondence_layer(full),
            *stored_layers(on_full.fields, carried=True),
        ),
        part_layers=stored_layers(on_part.fields),
        partner=Partner(stored.points, stored.matched, stored.confidence),
        verdict=Verdict.from_advice(stored.status.advice, trusted=stored.status is Status.GOOD),
        command=str(document.get("command", "")),
        landmarks=stored.options.landmarks,
        takes_hints=True,
        ignored=tuple(stored.options.ignore),
        region=stored.best.mask,
    )


def _overlap_exhibit(path: Path, document: Mapping[str, Any]) -> Exhibit:
    on_first, on_second = read_mesh(path / "first.ply"), read_mesh(path / "second.ply")
    first = _named(on_first, document["first"])
    second = _named(on_second, document["second"])
    table = np.genfromtxt(path / "correspondence.csv", delimiter=",", names=True)
    weights = np.column_stack([table[f"b{k}"] for k in range(3)])
    points = SurfacePoints(table["first_face"].astype(np.int64), weights)
    inside = np.genfromtxt(path / "first_region.csv", delimiter=",", names=True)["in_region"] > 0
    curve = document["strain_curve"]
    return Exhibit(
        title=f"{first.name} and {second.name}",
        full=first,
        part=second,
        full_layers=(correspondence_layer(first), *stored_layers(on_first.fields, carried=True)),
        part_layers=stored_layers(on_second.fields),
        partner=Partner(points, table["matched"] > 0, table["confidence"]),
        verdict=Verdict.from_advice(
            str(document["advice"]), trusted=document["status"] == Status.GOOD.name.lower()
        ),
        command=str(document.get("command", "")),
        region=inside if inside.any() else np.ones(len(inside), dtype=bool),
        names=("First shape", "Second shape"),
        curve=SharedCurve(
            tuple(curve["strains"]),
            tuple(curve["first"]),
            tuple(curve["second"]),
            float(document["options"]["strain"]),
        ),
    )


def _region_exhibit(path: Path, document: Mapping[str, Any]) -> Exhibit:
    located = read_mesh(path / "region.ply")
    try:
        piece = read_mesh(path / "part.ply")
    except InputError as error:
        raise InputError(
            f"{path}: was written before part.ply belonged to a result; run again"
        ) from error
    full, part = _named(located, document["full"]), _named(piece, document["part"])
    return Exhibit(
        title=f"{part.name} on {full.name}",
        full=full,
        part=part,
        full_layers=stored_layers(located.fields),
        part_layers=(*located_part_layers(part), *file_layers(piece.fields)),
        verdict=Verdict.from_advice(
            str(document["advice"]), trusted=document["status"] == CONVERGED
        ),
        region=_mask(located),
    )


def _named(mesh: TriangleMesh, facts: Mapping[str, Any]) -> TriangleMesh:
    """Without the fields, which are layers now, and with the name of the user's file."""
    return TriangleMesh(mesh.vertices, mesh.faces, name=str(facts["name"]))


def _mask(mesh: TriangleMesh) -> Bools:
    return np.asarray(mesh.fields["region"] > 0.5)
