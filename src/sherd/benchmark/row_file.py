"""What an interrupted run has measured, with what it depends on, so that a later run can go on."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from sherd._version import __version__
from sherd.output import write_text
from sherd.report.stored.folder import plain

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

__all__ = [
    "KeptPair", "content_hash", "pair_file", "plain_row", "restored_row", "stored_rows",
    "write_rows",
]  # fmt: skip

Row = TypeVar("Row", bound="DataclassInstance")


class KeptPair(Protocol):
    """A pair of a data set."""

    @property
    def name(self) -> str:
        """Unique among all pairs."""
        ...

    @property
    def kind(self) -> str:
        """What sort of pair it is."""
        ...

    @property
    def inputs(self) -> tuple[Path, ...]:
        """Files that the pair is made of."""
        ...


def pair_file(output: Path, pair: KeptPair, settings: DataclassInstance) -> Path:
    """Where the row of a pair is kept: a hash of everything that the measurement depends on."""
    content = hashlib.sha256()
    question = {**asdict(settings), "kind": pair.kind, "version": __version__, "pair": pair.name}
    content.update(json.dumps(question, sort_keys=True).encode())
    for path in pair.inputs:
        content.update(path.read_bytes() if path.exists() else b"")
    return output / "pairs" / f"{content.hexdigest()[:24]}.json"


def content_hash(paths: Iterable[Path]) -> str:
    """A hash of what files and folders hold, and of their names, so that rows of others differ."""
    digest = hashlib.sha256()
    for path in sorted(set(paths)):
        files = sorted(path.iterdir()) if path.is_dir() else [path]
        for file in files:
            digest.update(f"{file.name}\0".encode())
            digest.update(hashlib.sha256(file.read_bytes()).digest() if file.is_file() else b"")
    return digest.hexdigest()[:24]


def plain_row(row: DataclassInstance) -> dict[str, Any]:
    """Names and values of a row for JSON; NaN becomes None."""
    values: dict[str, Any] = plain(asdict(row))
    return values


def restored_row(kind: type[Row], content: Mapping[str, Any]) -> Row:
    """The row that :func:`plain_row` gave the names and values of.

    Raises
    ------
    TypeError
        If a name is missing or unknown.
    """
    return kind(**{name: math.nan if value is None else value for name, value in content.items()})


def stored_rows(path: Path, settings: Mapping[str, Any], row: type[Row]) -> list[Row]:
    """The rows that an earlier run wrote with the same settings; none if there are no such."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        if any(content[name] != value for name, value in settings.items()):
            return []
        return [row(**values) for values in content["rows"]]
    except (OSError, ValueError, KeyError, TypeError):
        return []  # no file yet, or one of another version


def write_rows(path: Path, settings: Mapping[str, Any], rows: Iterable[Row]) -> None:
    """Write settings and, as ``"rows"``, a dictionary for each row; atomically.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    content = {**settings, "rows": [asdict(row) for row in rows]}
    write_text(path, json.dumps(content, indent=2) + "\n")
