"""Run the puzzles of a folder, going on where a run stopped, and say what was measured."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, Literal

import numpy as np

from sherd._version import __version__
from sherd.benchmark.puzzle.measurement import Measured, PuzzleRow, measured_puzzle
from sherd.benchmark.puzzle.sources import COUNTS, puzzle_sources
from sherd.benchmark.row_file import content_hash
from sherd.benchmark.runner import measured_rows
from sherd.limits import require_whole
from sherd.output import write_text
from sherd.report.stored.folder import plain

__all__ = ["puzzle_benchmark", "puzzle_table", "puzzle_totals"]

Way = Literal["together", "single"]
WAYS: tuple[Way, ...] = ("together", "single")


def puzzle_benchmark(
    directory: Path,
    output: Path,
    *,
    individuals: Path | None = None,
    only: tuple[str, ...] = (),
    counts: tuple[int, ...] = (),
    limit: int | None = None,
    jobs: int = 1,
) -> list[PuzzleRow]:
    """Put the puzzles of a folder together, and match each piece alone, the baseline.

    Writes ``puzzle.json`` after every puzzle, and goes on where an interrupted run stopped.

    Parameters
    ----------
    directory, individuals
        As in :func:`sherd.benchmark.puzzle.sources.puzzle_sources`.
    output
        Folder.
    only, counts, limit
        Names of puzzles, numbers of pieces (2, 4, 8 and 12 if not given), and how many puzzles.
    jobs
        Processes.

    Raises
    ------
    MeshFileError
        If a file is missing or damaged.
    OptionError
        If `limit`, `jobs` or a number of pieces is out of range.
    OutputError
        If the result cannot be written.
    """
    if limit is not None:
        require_whole("puzzles", limit, 1, 10**6, "no folder has more puzzles")
    puzzles = puzzle_sources(directory, individuals, counts=counts or COUNTS)
    sources = [source for source in puzzles if not only or source.name in only][:limit]
    path = output / "puzzle.json"
    inputs = content_hash(each for source in puzzles for each in (source.path, *source.others))
    question = {"version": __version__, "inputs": inputs}
    known = {row.puzzle: row for row in _stored(path, question)}

    def keep(name: str, row: PuzzleRow) -> None:
        known[name] = row
        _write(path, question, list(known.values()))

    return measured_rows(sources, measured_puzzle, known=dict(known), keep=keep, jobs=jobs)


def puzzle_totals(rows: Sequence[PuzzleRow], way: Way) -> dict[str, Any]:
    """Means over puzzles and pieces of one way; errors are of pieces that have a place."""
    found: list[Measured] = [getattr(row, way) for row in rows]
    errors = [error for each in found for error in each.errors if not math.isnan(error)]
    gaps = [each.gap_iou for each in found if not math.isnan(each.gap_iou)]
    own, foreign = sum(row.own for row in rows), sum(row.foreign for row in rows)
    refused = sum(each.foreign_refused for each in found)
    wrongly = sum(each.own_refused for each in found)
    return {
        "puzzles": len(rows),
        "labels": float(np.mean([each.labels for each in found])) if found else None,
        "error": float(np.mean(errors)) if errors else None,
        "bad": sum(each.bad for each in found),
        "own": own,
        "own_refused": wrongly,
        "foreign": foreign,
        "foreign_refused": refused,
        "refusal_f1": 2 * refused / (refused + wrongly + foreign) if foreign else None,
        "gap_iou": float(np.mean(gaps)) if gaps else None,
        "seconds": sum(each.seconds for each in found),
    }


def puzzle_table(rows: Sequence[PuzzleRow]) -> str:
    """The rows and totals as text; errors times 100."""
    width = max([len(row.puzzle) for row in rows], default=6) + 2
    head = "labels  error  bad  refused own/foreign  gap IoU  seconds"
    lines = [f"{'puzzle':<{width}}{head}   | single matches"]
    for row in rows:
        ways = (_row_words(row, getattr(row, way)) for way in WAYS)
        lines.append(f"{row.puzzle:<{width}}" + "   | ".join(ways))
    groups = sorted({row.group for row in rows})
    for group in [*groups, "together"]:
        some = [row for row in rows if group in (row.group, "together")]
        for way in WAYS:
            words = "assembled" if way == "together" else "single matches"
            lines.append(f"{group}, {words}: {_total_words(puzzle_totals(some, way))}")
    return "\n".join(lines)


def _row_words(row: PuzzleRow, found: Measured) -> str:
    known = [error for error in found.errors if not math.isnan(error)]
    error = _shown(float(np.mean(known)) if known else None, 2, 100)
    refused = f"{found.own_refused}/{row.own} {found.foreign_refused}/{row.foreign}"
    gap = _shown(None if math.isnan(found.gap_iou) else found.gap_iou, 3)
    return f"{found.labels:.4f}{error:>7}{found.bad:>5}{refused:>21}{gap:>9}{found.seconds:>9.1f}"


def _total_words(total: dict[str, Any]) -> str:
    return (
        f"{total['puzzles']} puzzles, labels {_shown(total['labels'], 4)}, error x100 "
        f"{_shown(total['error'], 2, 100)}, bad {total['bad']} and refused {total['own_refused']} "
        f"of {total['own']} own pieces, refused {total['foreign_refused']} of {total['foreign']} "
        f"foreign ones (F1 {_shown(total['refusal_f1'], 2)}), gap IoU "
        f"{_shown(total['gap_iou'], 3)}, {total['seconds']:.0f} s"
    )


def _shown(value: float | None, digits: int, factor: float = 1.0) -> str:
    return "-" if value is None else f"{factor * value:.{digits}f}"


def _write(path: Path, question: Mapping[str, str], rows: Sequence[PuzzleRow]) -> None:
    content = {
        **question,
        "totals": {way: puzzle_totals(rows, way) for way in WAYS},
        "rows": [asdict(row) for row in rows],
    }
    write_text(path, json.dumps(plain(content), indent=1, allow_nan=False) + "\n")


def _stored(path: Path, question: Mapping[str, str]) -> list[PuzzleRow]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        if any(content[name] != value for name, value in question.items()):
            return []
        return [
            PuzzleRow(**{**row, **{way: _measured(row[way]) for way in WAYS}})
            for row in content["rows"]
        ]
    except (OSError, ValueError, KeyError, TypeError):
        return []  # no file yet, or one of other files or another version


def _measured(stored: dict[str, Any]) -> Measured:
    errors = tuple(math.nan if error is None else error for error in stored["errors"])
    gap = math.nan if stored["gap_iou"] is None else stored["gap_iou"]
    return Measured(**{**stored, "errors": errors, "gap_iou": gap})
