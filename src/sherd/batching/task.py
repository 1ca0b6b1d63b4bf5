"""MatchTask: one question of a batch, small enough to be sent anywhere, and its hash."""

from __future__ import annotations

import hashlib
import json
import os
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Protocol

from sherd._version import __version__
from sherd.batching.ledger.place import PARTS
from sherd.batching.ledger.rows import BatchRow, Failure, Row
from sherd.batching.parts import BatchPart
from sherd.batching.templates import FullShape
from sherd.results.match_options import MatchOptions

__all__ = ["MatchTask", "Task", "question_hash"]


class Task(Protocol):
    """A question of a batch, small enough to be sent anywhere."""

    @property
    def name(self) -> str:
        """Unique among all tasks of a batch."""
        ...

    @property
    def files(self) -> tuple[Path, ...]:
        """What is read."""
        ...

    @property
    def target(self) -> Path:
        """Where the answer shall be."""
        ...

    @property
    def settings(self) -> str:
        """Hash of what all tasks of the batch have in common, so that tables never mix two."""
        ...

    @property
    def submitter(self) -> int:
        """Process that asks an executor of others: another one computes on one thread.

        0 for own workers, which know how many threads they have.
        """
        ...

    def key(self, contents: Sequence[str]) -> str:
        """Hash of all that the answer depends on; `contents` are those of its files."""
        ...

    def failed_row(self, failure: Failure, reason: str, key: str) -> Row:
        """The row if there is no answer."""
        ...


@dataclass(frozen=True)
class MatchTask:
    """A part, the full shapes that it may belong to, and how to ask.

    Attributes
    ----------
    part
        With its name.
    fulls
        Where it may belong.
    options
        Of the match.
    folder
        Of the batch.
    min_confidence
        Below it a vertex counts as unmatched.
    fit_scale
        Whether it is matched again at the size that the first answer has.
    exports
        Further files.
    overwrite
        Whether other files in the folder of the part may be replaced.
    home
        Folder that relative paths are meant from: another process may work elsewhere.
    settings
        Hash of what all tasks of the batch have in common.
    submitter
        Process that asks an executor of others: another one computes on one thread, as it has
        neighbors. 0 for own workers, which know how many threads they have.
    """

    part: BatchPart
    fulls: tuple[FullShape, ...]
    options: MatchOptions
    folder: Path
    min_confidence: float = 0.0
    fit_scale: bool = False
    exports: tuple[str, ...] = ()
    overwrite: bool = False
    home: Path = Path()
    settings: str = ""
    submitter: int = 0

    @property
    def name(self) -> str:
        """Of the part."""
        return self.part.name

    @property
    def files(self) -> tuple[Path, ...]:
        """What is read, beside the full shapes: the part's file."""
        return (self.home / self.part.path,)

    @property
    def target(self) -> Path:
        """Where the answer shall be."""
        return self.home / self.folder / PARTS / self.name

    def key(self, contents: Sequence[str]) -> str:
        """Hash of all that the answer depends on; `contents` are those of its files."""
        return question_hash(
            {
                "part": [self.part.path.name, *contents],
                "fulls": [[full.name, full.content] for full in self.fulls],
                "options": asdict(self.options),
                "min_confidence": self.min_confidence,
                "fit_scale": self.fit_scale,
                "exports": self.exports,
            }
        )

    def failed_row(self, failure: Failure, reason: str, key: str) -> BatchRow:
        """The row if there is no answer."""
        return BatchRow(
            name=self.name,
            part=os.fspath(self.part.path),
            full=self.fulls[0].name if len(self.fulls) == 1 else None,
            reason=reason,
            failure=failure,
            key=key,
        )

    def command(self, full: FullShape) -> str:
        """What to type to get the same answer alone."""
        options = self.options
        words = ["sherd", "match", full.source, os.fspath(self.part.path)]
        words += ["-o", os.fspath(self.folder / PARTS / self.name)]
        given: dict[str, Any] = {
            "--scale": None if options.scale == "same" else options.scale,
            "--part-unit": options.part_unit,
            "--full-unit": options.full_unit,
            "--side": None if options.side == "either" else options.side,
            "--min-confidence": self.min_confidence or None,
            "--seed": options.seed or None,
        }
        for word, value in given.items():
            if value is not None:
                words += [word, str(value)]
        words += ["--template", os.fspath(full.template)] if full.library else []
        words += ["--fit-scale"] if self.fit_scale else []
        for export in self.exports:
            words += ["--export", export]
        return shlex.join([*words, *self.part.words])


def question_hash(question: Mapping[str, Any]) -> str:
    """Of a question and this version of sherd."""
    text = json.dumps({**question, "version": __version__}, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()
