"""`sherd template`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import click

from sherd.cli.first_run import prepare_first_run
from sherd.cli.options import overwrite_option, quiet_option
from sherd.errors import InputError
from sherd.library.folder import Library
from sherd.output import Stages
from sherd.scan.intake import Intake, mesh_intake
from sherd.surface.template import Template

__all__ = ["template_command"]

FILE = click.Path(path_type=Path)


@click.command("template")
@click.argument("fulls", metavar="FULL...", type=FILE, nargs=-1, required=True)
@click.option("-o", "--output", type=FILE, required=True, help="Folder of the library.")
@overwrite_option
@quiet_option()
def template_command(fulls: tuple[Path, ...], output: Path, *, overwrite: bool, quiet: bool) -> int:
    """Prepare full shapes once, as a library that `sherd identify` asks.

    Shapes are added to those that the library has; one that it has already stays as it is.

    \b
    Examples:
      sherd template cat.ply horse.ply wolf.ply -o library/
      sherd template dog.ply -o library/
    """  # noqa: D301
    if output.suffix.lower() == ".npz":
        raise click.UsageError(
            f"-o {output}: a library is a folder; a file for --template is made by the first "
            "command that names it, such as sherd match"
        )
    library = Library.open_or_new(output, overwrite=overwrite)
    intakes = [mesh_intake(path) for path in fulls]  # a file that cannot be read ends it at once
    _refuse_repeated(intakes)
    for path, intake in zip(fulls, intakes, strict=True):
        if library.shelf_of(intake.original) is None:
            library.require_free(intake.original, overwrite=overwrite)
        elif not quiet:
            click.echo(f"{path}: is in the library already", err=True)
    prepare_first_run(quiet=quiet)
    stages = Stages(len(fulls), visible=False if quiet else None)
    for intake in intakes:
        with stages(intake.original.name):
            library = library.with_shape(Template(intake), overwrite=overwrite)
    stages.close()
    if not quiet:
        click.echo(f"{output}: {len(library.shelves)} full shapes")
    return 0


def _refuse_repeated(intakes: Sequence[Intake]) -> None:
    """Refuse files of one name, of which the second would take the first one's place."""
    names = Counter(intake.original.name for intake in intakes)
    repeated = [name for name, count in names.items() if count > 1]
    if repeated:
        raise InputError(f"{repeated[0]}: is named twice; rename one, or name it once")
