"""collect_batch(folder): the tables and pages of all that any share has written there."""

from __future__ import annotations

import os
from pathlib import Path

from sherd.batching.batch import BatchResult, write_pages
from sherd.batching.ledger.manifest import listed
from sherd.batching.ledger.rows import BatchRow, PairRow
from sherd.batching.ledger.summary import Summary
from sherd.batching.pairs.all_pairs import PairsResult, write_matrices
from sherd.batching.run import collected_rows

__all__ = ["collect_batch"]


def collect_batch(folder: str | os.PathLike[str]) -> BatchResult | PairsResult:
    """Make the tables and pages of all that any share has written into a folder.

    Parameters
    ----------
    folder
        Of a batch, or of all pairs of a collection.

    Returns
    -------
    BatchResult or PairsResult
        With the names of what nobody has come to.

    Raises
    ------
    InputError
        If there is no batch.
    OutputError
        If something cannot be written.

    Examples
    --------
    >>> from sherd.errors import InputError
    >>> try:
    ...     collect_batch("nowhere")
    ... except InputError as error:
    ...     print(error)
    nowhere: holds no batch; name the folder that was given with -o
    """
    target = Path(folder)
    found = listed(target)
    known = collected_rows(target, found.names, found.settings)
    rows = [known[name] for name in found.names if name in known]
    waiting = tuple(name for name in found.names if name not in known)
    Summary(target, BatchRow if found.shapes is None else PairRow, found.names, known).write()
    if found.shapes is not None:
        write_matrices(target, found.shapes, rows)
        pairs = tuple(row for row in rows if isinstance(row, PairRow))
        return PairsResult(target, pairs, waiting, 0)
    matches = tuple(row for row in rows if isinstance(row, BatchRow))
    write_pages(target, matches, found.exports)
    return BatchResult(target, matches, waiting, 0)
