"""inspect: what is wrong with a mesh, how much of its area that concerns, and what repair makes."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from sherd.arrays import Floats
from sherd.errors import InvalidMeshError
from sherd.mesh import gluing, topology
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.mesh.words import counted, spelled
from sherd.repair.changes import degenerate_faces
from sherd.repair.repair import RepairStep, repair

__all__ = ["Finding", "MeshReport", "inspect"]

Usable = Literal["usable", "after repair", "unusable"]

# Beyond this ratio one part of the mesh is seen at another scale than the other.
_UNEVEN = 1000.0


@dataclass(frozen=True)
class Finding:
    """One defect: how many elements, and the area of their faces over the area of the mesh."""

    name: str
    count: int
    area_fraction: float
    sentence: str


@dataclass(frozen=True, repr=False)
class MeshReport:
    """State of a mesh as it is, and what the default repairs make of it.

    Parameters
    ----------
    name, vertex_count, face_count
        Of the mesh as it is.
    area, extent
        Total area, l^2, and sides of the bounding box of all faces, (3,) l.
    component_count
        Connected pieces with at least one face.
    boundary_edge_count, boundary_loop_count
        Edges with one face; rims of holes, counted after repair (None if unusable).
    closed
        No boundary, after repair.
    genus
        Number of handles once all rims are capped; None if unusable or a piece has one side only.
    shortest_edge, median_edge, longest_edge
        In units of sqrt(area); edges of length zero count as degenerate faces, not here.
    findings
        What is wrong, in the order of repair; empty for a clean mesh.
    notes
        What is no defect but worth knowing.
    repairs
        What repair did, one entry a step; empty if unusable.
    usable
        As it is, after repair, or not at all.

    Examples
    --------
    >>> inspect(TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])).usable
    'usable'
    """

    name: str
    vertex_count: int
    face_count: int
    area: float
    extent: tuple[float, float, float]
    component_count: int
    boundary_edge_count: int
    boundary_loop_count: int | None
    closed: bool
    genus: int | None
    shortest_edge: float
    median_edge: float
    longest_edge: float
    findings: tuple[Finding, ...]
    notes: tuple[str, ...]
    repairs: tuple[RepairStep, ...]
    usable: Usable

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers, strings, lists and dictionaries, ready for JSON."""
        return asdict(self)

    def __repr__(self) -> str:
        wrong = ", ".join(f"{finding.name} ({finding.count})" for finding in self.findings)
        return (
            f"MeshReport({self.name!r}, {self.vertex_count} vertices, {self.face_count} faces: "
            f"{self.usable}{f'; {wrong}' if wrong else ''})"
        )

    def __str__(self) -> str:
        size = " x ".join(f"{side:.4g}" for side in self.extent)
        lines = [
            f"{self.name}: {counted(self.vertex_count, 'vertex')}, "
            f"{counted(self.face_count, 'face')}, {counted(self.component_count, 'component')}",
            f"  area {self.area:.6g}, extent {size}, edges {self.shortest_edge:.2g} to "
            f"{self.longest_edge:.2g} (median {self.median_edge:.2g}) of sqrt(area)",
        ]
        if self.boundary_loop_count is not None:
            rims = "closed" if self.closed else counted(self.boundary_loop_count, "boundary loop")
            genus = "" if self.genus is None else f", genus {self.genus}"
            lines.append(f"  {rims}{genus}")
        lines += [
            f"  wrong: {finding.sentence} ({100 * finding.area_fraction:.3g} % of the area)"
            for finding in self.findings
        ]
        lines += [f"  note: {note}" for note in self.notes]
        if self.usable == "after repair":
            lines += [f"  repair: {step.sentence}" for step in self.repairs if step.count]
        verdict = {
            "usable": "usable as it is",
            "after repair": "usable after repair",
            "unusable": "unusable",
        }
        return "\n".join([*lines, f"  {verdict[self.usable]}"])


