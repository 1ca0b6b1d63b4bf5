"""BatchRow: what a batch says of one part, and the tables of all of them."""

from __future__ import annotations

import csv
import io
import json
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, Literal, TypeAlias

from sherd._version import __version__
from sherd.output import write_text

__all__ = [
    "FAILED",
    "LASTING",
    "STATUSES",
    "SUMMARY_FORMAT",
    "BatchRow",
    "Failure",
    "PairRow",
    "Row",
    "count_words",
    "row_of",
    "write_summary",
]

# Of summary.json; raise the number when a field changes its meaning.
SUMMARY_FORMAT = "sherd batch 1"
FAILED = "failed"
STATUSES = ("good", "doubtful", "foreign", FAILED)

Failure: TypeAlias = Literal["refused", "internal", "memory", "killed", "not written", "unreadable"]
# The same files, options and version would fail in the same way; others may do better next time.
LASTING: tuple[Failure, ...] = ("refused", "internal")


@dataclass(frozen=True, repr=False)
class BatchRow:
    """What a batch says of one part; None is unknown.

    Attributes
    ----------
    name
        Of the part within the batch, and of its folder.
    part, full
        Their files; of the full shape that the part was matched with.
    status
        ``"good"``, ``"doubtful"``, ``"foreign"``, or ``"failed"``: there is no answer.
    reason
        The advice of the answer, or why there is none.
    failure
        Sort of failure: ``"refused"`` (the file or the question), ``"memory"``, ``"killed"``,
        ``"not written"``, ``"unreadable"`` (the file, now), ``"internal"``.
    chance
        That the placement as a whole is right.
    error_estimate
        Expected share of the matched vertices whose point is farther than 0.05 sqrt(area of the
        full shape) from the truth: 1 minus their mean confidence.
    area_fraction, unmatched, mean_confidence, score, scale
        As in ``result.json``.
    seconds, memory
        Of the computation; the most that its process ever held, in bytes.
    folder
        Of the answer, inside that of the batch.
    key
        Hash of everything that the answer depends on.

    Examples
    --------
    >>> BatchRow("leg", "leg.ply", status="failed", reason="no such file").finished
    False
    """

    name: str
    part: str
    full: str | None = None
    status: str = FAILED
    reason: str = ""
    failure: Failure | None = None
    chance: float | None = None
    error_estimate: float | None = None
    area_fraction: float | None = None
    unmatched: int | None = None
    mean_confidence: float | None = None
    score: float | None = None
    scale: float | None = None
    seconds: float | None = None
    memory: int | None = None
    folder: str | None = None
    key: str = ""

    def __repr__(self) -> str:
        full = "" if self.full is None else f" on {self.full!r}"
        return f"BatchRow({self.name!r}{full}: {_outcome_words(self)})"

    @property
    def finished(self) -> bool:
        """Whether the same question would be answered in the same way again."""
        return self.status != FAILED or self.failure in LASTING


@dataclass(frozen=True, repr=False)
class PairRow:
    """What is said of one pair of a collection; None is unknown.

    Attributes
    ----------
    name
        Of the pair, and of its folder.
    first, second
        Files of the shapes.
    status, reason, failure, seconds, memory, folder, key
        As of a :class:`BatchRow`; ``"foreign"``: nothing is shared.
    likeness
        Share in [0, 1] of a few dozen points of each that have a like on the other, consistently.
    asked
        Whether that was enough for the full question; else the rest is unknown.
    chance
        That what is shared is right.
    shared_of_first, shared_of_second
        Share of each one's area that the other has too.

    Examples
    --------
    >>> PairRow("a--b", "a.ply", "b.ply", status="foreign", likeness=0.2).finished
    True
    """

    name: str
    first: str
    second: str
    status: str = FAILED
    reason: str = ""
    failure: Failure | None = None
    likeness: float | None = None
    asked: bool = False
    chance: float | None = None
    shared_of_first: float | None = None
    shared_of_second: float | None = None
    seconds: float | None = None
    memory: int | None = None
    folder: str | None = None
    key: str = ""

    def __repr__(self) -> str:
        return f"PairRow({self.first!r}, {self.second!r}: {_outcome_words(self)})"

    @property
    def finished(self) -> bool:
        """Whether the same question would be answered in the same way again."""
        return self.status != FAILED or self.failure in LASTING


Row: TypeAlias = BatchRow | PairRow


def _outcome_words(row: Row) -> str:
    if row.status == FAILED:
        return f"failed, {row.reason[:60]}"
    return row.status if row.chance is None else f"{row.status}, chance {row.chance:.2f}"


def row_of(values: Mapping[str, Any]) -> Row:
    """A row from what was stored of it.

    Raises
    ------
    TypeError
        If it is none.
    """
    return PairRow(**values) if "first" in values else BatchRow(**values)


def count_words(rows: Iterable[Row], *, waiting: int = 0) -> str:
    """How many rows of each status, in words.

    Examples
    --------
    >>> count_words([BatchRow("a", "a.ply", status="good"), BatchRow("b", "b.ply")])
    '1 good, 1 failed'
    """
    counts = Counter(row.status for row in rows)
    said = [f"{counts[status]} {status}" for status in STATUSES if counts[status]]
    if waiting:
        said.append(f"{waiting} waiting")
    return ", ".join(said) or "none"


def write_summary(
    folder: Path, kind: type[Row], rows: Sequence[Row], waiting: Sequence[str]
) -> None:
    """Write ``summary.csv`` and ``summary.json`` of rows of one kind, each atomically.

    Raises
    ------
    OutputError
        If they cannot be written.
    """
    names = [each.name for each in fields(kind)]
    stream = io.StringIO()
    table = csv.DictWriter(stream, names, lineterminator="\n")
    table.writeheader()
    dictionaries = [asdict(row) for row in rows]
    table.writerows(dictionaries)
    write_text(folder / "summary.csv", stream.getvalue())
    counts = Counter(row.status for row in rows)
    document = {
        "format": SUMMARY_FORMAT,
        "version": __version__,
        "counts": {status: counts[status] for status in STATUSES},
        "waiting": list(waiting),
        "parts": dictionaries,
    }
    write_text(folder / "summary.json", json.dumps(document, allow_nan=False, indent=0) + "\n")
