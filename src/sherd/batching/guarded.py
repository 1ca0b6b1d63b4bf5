"""guarded: one task computed by whichever process is asked to, without ever raising.

Whatever goes wrong with one task is its row, so that the others go on.
"""

from __future__ import annotations

import contextlib
import os
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from sherd.batching.ledger.fingerprint import Fingerprint
from sherd.batching.ledger.journal import Outcome, outcome_text, stored_outcome
from sherd.batching.ledger.place import OUTCOME, move_into_place
from sherd.batching.ledger.rows import Failure, Row
from sherd.batching.task import Task
from sherd.errors import InputError, OutputError, SherdError
from sherd.result_folder import RESULT
from sherd.threads import set_thread_count

__all__ = ["failed", "fingerprints", "finish", "finished_outcome", "guarded", "with_cost"]

Any_Task = TypeVar("Any_Task", bound=Task)
Inputs = tuple[Fingerprint, ...]


def guarded(task: Any_Task, compute: Callable[[Any_Task, Inputs], Outcome]) -> Outcome:
    """What stands in the folder of the task, if it answers it; else what `compute` makes of it."""
    if task.submitter not in (0, os.getpid()):
        set_thread_count(1)
    start = time.perf_counter()
    read: Inputs = ()
    try:
        read = tuple(Fingerprint.of(file) for file in task.files)
        return finished_outcome(task, read) or compute(task, read)
    except MemoryError:
        outcome = failed(task, "memory", "not enough memory; decimate the mesh", read)
    except OutputError as error:
        outcome = failed(task, "not written", str(error), read)
    except SherdError as error:
        outcome = failed(task, "refused", str(error), read)
    except OSError as error:
        name = error.filename or task.name
        reason = f"{name}: cannot be read ({error.strerror or error}); check the path"
        outcome = failed(task, "unreadable", reason, read)
    except Exception as error:
        said = f"internal error: {type(error).__name__}: {error}; please report it"
        outcome = failed(task, "internal", said, read)
    return replace(outcome, row=with_cost(outcome.row, start))


def fingerprints(files: Sequence[Path]) -> Inputs:
    """Of all files; none if one cannot be read."""
    with contextlib.suppress(OSError):
        return tuple(Fingerprint.of(file) for file in files)
    return ()


def finished_outcome(task: Task, inputs: Inputs) -> Outcome | None:
    """What stands in the folder of the task, if it answers this very question and is whole."""
    try:
        outcome = stored_outcome((task.target / OUTCOME).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    key = task.key([each.sha256 for each in inputs])
    if outcome is None or outcome.result is None or outcome.row.key != key:
        return None
    return outcome if outcome.result.still_of(task.target / RESULT) else None


def failed(task: Task, failure: Failure, reason: str, inputs: Inputs = ()) -> Outcome:
    """The row of a task that has no answer."""
    key = task.key([each.sha256 for each in inputs]) if inputs else ""
    row = task.failed_row(failure, " ".join(reason.split()), key)
    return Outcome(row, inputs, settings=task.settings)


def finish(task: Task, inputs: Inputs, row: Row, folder: Path) -> Outcome:
    """Give the folder that holds the answer its name, with the row and its key inside.

    Raises
    ------
    InputError
        If an input was changed meanwhile.
    OutputError
        If the disk refuses.
    """
    for file, read in zip(task.files, inputs, strict=True):
        if not read.still_of(file):
            raise InputError(f"{file}: was changed while it was read; start again")
    row = replace(row, key=task.key([each.sha256 for each in inputs]))
    outcome = Outcome(row, inputs, Fingerprint.of(folder / RESULT), task.settings)
    (folder / OUTCOME).write_text(outcome_text(outcome) + "\n", encoding="utf-8")
    move_into_place(folder, task.target)
    return outcome


def with_cost(row: Row, start: float) -> Row:
    """The row with the seconds since `start` and what this process held at most."""
    cost: dict[str, Any] = {"seconds": round(time.perf_counter() - start, 3)}
    return replace(row, **cost, memory=_peak_memory())


def _peak_memory() -> int | None:
    """The most that this process ever held, in bytes."""
    try:
        import resource  # not on every system  # noqa: PLC0415
    except ImportError:
        return None
    unit = 1 if sys.platform == "darwin" else 1024
    return unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
