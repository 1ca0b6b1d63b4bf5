"""`sherd check`."""

from __future__ import annotations

import json
from pathlib import Path

import click

from sherd.cli.exits import INVALID_INPUT
from sherd.cli.options import quiet_option
from sherd.errors import InputError
from sherd.files.mesh_files import read_mesh_with_notices, write_mesh
from sherd.output import require_writable
from sherd.repair.inspection import inspect
from sherd.repair.repair import repair

__all__ = ["check_command"]

EXIT_OF = {"usable": 0, "after repair": 1, "unusable": INVALID_INPUT}


@click.command("check")
@click.argument("mesh", type=click.Path(path_type=Path))
@click.option("--repair", "repaired", type=click.Path(path_type=Path), help="Write it repaired.")
@click.option("--json", "as_json", is_flag=True, help="Print the findings as JSON.")
@quiet_option("Print nothing; the exit code tells.")
def check_command(mesh: Path, *, repaired: Path | None, as_json: bool, quiet: bool) -> int:
    """Say what is wrong with MESH and what repair would do.

    Exit code 0: usable as it is, or repaired and written; 1: usable after repair, which the other
    commands do by themselves and say so; 3: unusable.

    \b
    Examples:
      sherd check scan.obj
      sherd check scan.obj --repair mended.ply
    """  # noqa: D301
    if repaired is not None:
        require_writable(repaired)
    try:
        loaded, notices = read_mesh_with_notices(mesh)
        report = inspect(loaded)
    except InputError as error:
        if not as_json:
            raise
        click.echo(json.dumps({"usable": "unusable", "error": str(error)}, indent=2))
        return INVALID_INPUT
    if as_json:
        click.echo(json.dumps({**report.as_dict(), "notices": list(notices)}, indent=2))
    elif not quiet:
        click.echo("\n".join([str(report), *(f"  note: {notice}" for notice in notices)]))
    if repaired is not None and report.usable != "unusable":
        mended = repair(loaded)[0]
        write_mesh(mended, repaired)
        if not (as_json or quiet):
            click.echo(f"  written: {repaired}")
        return EXIT_OF[inspect(mended).usable]
    return EXIT_OF[report.usable]
