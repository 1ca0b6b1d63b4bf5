"""Independent questions measured one after the other, or in several processes."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from sherd._version import __version__
from sherd.batching.processes import process_pool
from sherd.benchmark.row_file import (
    KeptPair,
    content_hash,
    pair_file,
    plain_row,
    restored_row,
    stored_rows,
    write_rows,
)
from sherd.limits import require_whole
from sherd.output import Stages, write_text

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

__all__ = [
    "Question", "chosen_pairs", "measured_and_kept", "measured_pairs", "measured_rows",
]  # fmt: skip


class Question(Protocol):
    """Something to measure that does not depend on other questions."""

    @property
    def name(self) -> str:
        """Unique among all questions."""
        ...


Asked = TypeVar("Asked", bound=Question)
AskedPair = TypeVar("AskedPair", bound=KeptPair)
Row = TypeVar("Row")
Kept = TypeVar("Kept", bound="DataclassInstance")


def measured_rows(
    questions: Sequence[Asked],
    measure: Callable[[Asked], Row],
    *,
    known: Mapping[str, Row],
    keep: Callable[[str, Row], None],
    jobs: int = 1,
) -> list[Row]:
    """The row of each question, in order; what is known is not measured again.

    Parameters
    ----------
    questions
        Measured in this order.
    measure
        Gives the row of a question. With several processes it must be picklable, as must questions
        and rows.
    known
        Rows of an earlier run, by name of the question.
    keep
        Told name and row as soon as it is measured, so that it can be stored.
    jobs
        Processes. They share the cores: each runs on one thread.

    Raises
    ------
    OptionError
        If `jobs` is below 1, or far above the number of cores.
    """
    reason = "each process takes some 500 MB, and more of them than cores gain nothing"
    require_whole("jobs", jobs, 1, max(16, os.cpu_count() or 1), reason)
    rows = dict(known)
    waiting = [question for question in questions if question.name not in rows]
    stages = Stages(len(waiting))
    answers = _one_by_one(waiting, measure, jobs)
    for question in waiting:
        with stages(question.name):
            rows[question.name] = next(answers)
            keep(question.name, rows[question.name])
    stages.close()
    return [rows[question.name] for question in questions]


def measured_and_kept(
    questions: Sequence[Asked],
    measure: Callable[[Asked], Kept],
    *,
    kind: type[Kept],
    name: Callable[[Kept], str],
    path: Path,
    inputs: Iterable[Path],
    settings: Mapping[str, Any] | None = None,
    jobs: int = 1,
) -> list[Kept]:
    """The row of each question, kept in one file from which an interrupted run goes on.

    Parameters
    ----------
    questions, measure, jobs
        As of :func:`measured_rows`.
    kind, name
        The type of the rows, and the name of the question that a row is of.
    path
        The file.
    inputs
        Files and folders that the rows depend on: of others they are measured anew.
    settings
        What else they depend on.

    Raises
    ------
    OptionError
        As :func:`measured_rows`.
    OutputError
        If the file cannot be written.
    """
    question = {"version": __version__, **(settings or {}), "inputs": content_hash(inputs)}
    known = {name(row): row for row in stored_rows(path, question, kind)}

    def keep(of: str, row: Kept) -> None:
        known[of] = row
        write_rows(path, question, known.values())

    return measured_rows(questions, measure, known=dict(known), keep=keep, jobs=jobs)


def measured_pairs(
    pairs: Sequence[AskedPair],
    measure: Callable[[AskedPair], Kept],
    *,
    kind: type[Kept],
    output: Path,
    settings: DataclassInstance,
    jobs: int = 1,
) -> list[Kept]:
    """The row of each pair of a data set, kept in one small file each under `output/pairs`.

    A file is named by a hash of what its pair is made of, the version and the settings, so that an
    interrupted run goes on where it stopped, and what has changed is measured anew.

    Parameters
    ----------
    pairs, measure, jobs
        As of :func:`measured_rows`.
    kind
        The type of the rows.
    output
        Folder.
    settings
        How pairs are shown.

    Raises
    ------
    OptionError
        As :func:`measured_rows`.
    OutputError
        If a row cannot be written.
    """
    files = {pair.name: pair_file(output, pair, settings) for pair in pairs}
    known = {}
    for name, path in files.items():
        # not measured yet, or written by another version
        with suppress(OSError, ValueError, TypeError, AttributeError):
            known[name] = restored_row(kind, json.loads(path.read_text(encoding="utf-8")))

    def keep(name: str, row: Kept) -> None:
        write_text(files[name], json.dumps(plain_row(row), allow_nan=False) + "\n")

    return measured_rows(pairs, measure, known=known, keep=keep, jobs=jobs)


def chosen_pairs(
    pairs: Iterable[AskedPair], only: Collection[str], limit: int | None
) -> list[AskedPair]:
    """Those named in `only`, all if none is, and of them the first `limit`.

    Raises
    ------
    OptionError
        If `limit` is below 1.
    """
    if limit is not None:
        require_whole("pairs", limit, 1, 10**6, "no data set has more pairs")
    return [pair for pair in pairs if not only or pair.name in only][:limit]


def _one_by_one(
    questions: Sequence[Asked], measure: Callable[[Asked], Row], jobs: int
) -> Iterator[Row]:
    if jobs == 1 or len(questions) < 2:
        yield from map(measure, questions)
        return
    with process_pool(jobs) as pool:
        yield from pool.map(measure, questions)
