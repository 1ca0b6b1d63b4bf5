"""write_report: the output folder of any result."""

from __future__ import annotations

import os
from importlib import import_module
from typing import TYPE_CHECKING, Any, TypeAlias, Union

from PIL import Image

from sherd.arrays import Floats
from sherd.drawing.picture import picture, png_bytes, stage, without_heading
from sherd.errors import InputError
from sherd.report.exports import exported
from sherd.report.frame import Report
from sherd.report.html import packed, page_of
from sherd.report.stored.folder import plain
from sherd.result_folder import ResultFolder, kind_of, replaceable_files
from sherd.threads import begun

if TYPE_CHECKING:  # who writes one kind of result waits for no other to be loaded
    from sherd.results.fitted.fit_result import Fit
    from sherd.results.locate_result import LocateResult
    from sherd.results.many.identification import Identification
    from sherd.results.match_result import MatchResult
    from sherd.results.overlap_result import Overlap
    from sherd.results.puzzle.assembly import Assembly
    from sherd.results.puzzle.joined import Joined

__all__ = ["report_of", "write_report"]

Result: TypeAlias = Union[
    "MatchResult", "LocateResult", "Overlap", "Assembly", "Joined", "Identification", "Fit"
]

# Who describes a result of each class, in which module.
_REPORTS = {
    "sherd.results.fitted.fit_result.Fit": "sherd.report.fitted.fit_report.fit_report",
    "sherd.results.locate_result.LocateResult": "sherd.report.locate_report.locate_report",
    "sherd.results.many.identification.Identification": (
        "sherd.report.many.identify_report.identify_report"
    ),
    "sherd.results.match_result.MatchResult": "sherd.report.match_report.match_report",
    "sherd.results.overlap_result.Overlap": "sherd.report.overlap_report.overlap_report",
    "sherd.results.puzzle.assembly.Assembly": (
        "sherd.report.puzzle.assembly_report.assembly_report"
    ),
    "sherd.results.puzzle.joined.Joined": "sherd.report.puzzle.joined_report.joined_report",
}


def write_report(
    result: Result,
    folder: str | os.PathLike[str],
    *,
    command: str = "",
    errors: Floats | None = None,
    exports: tuple[str, ...] = (),
    texture: str | os.PathLike[str] | None = None,
    overwrite: bool = False,
) -> dict[str, Any]:
    """Write all files of a result: tables, colored meshes, a picture, a page; see docs/files.md.

    Parameters
    ----------
    result
        Of :func:`sherd.match`, :func:`sherd.locate`, :func:`sherd.overlap`,
        :func:`sherd.assemble`, :func:`sherd.join`, :func:`sherd.identify` or :func:`sherd.fit`.
    folder
        Made when missing. An older result of the same command for shapes of the same names is
        replaced, and those of its files that the new result does not have are removed.
    command
        What to type to get the same again, shown in the report.
    errors
        (n_part,) error of each vertex in sqrt(area of the full shape), where the truth of a match
        is known.
    exports
        Further files, of :data:`sherd.report.exports.SHAPE_EXPORTS` and, for a match,
        ``MAP_EXPORTS``.
    texture
        OBJ file that the full shape of a fit was read from: ``fit.obj`` keeps its texture
        coordinates, groups and materials.
    overwrite
        Whether a result of another kind, or others' files of the same names, may be replaced too.
        Only files that the older ``result.json`` names are removed.

    Returns
    -------
    dict
        The content of ``result.json``.

    Raises
    ------
    OptionError
        If an export is unknown.
    InputError
        If `result` is none, errors are given for a region, or a texture for what is no fit.
    MeshFileError
        If the file with the texture cannot be read.
    OutputError
        If something cannot be written or must not be replaced; what stood in the folder before is
        untouched.

    Examples
    --------
    >>> import tempfile
    >>> from sherd.locate import locate
    >>> from sherd.shapes import creature, cut_by_ball, whole
    >>> full = creature(5000)
    >>> result = locate(full, cut_by_ball(whole(creature(5000, pose="walk"), full), 0, 0.5).mesh)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     sorted(write_report(result, folder)["files"])
    ['part.ply', 'region.csv', 'region.ply', 'region.png', 'report.html']
    """
    begun(Image.preinit)  # else both that write images wait for its drivers to be loaded
    report = report_of(result, command=command, errors=errors, texture=texture)
    document = plain(dict(report.document))
    kind = kind_of(document)
    replaced = replaceable_files(folder, kind, overwrite=overwrite)
    with ResultFolder(folder, replaced=replaced) as output:
        camera = stage(report.exhibit)
        shown = begun(lambda: packed(report.exhibit, staging=camera))
        for name, make in report.files.items():
            output.add(name, make())
        image = picture(report.exhibit, staging=camera)
        png = begun(lambda: png_bytes(image))
        output.add("report.html", page_of(report.exhibit, shown(), without_heading(image)))
        output.add(report.picture_name, png())
        for name, content in exported(report.exhibit, exports).items():
            output.add(name, content)
        return output.finish(document)


def report_of(
    result: Result,
    *,
    command: str = "",
    errors: Floats | None = None,
    texture: str | os.PathLike[str] | None = None,
) -> Report:
    """What there is to write of a result, and to show."""
    for kind in type(result).__mro__:
        described = _REPORTS.get(f"{kind.__module__}.{kind.__name__}")
        if described is not None:
            break
    else:
        raise InputError(
            f"a {type(result).__name__} is no result of match, locate, overlap, assemble, identify "
            "or fit"
        )
    extras: dict[str, Any] = {}
    if errors is not None:
        if kind.__name__ != "MatchResult":
            raise InputError(f"errors are of the points of a match; a {kind.__name__} has none")
        extras["errors"] = errors
    if texture is not None:
        if kind.__name__ != "Fit":
            raise InputError("a texture is for a fit, whose fit.obj keeps it")
        extras["texture"] = texture
    module, name = described.rsplit(".", 1)
    report: Report = getattr(import_module(module), name)(result, command=command, **extras)
    return report
