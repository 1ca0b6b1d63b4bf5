"""Sheets that say nothing of their own: what single faces sewn to a surface become by repair."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sherd.arrays import Bools, frozen
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.mesh.words import spelled
from sherd.repair.repair import RepairReport, RepairStep

__all__ = ["without_repeated_sheets"]

_SENTENCE = "left out {face} of sheets that lie on larger ones with every vertex"


def without_repeated_sheets(
    mesh: TriangleMesh, report: RepairReport
) -> tuple[TriangleMesh, RepairReport]:
    """The repaired mesh without sheets all of whose vertices were doubled from larger ones.

    Whiskers and the single faces that a scanner sews from skin to skin have edges with three faces.
    Repair separates them; each would be a component that must be placed, though its vertices have
    an answer on the sheet that it was sewn to.

    Parameters
    ----------
    mesh, report
        As :func:`sherd.repair.repair.repair` returns them.

    Returns
    -------
    mesh, report
        The same objects if there is no such sheet; else the report has one step more.
    """
    repeated = _repeated(mesh, report)
    if not repeated.any():
        return mesh, report
    gone = repeated[mesh.faces].any(axis=1)
    kept_mesh, kept = mesh.submesh(~gone)
    renumber = np.full(mesh.vertex_count, -1, dtype=np.int64)
    renumber[kept] = np.arange(len(kept))
    known = report.new_vertices >= 0
    new = np.where(known, renumber[np.where(known, report.new_vertices, 0)], -1)
    step = RepairStep(
        "drop repeated sheets",
        int(gone.sum()),
        float(mesh.face_areas[gone].sum() / mesh.area),
        spelled(_SENTENCE, int(gone.sum())),
    )
    return kept_mesh, replace(
        report,
        steps=(*report.steps, step),
        original_vertices=frozen(report.original_vertices[kept]),
        new_vertices=frozen(new),
    )


def _repeated(mesh: TriangleMesh, report: RepairReport) -> Bools:
    """The vertices (n,) of those sheets."""
    original = report.original_vertices
    if len(np.unique(original)) == len(original):  # no vertex was doubled
        return np.zeros(mesh.vertex_count, dtype=bool)
    labels = mesh.component_labels
    areas = np.bincount(labels, mesh.vertex_areas)
    largest = np.zeros(len(report.new_vertices))
    np.maximum.at(largest, original, areas[labels])
    own = np.bincount(labels, areas[labels] >= largest[original]) > 0
    repeated: Bools = ~own[labels]
    return repeated
