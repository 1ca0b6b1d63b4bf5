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

__all__ = ["PreparedMesh", "command_line", "prepared_mesh"]


@dataclass(frozen=True, eq=False)
class PreparedMesh:
    """A mesh as read, the same after repair, and how their numbers correspond."""

    original: TriangleMesh
    repaired: TriangleMesh
    report: RepairReport
    notices: tuple[str, ...]


def prepared_mesh(path: Path) -> PreparedMesh:
    """Read and repair a mesh; says on standard error what was adapted."""
    original, notices = read_mesh_with_notices(path)
    repaired, report = repair(original)
    said = (*notices, *(f"repaired for this run: {text}" for text in report.notices))
    for text in said:
        click.echo(f"{click.style('note:', fg='yellow')} {path.name}: {text}", err=True)
    return PreparedMesh(original, repaired, report, said)


def command_line() -> str:
    """What the user typed, ready to be typed again."""
    return shlex.join(["sherd", *sys.argv[1:]])
