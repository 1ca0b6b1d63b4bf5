"""The one door in: what a user has becomes a repaired mesh, with the way back to its numbering.

Python and the command line walk through the same functions here, so a file has one answer.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from sherd.errors import InputError
from sherd.files.cloud_files import read_points
from sherd.files.mesh_files import read_mesh_with_notices
from sherd.mesh.point_cloud import PointCloud
from sherd.mesh.sides import turned_over
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.repair.repair import RepairReport, repair
from sherd.repair.sheets import without_crumbs
from sherd.repair.sides import side_is_unclear

__all__ = ["Intake", "MeshSource", "ScanSource", "mesh_intake", "piece_intakes", "scan_intake"]

# A mesh, the path of a file, (vertices, faces), or any object with arrays of these names, such as a
# trimesh.Trimesh; a scan may be points as well.
MeshSource: TypeAlias = TriangleMesh | str | os.PathLike[str] | tuple[Any, Any] | Any
ScanSource: TypeAlias = MeshSource | PointCloud


@dataclass(frozen=True, eq=False)
class Intake:
    """A shape as it came in, the same after repair, and how their numbers correspond.

    Attributes
    ----------
    original
        The shape as it was given; answers are numbered as it is. Of points, a surface over them.
    mesh
        The same repaired: what all work is done on.
    report
        What was repaired, and the numbering.
    notices
        Sentences that say what was adapted.
    side_known
        False if the surface may be inside out: made from points without normals, or its faces
        agreed too little on what is outside.
    """

    original: TriangleMesh
    mesh: TriangleMesh
    report: RepairReport
    notices: tuple[str, ...]
    side_known: bool = True

    def turned_over(self) -> Intake:
        """The same with all faces turned over."""
        return replace(self, original=turned_over(self.original), mesh=turned_over(self.mesh))


def mesh_intake(source: MeshSource | Intake) -> Intake:
    """Take in a shape that must have faces.

    Raises
    ------
    MeshFileError
        If a file is missing, damaged, or promises more than it holds.
    InvalidMeshError
        If there is no mesh in it, or no face with an area is left.
    InputError
        If `source` is nothing that a mesh can be made of.
    """
    if isinstance(source, Intake):
        return source
    if isinstance(source, PointCloud):
        raise InputError(
            f"{source.name}: holds points and no faces, but a mesh is needed here; lay a surface "
            "over them first: sherd.surface_from_points(points)"
        )
    if isinstance(source, str | os.PathLike):
        return _repaired(*read_mesh_with_notices(Path(source)))
    return _repaired(_as_mesh(source), ())


def scan_intake(source: ScanSource | Intake) -> Intake:
    """Take in a shape that may be a scan without faces.

    Raises
    ------
    MeshFileError, InvalidMeshError, InputError
        As :func:`mesh_intake`.
    """
    if isinstance(source, str | os.PathLike):
        cloud = read_points(source)
        return mesh_intake(source) if cloud is None else _surface(cloud)
    if isinstance(source, PointCloud):
        return _surface(source)
    if not isinstance(source, Intake) and not _holds_mesh(source):
        raise InputError(f"{_refusal(source)}; points without faces as sherd.PointCloud(points)")
    return mesh_intake(source)


def piece_intakes(sources: Sequence[ScanSource | Intake]) -> list[Intake]:
    """Take in several shapes, of which errors and answers say which of them is meant.

    Raises
    ------
    MeshFileError, InvalidMeshError, InputError
        As :func:`scan_intake`, or if one shape was given instead of several.
    """
    one = isinstance(sources, str | os.PathLike | TriangleMesh | PointCloud | Intake)
    pair = isinstance(sources, tuple) and all(isinstance(each, np.ndarray) for each in sources)
    if one or (pair and len(sources) == 2) or not isinstance(sources, Iterable):
        raise InputError(
            f"{type(sources).__name__} is one shape, but several are needed: write [piece]"
        )
    return [_piece_intake(source, number) for number, source in enumerate(sources)]


def _piece_intake(source: ScanSource | Intake, number: int) -> Intake:
    named = isinstance(source, str | os.PathLike | TriangleMesh | PointCloud | Intake)
    try:
        if not named and _holds_mesh(source):
            mesh = _as_mesh(source)
            return mesh_intake(TriangleMesh(mesh.vertices, mesh.faces, name=f"piece {number}"))
        return scan_intake(source)
    except InputError as error:
        if isinstance(source, str | os.PathLike | Intake):
            raise
        raise type(error)(f"piece {number}: {error}") from error


def _surface(cloud: PointCloud) -> Intake:
    from sherd.scan.surface_from_points import surface_from_points  # noqa: PLC0415 - meshes need none of it

    original = surface_from_points(cloud)
    known = cloud.normals is not None
    said = (
        f"holds {cloud.point_count} points and no faces; triangles were laid over the points, "
        + ("outward by their normals" if known else "outward as far as their shape tells"),
    )
    return replace(_repaired(original, said), side_known=known)


def _repaired(original: TriangleMesh, notices: tuple[str, ...]) -> Intake:
    mesh, report = without_crumbs(*repair(original))
    said = (*notices, *(f"repaired for this run: {text}" for text in report.notices))
    return Intake(original, mesh, report, said, side_known=not side_is_unclear(mesh, report))


def _as_mesh(source: Any) -> TriangleMesh:
    if isinstance(source, TriangleMesh):
        return source
    if not _holds_mesh(source):
        raise InputError(_refusal(source))
    if isinstance(source, tuple):
        return TriangleMesh(*source)
    return TriangleMesh(np.asarray(source.vertices), np.asarray(source.faces))


def _holds_mesh(source: Any) -> bool:
    if isinstance(source, tuple):
        return len(source) == 2
    return all(getattr(source, name, None) is not None for name in ("vertices", "faces"))


def _refusal(source: Any) -> str:
    return (
        f"{type(source).__name__} is no mesh; give a TriangleMesh, a path, a tuple (vertices, "
        "faces), or an object with both, such as a trimesh.Trimesh"
    )
