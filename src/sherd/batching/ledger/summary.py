"""Summary: the tables of a batch, written anew as results come, but never for long."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from sherd.batching.ledger.rows import Row, write_summary

__all__ = ["Summary"]

# Tables are this fresh at best, and to write them takes at most a fiftieth of the time.
SECONDS = 2.0
LARGEST_SHARE = 1 / 50


class Summary:
    """Writes ``summary.csv`` and ``summary.json`` from rows that grow.

    Parameters
    ----------
    folder
        Of the batch.
    kind
        Of the rows.
    names
        Of all parts, in the order of the tables.
    rows
        By name; may grow meanwhile.
    """

    def __init__(
        self, folder: Path, kind: type[Row], names: Sequence[str], rows: Mapping[str, Row]
    ) -> None:
        self._folder, self._kind, self._names, self._rows = folder, kind, names, rows
        self._next = 0.0
        self._written = -1

    def refresh(self) -> None:
        """Write if there is something new and the last time is long enough ago."""
        if time.monotonic() >= self._next and len(self._rows) != self._written:
            self.write()

    def write(self) -> None:
        """Write now.

        Raises
        ------
        OutputError
            If the tables cannot be written.
        """
        start = time.monotonic()
        rows = [self._rows[name] for name in self._names if name in self._rows]
        waiting = [name for name in self._names if name not in self._rows]
        write_summary(self._folder, self._kind, rows, waiting)
        self._written = len(self._rows)
        end = time.monotonic()
        self._next = end + max(SECONDS, (end - start) / LARGEST_SHARE)
