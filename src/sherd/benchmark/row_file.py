"""Rows of one class in a JSON file, with what they depend on, so that a later run can go on."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from sherd.output import write_text

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

__all__ = ["stored_rows", "write_rows"]

Row = TypeVar("Row", bound="DataclassInstance")


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
