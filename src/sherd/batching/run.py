"""BatchRun: what is known of the tasks, what is left to do, and what is written meanwhile."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Generic, Self, TypeVar

from sherd.batching.engine import KILLED, finished_tasks
from sherd.batching.guarded import failed, fingerprints, finished_outcome
from sherd.batching.ledger.journal import Journal, Outcome, known_outcomes
from sherd.batching.ledger.place import PARTS, remove_leftovers
from sherd.batching.ledger.rows import FAILED, Row
from sherd.batching.ledger.summary import Summary
from sherd.batching.progress import Progress
from sherd.batching.task import Task
from sherd.result_folder import RESULT

__all__ = ["BatchRun", "collected_rows"]

Any_Task = TypeVar("Any_Task", bound=Task)


class BatchRun(Generic[Any_Task]):
    """One run of a batch, or of one share; use as a context manager.

    Leaving the block writes the tables, whatever happened.

    Parameters
    ----------
    folder
        Of the batch, locked by this process.
    kind
        Of the rows.
    tasks
        Ours, in the order of the tables.
    tell
        Called with each of our rows.
    tables
        Whether to write them; of a share, whoever collects all does.
    """

    def __init__(
        self,
        folder: Path,
        kind: type[Row],
        tasks: Sequence[Any_Task],
        tell: Callable[[Row], None],
        *,
        tables: bool,
    ) -> None:
        self._folder, self._tell = folder, tell
        self._names = [task.name for task in tasks]
        self._rows: dict[str, Row] = {}
        self.computed = 0
        self.left: list[Any_Task] = []
        remove_leftovers(folder)
        known = known_outcomes(folder)
        self._journal = Journal(folder)
        for task in tasks:
            outcome = _still_true(task, known.get(task.name))
            if outcome is None:
                self.left.append(task)
                continue
            if outcome is not known.get(task.name) or outcome.settings != task.settings:
                # found in its folder, or the same question of another batch
                self._journal.add(replace(outcome, settings=task.settings))
            self._rows[task.name] = outcome.row
            self._tell(outcome.row)
        self._summary = Summary(folder, kind, self._names, self._rows) if tables else None
        self._progress = Progress(len(tasks), self.rows)

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

    @property
    def rows(self) -> list[Row]:
        """What is known, in the order of the tasks."""
        return [self._rows[name] for name in self._names if name in self._rows]

    @property
    def waiting(self) -> tuple[str, ...]:
        """Names of the tasks of which nothing is known."""
        return tuple(name for name in self._names if name not in self._rows)

    def compute(self, work: Callable[[Any_Task], Outcome], executor: Executor, window: int) -> None:
        """Do what is left.

        Raises
        ------
        SherdError
            If the executor as a whole is broken.
        OutputError
            If journal or tables cannot be written.
        """
        refresh = self._summary.refresh if self._summary else _nothing
        for task, found in finished_tasks(self.left, work, executor, window=window, idle=refresh):
            outcome = found if isinstance(found, Outcome) else _lost(task)
            self._journal.add(outcome)
            self._rows[task.name] = outcome.row
            self.computed += 1
            self._progress.add(outcome.row)
            self._tell(outcome.row)


def collected_rows(folder: Path, names: Sequence[str], settings: str) -> dict[str, Row]:
    """What any process has found out about these tasks with these settings, by name.

    An answer counts only if its folder is there.
    """
    known = {
        name: outcome
        for name, outcome in known_outcomes(folder).items()
        if outcome.settings == settings
    }
    rows = {name: known[name].row for name in names if name in known}
    return {
        name: row
        for name, row in rows.items()
        if row.status == FAILED or row.folder is None or _stands(folder / PARTS / name)
    }


def _stands(folder: Path) -> bool:
    return (folder / RESULT).exists()


def _still_true(task: Task, known: Outcome | None) -> Outcome | None:
    """What is known of a task, if it is about these very files, options and version."""
    inputs = () if known is None else known.inputs
    same = len(inputs) == len(task.files) and all(
        each.looks_like(file) for each, file in zip(inputs, task.files, strict=True)
    )
    if not same:
        if known is None and not task.target.exists():
            return None
        inputs = fingerprints(task.files)
        if not inputs:
            return None
    if known is None or known.row.key != task.key([each.sha256 for each in inputs]):
        return finished_outcome(task, inputs)
    if known.row.folder is None:  # a failure, or an answer that needs no folder
        return known if known.row.finished else None
    whole = known.result is not None and known.result.still_of(task.target / RESULT)
    return known if whole else None


def _lost(task: Task) -> Outcome:
    """The row of a task whose process ended without a word."""
    return failed(task, "killed", KILLED, fingerprints(task.files))


def _nothing() -> None:
    """There are no tables to refresh."""
