"""A table of parts: which file, what it is called, where it belongs, what is known of it."""

from __future__ import annotations

from pathlib import Path

from sherd.batching.parts import BatchPart
from sherd.cli.tables import columns_of, read_ignored, read_landmarks
from sherd.errors import InputError

__all__ = ["parts_of_table"]

COLUMNS = ("part", "name", "full", "landmarks", "ignore")


def parts_of_table(path: Path) -> list[BatchPart]:
    """The parts that a CSV file names, a row each; paths in it are relative to its folder.

    Columns: ``part`` (a file), and as you like ``name``, ``full`` (the file of the full shape that
    it belongs to, by its name), ``landmarks`` and ``ignore`` (files as of ``sherd match``).

    Raises
    ------
    InputError
        If the table, or a file that it names, cannot be read or lacks a column.
    """
    columns = columns_of(path)
    unknown = sorted(set(columns) - set(COLUMNS))
    if "part" not in columns or unknown:
        what = f"has a column {unknown[0]!r}" if unknown else "has no column 'part'"
        raise InputError(f"{path}: {what}; columns of a table of parts are {', '.join(COLUMNS)}")
    rows = [
        dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)
    ]
    return [_part(path, number, row) for number, row in enumerate(rows, start=2)]


def _part(table: Path, number: int, row: dict[str, str]) -> BatchPart:
    if not row["part"]:
        raise InputError(f"{table}: row {number} names no part")
    folder = table.parent
    landmarks: tuple[tuple[int, int], ...] = ()
    ignore: tuple[int, ...] = ()
    words: list[str] = []
    if row.get("landmarks"):
        on_part, on_full = read_landmarks(folder / row["landmarks"])
        landmarks = tuple(zip(on_part.tolist(), on_full.tolist(), strict=True))
        words += ["--landmarks", str(folder / row["landmarks"])]
    if row.get("ignore"):
        ignore = tuple(read_ignored(folder / row["ignore"]).tolist())
        words += ["--ignore", str(folder / row["ignore"])]
    return BatchPart(
        folder / row["part"],
        name=row.get("name", ""),
        full=row.get("full") or None,
        landmarks=landmarks,
        ignore=ignore,
        words=tuple(words),
    )
