"""BatchPart: the parts of a batch and their names, from a folder, a pattern or a list."""

from __future__ import annotations

import glob
import os
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias, TypeVar

from sherd.errors import InputError

__all__ = ["BatchPart", "PartSource", "Share", "batch_parts", "shared_list"]

Listed = TypeVar("Listed")

# What read_mesh and read_points read.
SUFFIXES = (".off", ".obj", ".ply", ".stl", ".glb", ".xyz")
WILDCARDS = "*?["


@dataclass(frozen=True)
class BatchPart:
    """A part of a batch.

    Attributes
    ----------
    path
        Its file.
    name
        Of its folder and row; made from the file's name if empty.
    full
        Name of the full shape that it belongs to, where that is known; else each is tried.
    landmarks
        Pairs (vertex of the part, vertex of the full shape); `full` must be known.
    ignore
        Vertices of the part to leave out.

    Examples
    --------
    >>> BatchPart("scans/leg.ply").path.name
    'leg.ply'
    """

    path: Path
    name: str = ""
    full: str | None = None
    landmarks: tuple[tuple[int, int], ...] = ()
    ignore: tuple[int, ...] = ()
    words: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "path", Path(self.path))


PartSource: TypeAlias = str | os.PathLike[str] | Iterable["str | os.PathLike[str] | BatchPart"]


def batch_parts(source: PartSource) -> tuple[BatchPart, ...]:
    """The parts with their names, in the order of the names.

    Parameters
    ----------
    source
        A folder (all shapes in it, and in folders in it), a pattern such as ``"scans/*.ply"``, a
        file, or a sequence of files and :class:`BatchPart`.

    Raises
    ------
    InputError
        If there are none, or two parts have one name.
    """
    if isinstance(source, str | os.PathLike):
        root, files = _found(os.fspath(source))
        parts = [BatchPart(file) for file in files]
    else:
        parts = [each if isinstance(each, BatchPart) else BatchPart(Path(each)) for each in source]
        root = _common_folder(parts)
    if not parts:
        raise InputError("no parts were given")
    stems = [part.name or _name(part.path, root, suffix=False) for part in parts]
    counts = Counter(stems)
    named = [
        part
        if part.name
        else replace(part, name=stem if counts[stem] == 1 else _name(part.path, root, suffix=True))
        for part, stem in zip(parts, stems, strict=True)
    ]
    _check_names(named)
    return tuple(sorted(named, key=lambda part: part.name))


@dataclass(frozen=True)
class Share:
    """The `index`-th of `count` shares, from 1: every `count`-th part in the order of the names.

    Raises
    ------
    InputError
        If there is no such share.

    Examples
    --------
    >>> Share(2, 3)
    Share(index=2, count=3)
    """

    index: int
    count: int

    def __post_init__(self) -> None:
        if not 1 <= self.index <= self.count:
            raise InputError(
                f"shard {self.index}/{self.count} does not exist: shards of {self.count} are "
                f"1/{self.count} to {self.count}/{self.count}"
            )

    @classmethod
    def from_text(cls, text: str) -> Share:
        """``"2/3"``.

        Raises
        ------
        InputError
            If it is none.
        """
        index, slash, count = text.partition("/")
        if not (slash and index.isdecimal() and count.isdecimal()):
            raise InputError(f"shard {text!r} is none; write it as 1/10, the first of ten")
        return cls(int(index), int(count))


def shared_list(listed: Sequence[Listed], share: Share | None) -> list[Listed]:
    """What belongs to one share of a list; all if there is none.

    Parts of similar names are often of similar size, so neighbors go to different shares. The rule
    needs no talk between them, but all must see the same list.
    """
    return list(listed) if share is None else list(listed[share.index - 1 :: share.count])


def _found(text: str) -> tuple[Path, list[Path]]:
    """The folder that names begin in, and the files."""
    path = Path(text)
    if path.is_dir():
        found = sorted(path.rglob("*"))
        files = [p for p in found if p.suffix.lower() in SUFFIXES and not p.name.startswith(".")]
        if not files:
            raise InputError(f"{path}: holds no {', '.join(SUFFIXES)} file")
        return path, [file for file in files if file.is_file()]
    if path.is_file():
        return path.parent, [path]
    if any(sign in text for sign in WILDCARDS):
        files = [Path(name) for name in sorted(glob.glob(text, recursive=True))]  # noqa: PTH207
        files = [file for file in files if file.is_file()]
        if not files:
            raise InputError(f"{text}: no file has such a name; quote the pattern and check it")
        return _common_folder([BatchPart(file) for file in files]), files
    raise InputError(f"{text}: no such folder or file; check the path")


def _common_folder(parts: Sequence[BatchPart]) -> Path:
    folders = {os.fspath(part.path.parent) for part in parts}
    try:
        return Path(os.path.commonpath(folders)) if folders else Path()
    except ValueError:  # absolute and relative ones
        return Path()


def _name(path: Path, root: Path, *, suffix: bool) -> str:
    """The path inside the root as one word: ``arm/left.ply`` is ``arm__left``."""
    inside = path.relative_to(root) if path.is_relative_to(root) else Path(path.name)
    words = [word for word in inside.parts if word not in (os.sep, "..")]
    last = words[-1] if suffix else Path(words[-1]).stem
    return "__".join((*words[:-1], last))


def _check_names(parts: Sequence[BatchPart]) -> None:
    seen: dict[str, BatchPart] = {}
    for part in parts:
        word = part.name
        if not word or word.startswith(".") or Path(word).name != word or "\\" in word:
            raise InputError(f"{part.path}: {word!r} can be no name of a folder; name it otherwise")
        if word in seen:
            raise InputError(
                f"{seen[word].path} and {part.path} would both be called {word}; rename one"
            )
        seen[word] = part
