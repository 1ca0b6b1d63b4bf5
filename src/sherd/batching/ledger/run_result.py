"""RunResult: what a batch of parts and a comparison of all pairs have to say alike."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

from sherd.batching.ledger.rows import FAILED, BatchRow, PairRow, count_words

__all__ = ["RunResult"]

Kind = TypeVar("Kind", BatchRow, PairRow)


@dataclass(frozen=True, repr=False)
class RunResult(Generic[Kind]):
    """What became of the questions of a run; see its kinds for the fields."""

    folder: Path
    rows: tuple[Kind, ...]
    waiting: tuple[str, ...]
    computed: int

    def __repr__(self) -> str:
        return f"{type(self).__name__}({os.fspath(self.folder)!r}: {self.words})"

    @property
    def words(self) -> str:
        """How many of each status."""
        return count_words(self.rows, waiting=len(self.waiting))

    @property
    def all_answered(self) -> bool:
        """Whether every question has an answer, good or not; that nothing is shared is one."""
        return not self.waiting and all(row.status != FAILED for row in self.rows)
