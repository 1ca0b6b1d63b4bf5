"""BatchRun: what is known of the parts, what is left to do, and what is written meanwhile."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from pathlib import Path
from types import TracebackType
from typing import Self

from sherd.batching.engine import KILLED, finished_tasks
from sherd.batching.fingerprint import Fingerprint
from sherd.batching.gallery import write_gallery
from sherd.batching.journal import Journal, Outcome, known_outcomes
from sherd.batching.parts import Share
from sherd.batching.place import PARTS, remove_leftovers
from sherd.batching.progress import Progress
from sherd.batching.rows import FAILED, BatchRow
from sherd.batching.summary import Summary
from sherd.batching.task import MatchTask
from sherd.batching.work import failed, finished_outcome
from sherd.result_folder import RESULT

__all__ = ["BatchRun", "collected_rows"]


class BatchRun:
    """One run of a batch, or of one share; use as a context manager.

    Leaving the block writes what is known, whatever happened.

    Parameters
    ----------
    folder
        Of the batch, locked by this process.
    tasks
        All of the batch, in the order of the tables.
    share
        Which of them are ours. Another process may write the tables then, and we write none.
    tell
        Called with each of our rows.
    """

    def __init__(
        self,
        folder: Path,
        tasks: Sequence[MatchTask],
        share: Share | None,
        tell: Callable[[BatchRow], None] | None,
    ) -> None:
        self._folder, self._tell = folder, tell or (lambda _: None)
        mine = tasks if share is None else tasks[share.index - 1 :: share.count]
        self._names = [task.name for task in mine]
        self._rows: dict[str, BatchRow] = {}
        self.computed = 0
        self.waiting: list[MatchTask] = []
        remove_leftovers(folder)
        known = known_outcomes(folder)
        self._journal = Journal(folder)
        for task in mine:
            outcome = _still_true(task, known.get(task.name))
            if outcome is None:
                self.waiting.append(task)
            else:
                self._rows[task.name] = outcome.row
                self._tell(outcome.row)
        self._summary = None if share else Summary(folder, self._names, self._rows)
        self._progress = Progress(len(mine), list(self._rows.values()))

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._progress.close()
        self._journal.__exit__(kind, error, trace)
        remove_leftovers(self._folder)
        if self._summary is not None:
            self._summary.write()
            write_gallery(self._folder, self.rows_and_waiting()[0])

    def compute(
        self, work: Callable[[MatchTask], Outcome], executor: Executor, window: int
    ) -> None:
        """Do what is left.

        Raises
        ------
        SherdError
            If the executor as a whole is broken.
        OutputError
            If journal or tables cannot be written.
        """
        refresh = self._summary.refresh if self._summary else lambda: None
        for task, found in finished_tasks(
            self.waiting, work, executor, window=window, idle=refresh
        ):
            outcome = found if isinstance(found, Outcome) else _lost(task)
            self._journal.add(outcome)
            self._rows[task.name] = outcome.row
            self.computed += 1
            self._progress.add(outcome.row)
            self._tell(outcome.row)

    def rows_and_waiting(self) -> tuple[tuple[BatchRow, ...], tuple[str, ...]]:
        """What is known of our parts, and the names of the others."""
        known = tuple(self._rows[name] for name in self._names if name in self._rows)
        return known, tuple(name for name in self._names if name not in self._rows)


def collected_rows(folder: Path, names: Sequence[str]) -> dict[str, BatchRow]:
    """What any process has found out about these parts, by name.

    An answer counts only if its folder is there.
    """
    known = known_outcomes(folder)
    rows = {name: known[name].row for name in names if name in known}
    return {
        name: row
        for name, row in rows.items()
        if row.status == FAILED or (folder / PARTS / name / RESULT).exists()
    }


def _still_true(task: MatchTask, known: Outcome | None) -> Outcome | None:
    """What is known of a part, if it is about these very files, options and version."""
    part = None if known is None else known.part
    if part is None or not part.looks_like(task.file):
        if known is None and not task.target.exists():
            return None
        part = None
        with contextlib.suppress(OSError):
            part = Fingerprint.of(task.file)
    if part is None:
        return None
    if known is None or known.row.key != task.key(part.sha256):
        return finished_outcome(task, part)
    if known.row.status == FAILED:
        return known if known.row.finished else None
    whole = known.result is not None and known.result.still_of(task.target / RESULT)
    return known if whole else None


def _lost(task: MatchTask) -> Outcome:
    """The row of a part whose process ended without a word."""
    part = None
    with contextlib.suppress(OSError):
        part = Fingerprint.of(task.file)
    return failed(task, "killed", KILLED, part)
