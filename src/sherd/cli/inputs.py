"""What commands have in common: kinds of values, the template file, notices, the command line."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.shell_completion import CompletionItem

from sherd.errors import OutputError
from sherd.output import require_writable
from sherd.report.stored.folder import ASSEMBLY_FORMAT, FIT_FORMAT, JOINED_FORMAT
from sherd.result_folder import NAMES, ResultKind, replaceable_files
from sherd.results.match_options import SCALES
from sherd.scan.intake import Intake, mesh_intake
from sherd.surface.template import ArrivingTemplate, Template, file_content
from sherd.threads import begun

if TYPE_CHECKING:  # each command loads the kind of result that it has, and no other
    from sherd.results.fitted.fit_result import Fit
    from sherd.results.locate_result import LocateResult
    from sherd.results.match_result import MatchResult
    from sherd.results.overlap_result import Overlap
    from sherd.results.puzzle.assembly import Assembly
    from sherd.results.puzzle.joined import Joined

__all__ = [
    "ScaleType",
    "begun_template",
    "check_fit_outputs",
    "check_outputs",
    "check_piece_outputs",
    "command_line",
    "show_assembly_notices",
    "show_fit_notices",
    "show_joined_notices",
    "show_notices",
    "show_overlap_notices",
    "stored_template",
]


class ScaleType(click.ParamType):  # type: ignore[type-arg, unused-ignore]
    """A word of SCALES or a number; the options refuse numbers out of range."""

    name = "scale"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> str | float:
        """The word or number that was typed."""
        if value in SCALES:
            return str(value)
        try:
            return float(value)
        except ValueError:
            self.fail(f"{value!r} is neither {', '.join(SCALES)} nor a number", param, ctx)

    def shell_complete(
        self,
        ctx: click.Context,  # noqa: ARG002 - click asks for it
        param: click.Parameter,  # noqa: ARG002
        incomplete: str,
    ) -> list[CompletionItem]:
        """The words."""
        return [CompletionItem(word) for word in SCALES if word.startswith(incomplete)]


def check_outputs(
    folder: Path,
    kind: str,
    full: Path,
    part: Path,
    *,
    overwrite: bool,
    template: Path | None = None,
    own: Iterable[str] = (),
) -> None:
    """Refuse now what could not be written, or must not be replaced, when the work is done.

    Raises
    ------
    OutputError
        If the folder or the template file cannot be written, the folder is not free for a result
        of this kind, or `full` or `part` lies there under a name that the result needs.
    """
    for mesh in (full, part):
        if mesh.resolve().parent == folder.resolve():
            _refuse_inside(folder, (mesh,))
    question = ResultKind(kind, full.name, part.name)
    _check_free(folder, question, template, overwrite=overwrite, own=own)


def check_piece_outputs(
    folder: Path,
    full: Path | None,
    pieces: Sequence[Path],
    *,
    overwrite: bool,
    template: Path | None = None,
) -> None:
    """As :func:`check_outputs`, for a whole and its pieces, or for pieces without one.

    Raises
    ------
    OutputError
        If the folder or the template file cannot be written, the folder is not free for this
        result, or a shape lies there under a name that the result needs.
    """
    _refuse_inside(folder, pieces if full is None else (full, *pieces))
    names = ", ".join(piece.name for piece in pieces)
    question = (
        ResultKind(JOINED_FORMAT, "nothing", names)
        if full is None
        else ResultKind(ASSEMBLY_FORMAT, full.name, names)
    )
    _check_free(folder, question, template, overwrite=overwrite)


def check_fit_outputs(
    folder: Path,
    shapes: Sequence[Path],
    earlier: Sequence[MatchResult] | None,
    *,
    overwrite: bool,
    template: Path | None = None,
) -> None:
    """As :func:`check_outputs`, for a fit of files, or of what was matched before.

    Raises
    ------
    OutputError
        If the folder or the template file cannot be written, the folder is not free for this
        result, or a shape lies there under a name that the result needs.
    """
    _refuse_inside(folder, shapes)
    if earlier is None:
        full, parts = shapes[0].name, [part.name for part in shapes[1:]]
    else:
        full, parts = earlier[0].full.name, [match.part.name for match in earlier]
    question = ResultKind(FIT_FORMAT, full, ", ".join(parts))
    _check_free(folder, question, template, overwrite=overwrite)


def _refuse_inside(folder: Path, shapes: Iterable[Path]) -> None:
    """Refuse shapes that lie in the folder or below it under a name that a result has there."""
    for mesh in shapes:
        if mesh.name in NAMES and mesh.resolve().is_relative_to(folder.resolve()):
            raise OutputError(f"{mesh}: would be replaced by the result; choose another folder")


def _check_free(
    folder: Path,
    question: ResultKind,
    template: Path | None,
    *,
    overwrite: bool,
    own: Iterable[str] = (),
) -> None:
    replaceable_files(folder, question, overwrite=overwrite, own=own)
    if template is not None and not template.exists():
        require_writable(template)


def show_notices(result: MatchResult | LocateResult, *, quiet: bool) -> None:
    """Say on standard error what was adapted; called once there is a result it applies to."""
    shapes = {"full": result.full, "part": result.part}
    _say(((mesh.name, result.notices[which]) for which, mesh in shapes.items()), quiet=quiet)


def show_overlap_notices(result: Overlap, *, quiet: bool) -> None:
    """As :func:`show_notices`, of two incomplete shapes."""
    shapes = {"first": result.first, "second": result.second}
    _say(((mesh.name, result.notices[which]) for which, mesh in shapes.items()), quiet=quiet)


def show_fit_notices(result: Fit, *, quiet: bool) -> None:
    """As :func:`show_notices`, of a fit."""
    _say([(result.full.name, result.notices)], quiet=quiet)


def show_assembly_notices(result: Assembly, *, quiet: bool) -> None:
    """As :func:`show_notices`, of a whole and its pieces."""
    matches = [piece.match for piece in result.pieces if piece.match is not None]
    said = [(match.part.name, match.notices["part"]) for match in matches]
    _say([(result.full.name, result.notices), *said], quiet=quiet)


def show_joined_notices(result: Joined, *, quiet: bool) -> None:
    """As :func:`show_notices`, of pieces without a whole."""
    said = [(p.name, texts) for p, texts in zip(result.pieces, result.notices, strict=True)]
    _say(said, quiet=quiet)


def _say(notices: Iterable[tuple[str, Iterable[str]]], *, quiet: bool) -> None:
    if quiet:
        return
    for name, texts in notices:
        for text in texts:
            note = click.style("note:", fg="yellow")
            click.echo(f"{note} {name}: {text}", err=True)


def begun_template(path: Path | None, full: Path, *, quiet: bool) -> Callable[[], Template]:
    """Begin :func:`stored_template` beside other work; the result waits for it and raises for it.

    It waits for the mesh only: a file goes on being read, and raises in the end, while the part is
    described; a new one is made when all that was typed is known to be right.
    """
    intake = begun(partial(mesh_intake, full))
    if path is not None and path.exists():
        return lambda: ArrivingTemplate(partial(file_content, path), path, intake())
    return lambda: _new_template(path, intake(), quiet=quiet)


def stored_template(path: Path | None, full: Path, *, quiet: bool) -> Template:
    """The template of the mesh `full`, kept in the file `path` if one is named.

    How large a file is that is made is said on standard error, unless quiet.

    Raises
    ------
    InputError
        If the file was made for another mesh.
    """
    intake = mesh_intake(full)
    if path is not None and path.exists():
        return Template.load(path, full=intake)
    return _new_template(path, intake, quiet=quiet)


def _new_template(path: Path | None, intake: Intake, *, quiet: bool) -> Template:
    template = Template(intake)
    if path is not None:
        template.save(path)
        if not quiet:
            size = path.stat().st_size / 1e6
            click.echo(f"template written: {path} ({size:.0f} MB)", err=True)
    return template


def command_line() -> str:
    """What the user typed, ready to be typed again."""
    return shlex.join(["sherd", *sys.argv[1:]])
