"""Sheets that say nothing of their own: what single faces sewn to a surface become by repair."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sherd.arrays import Bools, frozen
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.mesh.words import spelled
from sherd.repair.repair import RepairReport, RepairStep

__all__ = ["without_crumbs"]

_SENTENCE = "left out {face} of crumbs that stand on larger sheets"
# In area: a hundredth of the smallest neighborhood that is described, a disk of radius 0.04
# sqrt(area). Such a crumb is a single face, and has no neighborhood of its own.
CRUMB = 5e-5


def without_crumbs(mesh: TriangleMesh, report: RepairReport) -> tuple[TriangleMesh, RepairReport]:
    """The repaired mesh without sheets that were separated from larger ones and are nothing else.

    Whiskers and the single faces that a scanner sews from skin to skin have edges with three faces.
    Repair separates them; each would be a component that takes samples and must be placed, though
    all of its vertices have an answer on the sheet that it stood on, or it is a crumb.

    Parameters
    ----------
    mesh, report
        As :func:`sherd.repair.repair.repair` returns them.

    Returns
    -------
    mesh, report
        The same objects if there is no such sheet; else the report has one step more.
    """
    crumbs = _crumbs(mesh, report)
    if not crumbs.any():
        return mesh, report
    gone = crumbs[mesh.faces].any(axis=1)
    kept_mesh, kept = mesh.submesh(~gone)
    renumber = np.full(mesh.vertex_count, -1, dtype=np.int64)
    renumber[kept] = np.arange(len(kept))
    known = report.new_vertices >= 0
    new = np.where(known, renumber[np.where(known, report.new_vertices, 0)], -1)
    step = RepairStep(
        "drop crumbs",
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


def _crumbs(mesh: TriangleMesh, report: RepairReport) -> Bools:
    """The vertices (n,) of those sheets."""
    original = report.original_vertices
    if np.bincount(original).max() == 1:  # no vertex was doubled
        return np.zeros(mesh.vertex_count, dtype=bool)
    labels = mesh.component_labels
    areas = np.bincount(labels, mesh.vertex_areas)
    largest = np.zeros(len(report.new_vertices))
    np.maximum.at(largest, original, areas[labels])
    count = np.bincount(labels)
    own = np.bincount(labels, areas[labels] >= largest[original])
    gone = (own == 0) | ((own < count) & (areas < CRUMB * mesh.area))
    crumbs: Bools = gone[labels]
    return crumbs
