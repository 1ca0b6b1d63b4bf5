"""Between the numbering of the user's files and that of the repaired meshes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from sherd.arrays import Ints
from sherd.cli.inputs import PreparedMesh
from sherd.correspondence.point_map import PointMap
from sherd.errors import InputError
from sherd.match import MatchResult
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["as_read", "original_points", "repaired_vertices"]


def repaired_vertices(prepared: PreparedMesh, vertices: Ints, *, what: str) -> Ints:
    """The given vertices (p,) of the file in the numbering of the repaired mesh.

    Raises
    ------
    InputError
        If a vertex does not exist, or was left out because it belongs to no face with an area.
    """
    count, name = prepared.original.vertex_count, prepared.original.name
    outside = (vertices < 0) | (vertices >= count)
    if outside.any():
        raise InputError(
            f"{what}: names vertex {vertices[np.argmax(outside)]} of {name}, which has "
            f"0..{count - 1}"
        )
    found = prepared.report.new_vertices[vertices]
    if (found < 0).any():
        raise InputError(
            f"{what}: names vertex {vertices[np.argmax(found < 0)]} of {name}, which belongs to no "
            "face with an area"
        )
    return found


def original_points(prepared: PreparedMesh, points: SurfacePoints) -> SurfacePoints:
    """Points on the repaired mesh as points on the mesh that was read: the same places.

    Faces may have been dropped or turned and vertices doubled or welded; a face is recognized by
    the old representatives of its corners.
    """
    if not prepared.report.changed:
        return points
    before, after = _corner_names(prepared)
    matching = _rows_found(np.sort(after, axis=1), np.sort(before, axis=1))
    faces = matching[points.faces]
    # the weight of a corner goes to the corner with the same representative
    corners, wanted = after[points.faces], before[faces]
    same = wanted[:, :, None] == corners[:, None, :]
    return SurfacePoints(faces, np.einsum("pij,pj->pi", same, points.barycentric))


def _turned_as_repaired(prepared: PreparedMesh) -> TriangleMesh:
    """The mesh of the file with each face as the repaired mesh has it, so that sides agree."""
    mesh = prepared.original
    before, after = _corner_names(prepared)
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


def _nearest_kept(prepared: PreparedMesh) -> Ints:
    """For each vertex of the file itself on the repaired mesh, or the nearest one there."""
    source = prepared.report.new_vertices.copy()
    gone = np.flatnonzero(source < 0)
    if len(gone):
        tree = cKDTree(prepared.repaired.vertices)
        source[gone] = tree.query(prepared.original.vertices[gone])[1]
    return source


def _corner_names(prepared: PreparedMesh) -> tuple[Ints, Ints]:
    """Corners of the faces before (m, 3) and after (m', 3) repair, by old representatives."""
    new, old = prepared.report.new_vertices, prepared.report.original_vertices
    # welded vertices share one representative; doubled ones have the same old vertex
    representative = np.where(new >= 0, old[np.maximum(new, 0)], np.arange(len(new)))
    return representative[prepared.original.faces], representative[old[prepared.repaired.faces]]


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


def as_read(result: MatchResult, full: PreparedMesh, part: PreparedMesh) -> MatchResult:
    """The result on the user's meshes; those faces of the part that repair turned are turned.

    Vertices of the part without a face are unmatched; their best guess is the nearest one's answer.
    """
    if not (full.report.changed or part.report.changed):
        return replace(result, full=full.original, part=part.original)
    to_part, to_full = part.report.to_original, full.report.to_original
    source = _nearest_kept(part)
    points = original_points(full, result.point_map.points)[source]
    point_map = PointMap(
        points.faces,
        points.barycentric,
        np.asarray(to_part(result.point_map.matched, fill=False), dtype=bool),
        np.asarray(to_part(result.point_map.confidence, fill=0.0), dtype=np.float64),
    )
    region = replace(
        result.region,
        mask=np.asarray(to_full(result.region.mask, fill=False), dtype=bool),
        membership=np.asarray(to_full(result.region.membership, fill=0.0), dtype=np.float64),
    )
    alternatives = tuple(
        replace(
            other,
            points=original_points(full, other.points)[source],
            mask=np.asarray(to_full(other.mask, fill=False), dtype=bool),
        )
        for other in result.alternatives
    )
    return replace(
        result,
        full=full.original,
        part=_turned_as_repaired(part),
        point_map=point_map,
        region=region,
        alternatives=alternatives,
    )
