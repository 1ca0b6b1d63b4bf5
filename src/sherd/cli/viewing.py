"""`sherd view`."""

from __future__ import annotations

import sys
import webbrowser
from pathlib import Path

import click

from sherd.cli.options import quiet_option
from sherd.drawing.picture import picture, png_bytes
from sherd.errors import InputError
from sherd.output import require_writable, write_bytes
from sherd.report.stored.folder import folder_problems
from sherd.report.stored.stored_exhibit import read_exhibit

__all__ = ["on_terminal", "view_command"]


@click.command("view")
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--png", is_flag=True, help="Draw a picture instead; needs no display and no GPU.")
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), help="Picture to write; FOLDER/view.png."
)
@click.option("--layer", help="What to color by, for example confidence; else the first.")
@click.option("--width", type=int, default=1600, show_default=True, help="In pixels.")
@click.option("--transparent", is_flag=True, help="No background.")
@quiet_option()
def view_command(
    folder: Path,
    *,
    png: bool,
    output: Path | None,
    layer: str | None,
    width: int,
    transparent: bool,
    quiet: bool,
) -> int:
    """Open the report in FOLDER, which another command wrote, or draw it anew.

    On a terminal the report opens in the browser; otherwise its path is printed.

    \b
    Examples:
      sherd view out/
      sherd view out/ --png -o figure.png --layer confidence --width 2400
      sherd view out/ --png --transparent
    """  # noqa: D301
    if png:
        path = output or folder / "view.png"
        require_writable(path)
        image = picture(read_exhibit(folder), layer=layer, width=width, transparent=transparent)
        write_bytes(path, png_bytes(image))
        if not quiet:
            click.echo(f"written: {path}")
        return 0
    if output is not None or layer is not None or transparent:
        raise click.UsageError("-o, --layer and --transparent say how to draw; add --png")
    problems = folder_problems(folder)
    if problems:
        raise InputError(problems[0])
    report = (folder / "report.html").resolve()
    if on_terminal():
        webbrowser.open(report.as_uri())
    if not quiet:
        click.echo(str(report))
    return 0


def on_terminal() -> bool:
    """Whether a person reads what is printed."""
    return sys.stdout.isatty()
