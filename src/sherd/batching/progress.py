"""Progress: a line on the terminal with rate, time left and counts by status."""

from __future__ import annotations

import sys
from collections import Counter

from tqdm import tqdm

from sherd.batching.ledger.rows import STATUSES, Row

__all__ = ["Progress"]


class Progress:
    """Shown only if standard error is a terminal.

    Parameters
    ----------
    total
        Number of parts.
    known
        Rows of earlier runs; they do not count for the rate.
    """

    def __init__(self, total: int, known: list[Row]) -> None:
        self._counts = Counter(row.status for row in known)
        self._bar = tqdm(
            total=total,
            initial=len(known),
            disable=None,
            file=sys.stderr,
            leave=False,
            unit="",
            dynamic_ncols=True,
            bar_format=("{desc} |{bar:20}| {n_fmt}/{total_fmt} {rate_fmt}, {remaining} left"),
        )
        self._describe()

    def add(self, row: Row) -> None:
        """One more row."""
        self._counts[row.status] += 1
        self._describe()
        self._bar.update(1)

    def close(self) -> None:
        """Take the line off the terminal."""
        self._bar.close()

    def _describe(self) -> None:
        said = [f"{self._counts[status]} {status}" for status in STATUSES if self._counts[status]]
        self._bar.set_description_str(", ".join(said) or "starting", refresh=False)
