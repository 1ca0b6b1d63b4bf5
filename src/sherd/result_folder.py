"""ResultFolder: files that belong together, and what they may replace."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import re
import secrets
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from sherd.errors import OutputError
from sherd.output import reported, require_writable

__all__ = [
    "NAMES",
    "RESULT",
    "ResultFolder",
    "ResultKind",
    "inside_name",
    "kind_of",
    "replaceable_files",
]

RESULT = "result.json"
# Whatever a result may consist of: a file of such a name is never taken for the user's own.
NAMES = frozenset(
    {
        RESULT, "report.html", "region.csv", "region.ply", "region.png", "part.ply", "full.ply",
        "correspondence.csv", "correspondence.corr", "correspondence.map", "correspondence.vts",
        "correspondence.parquet",
        "match.png", "alternatives.npz", "inverse.csv", "first_region.csv",
        "second_region.csv", "first.ply", "second.ply", "overlap.png", "labels.csv",
        "assembly.png", "pairs.csv", "partners.csv", "candidates.csv",
        "fit.ply", "fit.obj", "fit.glb", "fit.csv",
        "fit.png", "distances.csv", "completed.ply",
        "full.vtp", "part.vtp", "result.glb", "result.npz", "result.mat",
    }
)  # fmt: skip


# Where the files of one of several pieces are.
PIECE_FOLDER = re.compile(r"piece_\d+")


@dataclass(frozen=True)
class ResultKind:
    """What a result is of: its format, as in ``result.json``, and the names of both shapes."""

    file_format: str
    full: str
    part: str

    def __str__(self) -> str:
        words = self.file_format.split()
        return f"the {words[-2] if len(words) > 2 else 'result'} of {self.part} on {self.full}"

    def like(self, other: ResultKind) -> bool:
        """Whether both are the same question; the version of the format does not matter."""
        kind, other_kind = (k.file_format.rpartition(" ")[0] for k in (self, other))
        return (kind, self.full, self.part) == (other_kind, other.full, other.part)


def kind_of(document: Mapping[str, Any]) -> ResultKind:
    """The kind of a result by its ``result.json``.

    Raises
    ------
    KeyError, TypeError
        If it is none.
    """
    if "pieces" in document:
        pieces = ", ".join(str(piece["name"]) for piece in document["pieces"])
        full = document["full"]
        name = "nothing" if full is None else str(full["name"])
        return ResultKind(str(document["format"]), name, pieces)
    names = ("first", "second") if "first" in document else ("full", "part")
    shapes = (str(document[name]["name"]) for name in names)
    return ResultKind(str(document["format"]), *shapes)


def replaceable_files(
    folder: str | os.PathLike[str],
    kind: ResultKind,
    *,
    overwrite: bool = False,
    own: Iterable[str] = (),
) -> tuple[str, ...]:
    """Names of the files of an older result in `folder` that one of this kind may replace.

    An empty folder is free, and so is one that holds nothing but folders (often of other results)
    or an older result of the same kind. A result of another kind, and files that no result names,
    are not unless `overwrite` is set; even then
    nothing is removed that the older ``result.json`` does not name.

    Parameters
    ----------
    folder
        Where the result shall be written; need not exist.
    kind
        Of the new result.
    overwrite
        Whether another result may be replaced, and others' files of the same names.
    own
        Names that do not count as others' files.

    Raises
    ------
    OutputError
        If the folder cannot be written or is not free, or something in it that cannot be replaced
        stands in the way; the message says what is there.
    """
    target = Path(folder)
    require_writable(target, folder=True)
    if not target.exists():
        return ()
    _refuse_obstacles(target, kind)
    with reported(target):
        present = {
            path.name
            for path in target.iterdir()
            if not path.name.startswith(".") and path.is_file()
        } | _in_piece_folders(target, kind)
    old = _stored(target)
    if overwrite:
        return () if old is None else old[1]
    if old is None:
        foreign = sorted(present - set(own))
        if foreign:
            more = f" and {len(foreign) - 3} more" if len(foreign) > 3 else ""
            raise _taken(target, f"{', '.join(foreign[:3])}{more}, which no result names")
        return ()
    if not old[0].like(kind):
        raise _taken(target, str(old[0]))
    named = {name for name in present if Path(name).name in NAMES}
    foreign = sorted(named - set(old[1]) - {RESULT} - set(own))
    if foreign:
        raise _taken(target, f"{', '.join(foreign)}, which its {RESULT} does not name")
    return old[1]


def inside_name(name: str) -> str:
    """A file's name inside a result folder, at most one folder deep, as ``result.json`` has it.

    Whatever else a damaged or hostile ``result.json`` says stays inside the folder.

    Examples
    --------
    >>> inside_name("piece_0/part.ply"), inside_name("../part.ply"), inside_name("/etc/passwd")
    ('piece_0/part.ply', 'part.ply', 'passwd')
    """
    parts = name.split("/")
    if len(parts) == 2 and PIECE_FOLDER.fullmatch(parts[0]) and parts[1] not in ("", ".", ".."):
        return name
    return Path(name).name


def _piece_folders(folder: Path, kind: ResultKind) -> list[Path]:
    """What is named as folders of single pieces are, of which only some kinds of results have any.

    Errors of the disk are the caller's to report.
    """
    if not kind.file_format.startswith(("sherd assembly", "sherd fit")):
        return []
    return [path for path in folder.iterdir() if PIECE_FOLDER.fullmatch(path.name)]


def _in_piece_folders(folder: Path, kind: ResultKind) -> set[str]:
    """Files in folders of single pieces."""
    with reported(folder):
        return {
            f"{piece.name}/{path.name}"
            for piece in _piece_folders(folder, kind)
            for path in piece.iterdir()
            if path.name in NAMES
        }


def _refuse_obstacles(folder: Path, kind: ResultKind) -> None:
    """Refuse folders where a result has files, and files where it has folders of pieces.

    No result puts them there, and they would show only when all the work is done.
    """
    with reported(folder):
        pieces = _piece_folders(folder, kind)
        for piece in pieces:
            if not piece.is_dir():
                raise _in_the_way(piece, "a file where the result has a folder")
        paths = [path for each in (folder, *pieces) for path in each.iterdir()]
    for path in paths:
        if path.name in NAMES and path.is_dir():
            raise _in_the_way(path, "a folder where a result has a file")


def _in_the_way(path: Path, what: str) -> OutputError:
    return OutputError(f"{path}: is {what}; move it away or choose another folder")


def _taken(folder: Path, what: str) -> OutputError:
    return OutputError(
        f"{folder}: holds {what}; choose another folder or allow to replace it "
        "(--overwrite, in Python overwrite=True)"
    )


def _stored(folder: Path) -> tuple[ResultKind, tuple[str, ...]] | None:
    """Kind and files of the result in a folder; None if there is none of ours."""
    try:
        document = json.loads((folder / RESULT).read_text(encoding="utf-8"))
        kind = kind_of(document)
        files = [inside_name(name) for name in document["files"]]
    except (OSError, ValueError, KeyError, TypeError):
        return None
    if not kind.file_format.startswith("sherd "):
        return None
    kept = (name for name in files if (folder / name).is_file())
    return kind, tuple(kept)


class ResultFolder:
    """Files that belong together: all are staged first, then renamed, ``result.json`` last.

    ``result.json`` names every other file with its SHA-256, so a folder that holds files of two
    runs is recognized. Use as a context manager; leaving the block without :meth:`finish` removes
    what was staged, and the folder too if it was made here and is empty.

    Parameters
    ----------
    path
        The folder; made when missing.
    replaced
        Names of files of an older result there, see :func:`replaceable_files`: those that the new
        result does not have are removed.

    Raises
    ------
    OutputError
        From any method, if the disk refuses; what stood there before is untouched unless the
        disk fails between two renames, which the hashes reveal.
    """

    def __init__(self, path: str | os.PathLike[str], *, replaced: Iterable[str] = ()) -> None:
        self.path = Path(path)
        self._replaced = tuple(replaced)
        self._made: list[Path] = []
        self._inside: list[Path] = []
        self._staged: dict[str, Path] = {}
        self._hashes: dict[str, str] = {}

    def __enter__(self) -> Self:
        with reported(self.path):
            missing = [p for p in (self.path, *self.path.parents) if not p.exists()]
            self.path.mkdir(parents=True, exist_ok=True)
            self._made = missing
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for temporary in self._staged.values():
            with contextlib.suppress(OSError):
                temporary.unlink()
        for folder in (*self._inside, *self._made):
            with contextlib.suppress(OSError):
                folder.rmdir()  # fails, as it should, unless empty

    def add(self, name: str, content: bytes | str) -> None:
        """Stage one file, by its name or that of a piece's folder and its own; text is UTF-8."""
        data = content.encode("utf-8") if isinstance(content, str) else content
        target = self.path / inside_name(name)
        temporary = target.with_name(f".{target.name}-{secrets.token_hex(4)}.partial")
        if target.parent != self.path and not target.parent.exists():
            with reported(target):
                target.parent.mkdir()
            self._inside.append(target.parent)
        self._staged[name] = temporary
        self._hashes[name] = hashlib.sha256(data).hexdigest()
        with reported(self.path / name):
            _write_through(temporary, data)

    def finish(self, result: dict[str, Any]) -> dict[str, Any]:
        """Rename all staged files and write ``result.json``: `result` plus ``files``."""
        document = {**result, "files": dict(sorted(self._hashes.items()))}
        self.add(RESULT, json.dumps(document, indent=2, allow_nan=False) + "\n")
        for name, temporary in list(self._staged.items()):
            if name == RESULT:
                self._remove_leftovers()
            with reported(self.path / name):
                temporary.replace(self.path / name)
            del self._staged[name]
        return document

    def _remove_leftovers(self) -> None:
        for name in set(self._replaced) - set(self._hashes):
            with reported(self.path / name):
                (self.path / name).unlink(missing_ok=True)
        folders = {(self.path / name).parent for name in self._replaced} - {self.path}
        for folder in sorted(folders):
            with contextlib.suppress(OSError):
                folder.rmdir()  # fails, as it should, unless empty


def _write_through(path: Path, data: bytes) -> None:
    with path.open("wb") as stream:
        stream.write(data)
        stream.flush()
        os.fsync(stream.fileno())  # the bytes reach the disk before the name does
