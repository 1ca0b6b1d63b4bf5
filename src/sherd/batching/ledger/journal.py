"""Journal: what became of each part, a line at a time, so that a later run can go on.

Each process has a file of its own, so any number of them may write to one folder. A line that was
torn by the end of its process is passed over: its part is looked for in its folder, or asked again.
"""

from __future__ import annotations

import contextlib
import json
import os
import secrets
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self, TextIO

from sherd.batching.ledger.fingerprint import Fingerprint
from sherd.batching.ledger.place import HOST
from sherd.batching.ledger.rows import Row, row_of
from sherd.output import reported

__all__ = ["JOURNALS", "Journal", "Outcome", "known_outcomes", "outcome_text", "stored_outcome"]

JOURNALS = "journal"


@dataclass(frozen=True)
class Outcome:
    """What became of a task.

    Attributes
    ----------
    row
        For the tables.
    inputs
        The files that it is about, as they were read.
    result
        The ``result.json`` that was written.
    settings
        Hash of what all tasks of the batch have in common.
    """

    row: Row
    inputs: tuple[Fingerprint, ...] = ()
    result: Fingerprint | None = None
    settings: str = ""


class Journal:
    """Lines of outcomes in a file of this process; use as a context manager.

    Parameters
    ----------
    folder
        Of the batch.

    Raises
    ------
    OutputError
        From any method, if the disk refuses.
    """

    def __init__(self, folder: Path) -> None:
        name = f"{HOST}-{os.getpid()}-{secrets.token_hex(4)}.jsonl"
        self.path = folder / JOURNALS / name
        self._stream: TextIO | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._stream is not None:
            with contextlib.suppress(OSError):
                self._stream.close()

    def add(self, outcome: Outcome) -> None:
        """Append one line, and leave it to the system: a killed process loses nothing."""
        with reported(self.path):
            if self._stream is None:
                self.path.parent.mkdir(parents=True, exist_ok=True)
                self._stream = self.path.open("a", encoding="utf-8", newline="\n")
            self._stream.write(outcome_text(outcome) + "\n")
            self._stream.flush()


def known_outcomes(folder: Path) -> dict[str, Outcome]:
    """The newest outcome of each part, by name, of all processes that ever wrote here.

    A row with an answer is never hidden by one without of the same question.
    """
    found: dict[str, Outcome] = {}
    for path in sorted((folder / JOURNALS).glob("*.jsonl"), key=_age):
        for outcome in _outcomes(path):
            older = found.get(outcome.row.name)
            if older and older.row.finished and not outcome.row.finished:
                same = older.row.key == outcome.row.key
                if same or not outcome.row.key:
                    continue
            found[outcome.row.name] = outcome
    return found


def outcome_text(outcome: Outcome) -> str:
    """One line of JSON."""
    return json.dumps(asdict(outcome), allow_nan=False, separators=(",", ":"))


def stored_outcome(text: str) -> Outcome | None:
    """What :func:`outcome_text` wrote; None if it is torn or of another version."""
    try:
        values: dict[str, Any] = json.loads(text)
        inputs = tuple(Fingerprint(**each) for each in values["inputs"])
        result = None if values["result"] is None else Fingerprint(**values["result"])
        return Outcome(row_of(values["row"]), inputs, result, values["settings"])
    except (ValueError, KeyError, TypeError):
        return None


def _outcomes(path: Path) -> Iterator[Outcome]:
    with contextlib.suppress(OSError):
        # a torn line may end inside a character
        for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
            outcome = stored_outcome(line)
            if outcome is not None:
                yield outcome


def _age(path: Path) -> tuple[int, str]:
    try:
        return path.stat().st_mtime_ns, path.name
    except OSError:
        return 0, path.name
