"""Reading what the user names: mesh files, with visible repairs and the old numbering kept."""

from __future__ import annotations

import shlex
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import click

from sherd.files.cloud_files import read_points
from sherd.files.mesh_files import read_mesh_with_notices
from sherd.mesh.sides import turned_over
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.repair.repair import RepairReport, repair
from sherd.repair.sides import side_is_unclear
from sherd.scan.surface_from_points import surface_from_points

__all__ = ["PreparedMesh", "command_line", "prepared_mesh", "prepared_part", "show_notices"]


@dataclass(frozen=True, eq=False)
class PreparedMesh:
    """A mesh as read, the same after repair, and how their numbers correspond.

    `one_sided` if it may be inside out: made from points without normals, or its faces agreed too
    little on what is outside.
    """

    original: TriangleMesh
    repaired: TriangleMesh
    report: RepairReport
    notices: tuple[str, ...]
    one_sided: bool = False

    def turned(self) -> PreparedMesh:
        """The same with all faces turned over."""
        return replace(
            self, original=turned_over(self.original), repaired=turned_over(self.repaired)
        )


def prepared_part(path: Path) -> PreparedMesh:
    """Read and repair a part, which may be a scan without faces."""
    part = read_points(path)
    if part is None:
        mesh = prepared_mesh(path)
        return replace(mesh, one_sided=side_is_unclear(mesh.repaired, mesh.report))
    original = surface_from_points(part)
    repaired, report = repair(original)
    known = part.normals is not None
    said = (
        f"holds {part.point_count} points and no faces; triangles were laid over the points, "
        + ("outward by their normals" if known else "outward as far as shape and match tell"),
        *(f"repaired for this run: {text}" for text in report.notices),
    )
    return PreparedMesh(original, repaired, report, said, one_sided=not known)


def prepared_mesh(path: Path) -> PreparedMesh:
    """Read and repair a mesh; :func:`show_notices` says what was adapted."""
    original, notices = read_mesh_with_notices(path)
    repaired, report = repair(original)
    said = (*notices, *(f"repaired for this run: {text}" for text in report.notices))
    return PreparedMesh(original, repaired, report, said)


def show_notices(*meshes: PreparedMesh) -> None:
    """Say on standard error what was adapted; called once there is a result it applies to."""
    for mesh in meshes:
        for text in mesh.notices:
            note = click.style("note:", fg="yellow")
            click.echo(f"{note} {mesh.original.name}: {text}", err=True)


def command_line() -> str:
    """What the user typed, ready to be typed again."""
    return shlex.join(["sherd", *sys.argv[1:]])
