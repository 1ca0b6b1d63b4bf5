"""Between the numbering of what the user gave and that of the repaired mesh."""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np
from scipy.spatial import cKDTree

from sherd.arrays import Floats, Ints
from sherd.errors import InputError
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.scan.intake import Intake, mesh_intake

__all__ = [
    "nearest_repaired",
    "original_normals",
    "original_points",
    "outward_normals",
    "repaired_vertices",
    "turned_as_repaired",
]


def repaired_vertices(intake: Intake, vertices: Ints, *, what: str) -> Ints:
    """The given vertices (p,) of the original in the numbering of the repaired mesh.

    Raises
    ------
    InputError
        If a vertex does not exist, or was left out because it belongs to no face with an area;
        `what` begins the message.
    """
    count, name = intake.original.vertex_count, intake.original.name
    outside = (vertices < 0) | (vertices >= count)
    if outside.any():
        raise InputError(
            f"{what} names vertex {vertices[np.argmax(outside)]} of {name}, which has "
            f"0..{count - 1}"
        )
    found = intake.report.new_vertices[vertices]
    if (found < 0).any():
        raise InputError(
            f"{what} names vertex {vertices[np.argmax(found < 0)]} of {name}, which belongs to no "
            "face with an area"
        )
    return found


def original_points(intake: Intake, points: SurfacePoints) -> SurfacePoints:
    """Points on the repaired mesh as points on the original: the same places.

    Faces may have been dropped or turned and vertices doubled or welded; a face is recognized by
    the old representatives of its corners.
    """
    if not intake.report.changed and np.array_equal(intake.mesh.faces, intake.original.faces):
        return points
    before, after = _corner_names(intake)
    matching = _rows_found(np.sort(after, axis=1), np.sort(before, axis=1))
    faces = matching[points.faces]
    # the weight of a corner goes to the corner with the same representative
    corners, wanted = after[points.faces], before[faces]
    same = wanted[:, :, None] == corners[:, None, :]
    return SurfacePoints(faces, np.einsum("pij,pj->pi", same, points.barycentric))


def turned_as_repaired(intake: Intake) -> TriangleMesh:
    """The original with each face as the repaired mesh has it, so that sides agree."""
    mesh = intake.original
    if not intake.report.changed:
        return mesh
    before, after = _corner_names(intake)
    match = _rows_found(np.sort(before, axis=1), np.sort(after, axis=1))
    known = np.flatnonzero(match < len(after))  # others were left out
    rows, wanted = before[known], after[match[known]]
    kept = [(np.roll(rows, turn, axis=1) == wanted).all(axis=1) for turn in range(3)]
    turned = known[~np.logical_or.reduce(kept)]
    if not len(turned):
        return mesh
    faces = mesh.faces.copy()
    faces[turned] = faces[turned, ::-1]
    return TriangleMesh(mesh.vertices, faces, fields=mesh.fields, name=mesh.name)


def original_normals(intake: Intake) -> Floats:
    """(n, 3) outward normals at the vertices of the original: those of the repaired mesh.

    Zero at vertices without a face; the original's own faces may look inward. They are kept as
    long as the original is.
    """
    known = _normals.get(intake.original)
    if known is None:
        known = intake.mesh.vertex_normals
        if intake.report.changed:
            lifted = intake.report.to_original(known, fill=0.0)
            known = np.asarray(lifted, dtype=np.float64)
        _normals[intake.original] = known
    return known


def outward_normals(mesh: TriangleMesh) -> Floats:
    """`original_normals` of a mesh as it was given, which is repaired for it only if need be."""
    known = _normals.get(mesh)
    return original_normals(mesh_intake(mesh)) if known is None else known


# Results of many parts share one full shape, and to repair a million vertices takes seconds.
_normals: WeakKeyDictionary[TriangleMesh, Floats] = WeakKeyDictionary()


def nearest_repaired(intake: Intake) -> Ints:
    """For each vertex of the original itself on the repaired mesh, or the nearest one there."""
    source = intake.report.new_vertices.copy()
    gone = np.flatnonzero(source < 0)
    if len(gone):
        tree = cKDTree(intake.mesh.vertices)
        source[gone] = tree.query(intake.original.vertices[gone])[1]
    return source


def _corner_names(intake: Intake) -> tuple[Ints, Ints]:
    """Corners of the faces before (m, 3) and after (m', 3) repair, by old representatives."""
    new, old = intake.report.new_vertices, intake.report.original_vertices
    # welded vertices share one representative; doubled ones have the same old vertex
    representative = np.where(new >= 0, old[np.maximum(new, 0)], np.arange(len(new)))
    return representative[intake.original.faces], representative[old[intake.mesh.faces]]


def _rows_found(wanted: Ints, rows: Ints) -> Ints:
    """For each row (m, 3) of `wanted` the first equal row of `rows` (k, 3); k or more if none."""
    both = np.concatenate([rows, wanted])
    base = int(both.max()) + 1
    # two whole numbers per row: a pair of indices, named anew so that the third fits beside it
    _, pair = np.unique(both[:, 0] * base + both[:, 1], return_inverse=True)
    _, first, row = np.unique(
        pair.ravel() * base + both[:, 2], return_index=True, return_inverse=True
    )
    found: Ints = first[row.ravel()[len(rows) :]]
    return found