def inspect(mesh: TriangleMesh) -> MeshReport:
    """Examine a mesh without changing it.

    Returns
    -------
    MeshReport
        ``str(report)`` is the text for people, ``report.as_dict()`` that for programs.

    Notes
    -----
    O(m log m) for m faces: the repairs are carried out to see what they would do.

    Examples
    --------
    >>> triangle = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> inspect(triangle).usable
    'usable'
    """
    repaired, repairs = _repaired(mesh)
    solid = mesh.faces[~degenerate_faces(mesh.vertices, mesh.faces)]
    ends = mesh.vertices[topology.unique_edges(solid)[0]]
    edges = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    # without area there is no unit of length, and the mesh is unusable anyway
    edges = edges / mesh.length if len(edges) else np.zeros(1)
    pieces = _piece_areas(mesh)
    one_sided = repaired is not None and _one_sided(repaired)
    rims, genus = (None, None) if repaired is None else _rims_and_genus(repaired)
    findings = tuple(_finding(step) for step in repairs if step.count)
    verdict: Usable = "after repair" if findings else "usable"
    if repaired is None:
        nothing = "all faces have no area: their corners coincide or lie on lines"
        findings = (Finding("no area", mesh.face_count, 1.0, nothing),)
        verdict = "unusable"
    return MeshReport(
        name=mesh.name,
        vertex_count=mesh.vertex_count,
        face_count=mesh.face_count,
        area=mesh.area,
        extent=_extent(mesh),
        component_count=len(pieces),
        boundary_edge_count=len(topology.boundary_edges(solid)),
        boundary_loop_count=rims,
        closed=rims == 0,
        genus=None if one_sided else genus,
        shortest_edge=float(edges.min()),
        median_edge=float(np.median(edges)),
        longest_edge=float(edges.max()),
        findings=findings,
        notes=_notes(mesh, pieces, edges, repaired, one_sided=one_sided),
        repairs=repairs,
        usable=verdict,
    )


# What each repair step found, said as a defect.
_DEFECTS = {
    "drop degenerate faces": "{face} without area",
    "drop duplicate faces": "{face} on top of another",
    "weld seams": "{vertex} coinciding with others along a seam",
    "split non-manifold edges": "{edge} with more than two faces",
    "split non-manifold vertices": "{vertex} in which sheets touch",
    "orient faces": "{face} turned against the neighbors or inward",
    "drop unreferenced vertices": "{vertex} on no face",
}


def _finding(step: RepairStep) -> Finding:
    sentence = spelled(_DEFECTS[step.name], step.count)
    return Finding(step.name, step.count, step.area_fraction, sentence)


def _repaired(mesh: TriangleMesh) -> tuple[TriangleMesh | None, tuple[RepairStep, ...]]:
    try:
        repaired, report = repair(mesh)
    except InvalidMeshError:  # no face with an area is left
        return None, ()
    return repaired, report.steps


def _extent(mesh: TriangleMesh) -> tuple[float, float, float]:
    x, y, z = np.ptp(mesh.vertices[mesh.used_vertices], axis=0).tolist()
    return x, y, z


def _piece_areas(mesh: TriangleMesh) -> Floats:
    """Area of each connected piece that has a face, descending, l^2."""
    labels = topology.component_labels(mesh.faces, mesh.vertex_count)[mesh.faces[:, 0]]
    _, piece = np.unique(labels, return_inverse=True)
    areas: Floats = np.bincount(piece.ravel(), mesh.face_areas).astype(np.float64)
    return np.sort(areas)[::-1]


def _rims_and_genus(mesh: TriangleMesh) -> tuple[int, int]:
    """Boundary loops and handles of a mesh without non-manifold edges or vertices."""
    rims = 0
    border = mesh.boundary_edges
    if len(border):
        # every border vertex has two border edges, so connected border edges are one loop
        names, ends = topology.renumbered(border)
        rims = int(gluing.components(ends[:, 0], ends[:, 1], len(names)).max()) + 1
    characteristic = mesh.vertex_count - len(mesh.edges) + mesh.face_count
    # Euler: V - E + F = 2 (components - genus) - rims
    return rims, (2 * mesh.component_count - rims - characteristic) // 2


def _one_sided(mesh: TriangleMesh) -> bool:
    """Whether a piece has no two sides."""
    pairs = gluing.face_pairs(mesh.vertices, mesh.faces)
    return bool(gluing.orientation_flips(mesh.vertices, mesh.faces, pairs)[2].any())


def _notes(
    mesh: TriangleMesh,
    pieces: Floats,
    edges: Floats,
    repaired: TriangleMesh | None,
    *,
    one_sided: bool,
) -> tuple[str, ...]:
    notes = []
    if len(pieces) > 1 and mesh.area > 0:
        share = 100 * float(pieces[0]) / mesh.area
        notes.append(f"the largest of {len(pieces)} components holds {share:.3g} % of the area")
    if repaired is not None and repaired.component_count not in (1, len(pieces)):
        notes.append(f"after repair there are {counted(repaired.component_count, 'component')}")
    if one_sided:
        notes.append("a component has one side only (like a Moebius strip); left and right blur")
    if edges.min() > 0 and edges.max() > _UNEVEN * edges.min():
        notes.append(
            f"the longest edge is {edges.max() / edges.min():.2g} times the shortest; "
            "remeshing evenly gives better results"
        )
    return tuple(notes)
