"""An output folder of `sherd assemble` as something to look at again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from sherd.drawing.exhibit import Exhibit, Partner, Verdict
from sherd.files.mesh_files import read_mesh
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.puzzle.assembly_scene import AssemblyScene
from sherd.report.puzzle.joined_report import joined_exhibit, stored_partners
from sherd.report.puzzle.piece_row import ShownPiece
from sherd.report.stored.reading import stored_points
from sherd.results.status import Status

__all__ = ["assembly_exhibit", "joined_stored_exhibit"]


def assembly_exhibit(path: Path, document: Mapping[str, Any]) -> Exhibit:
    """The whole beside its pieces; `document` is the content of ``result.json``.

    Raises
    ------
    OSError, ValueError, KeyError, TypeError
        If a file is missing or damaged.
    """
    table = np.genfromtxt(path / "labels.csv", delimiter=",", names=True)
    scene = AssemblyScene(
        full=_shape(path / "full.ply", document["full"]),
        pieces=[_piece(path, number, facts) for number, facts in enumerate(document["pieces"])],
        labels=table["piece"].astype(np.int64),
        membership=table["membership"],
    )
    good = document["status"] == Status.GOOD.name.lower()
    return replace(
        scene.exhibit(),
        verdict=Verdict("Good" if good else "Doubtful", good),
        command=str(document.get("command", "")),
    )


def joined_stored_exhibit(path: Path, document: Mapping[str, Any]) -> Exhibit:
    """The pieces without a whole; `document` is the content of ``result.json``.

    Raises
    ------
    OSError, ValueError, KeyError, TypeError
        If a file is missing or damaged.
    """
    pieces, partners = [], []
    for number, facts in enumerate(document["pieces"]):
        folder = path / f"piece_{number}"
        pieces.append(_shape(folder / "part.ply", facts))
        rows = np.genfromtxt(folder / "partners.csv", delimiter=",", names=True, ndmin=1)
        partners.append(stored_partners({name: rows[name] for name in rows.dtype.names or ()}))
    groups = [[int(k) for k in group] for group in document["groups"]]
    good = document["status"] == Status.GOOD.name.lower()
    return replace(
        joined_exhibit(pieces, groups, partners),
        verdict=Verdict("Good" if good else "Doubtful", good),
        command=str(document.get("command", "")),
    )


def _piece(path: Path, number: int, facts: Mapping[str, Any]) -> ShownPiece:
    mesh = _shape(path / f"piece_{number}" / "part.ply", facts)
    if not facts["placed"]:
        return ShownPiece(mesh, None)
    own = path / f"piece_{number}" / "correspondence.csv"
    table = np.genfromtxt(own, delimiter=",", names=True)
    weights = np.column_stack([table[f"b{k}"] for k in range(3)])
    points = stored_points(table["full_face"], weights)
    return ShownPiece(mesh, Partner(points, table["matched"] > 0, table["confidence"]))


def _shape(path: Path, facts: Mapping[str, Any]) -> TriangleMesh:
    mesh = read_mesh(path)
    return TriangleMesh(mesh.vertices, mesh.faces, name=str(facts["name"]))
