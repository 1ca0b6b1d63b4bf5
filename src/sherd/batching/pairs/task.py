"""PairTask: two shapes of a collection; cheap evidence first, then what they share."""

from __future__ import annotations

import os
import shlex
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from sherd.batching.ledger.place import PARTS
from sherd.batching.ledger.rows import Failure, PairRow
from sherd.batching.parts import BatchPart
from sherd.batching.task import question_hash
from sherd.results.overlap_options import OverlapOptions

__all__ = ["PairTask", "pair_name"]


def pair_name(first: str, second: str) -> str:
    """Of the pair of two shapes, and of its folder."""
    return f"{first}--{second}"


@dataclass(frozen=True)
class PairTask:
    """Two shapes of a collection.

    Attributes
    ----------
    first, second
        With their names.
    options
        Of the overlap.
    folder, exports, overwrite, home, settings, submitter
        As of a :class:`sherd.batching.task.MatchTask`.
    """

    first: BatchPart
    second: BatchPart
    options: OverlapOptions
    folder: Path
    exports: tuple[str, ...] = ()
    overwrite: bool = False
    home: Path = Path()
    settings: str = ""
    submitter: int = 0

    @property
    def name(self) -> str:
        """Of the pair."""
        return pair_name(self.first.name, self.second.name)

    @property
    def files(self) -> tuple[Path, ...]:
        """Of both shapes."""
        return (self.home / self.first.path, self.home / self.second.path)

    @property
    def target(self) -> Path:
        """Where the answer shall be."""
        return self.home / self.folder / PARTS / self.name

    def key(self, contents: Sequence[str]) -> str:
        """Hash of all that the answer depends on; `contents` are those of both files."""
        return question_hash(
            {
                "first": [self.first.path.name, contents[0]],
                "second": [self.second.path.name, contents[1]],
                "options": asdict(self.options),
                "exports": self.exports,
            }
        )

    def failed_row(self, failure: Failure, reason: str, key: str) -> PairRow:
        """The row if there is no answer."""
        first, second = os.fspath(self.first.path), os.fspath(self.second.path)
        return PairRow(self.name, first, second, reason=reason, failure=failure, key=key)

    def command(self) -> str:
        """What to type to get the same answer alone."""
        words = ["sherd", "overlap", os.fspath(self.first.path), os.fspath(self.second.path)]
        words += ["-o", os.fspath(self.folder / PARTS / self.name)]
        if self.options.scale != "same":
            words += ["--scale", str(self.options.scale)]
        if self.options.seed:
            words += ["--seed", str(self.options.seed)]
        for export in self.exports:
            words += ["--export", export]
        return shlex.join(words)
