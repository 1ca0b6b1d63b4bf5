"""Reading what the user names: mesh files, with visible repairs and the old numbering kept."""

from __future__ import annotations

import shlex
import sys
from dataclasses import dataclass
from pathlib import Path

import click

from sherd.mesh.files import read_mesh_with_notices
from sherd.mesh.repair import RepairReport, repair
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["PreparedMesh", "command_line", "prepared_mesh", "show_notices"]


@dataclass(frozen=True, eq=False)
class PreparedMesh:
    """A mesh as read, the same after repair, and how their numbers correspond."""

    original: TriangleMesh
    repaired: TriangleMesh
    report: RepairReport
    notices: tuple[str, ...]


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
