"""Run :func:`sherd.match.match` over the pairs of a data set, going on where a run stopped.

Every vertex of every part is answered and counted.
"""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import Any

from sherd.benchmark.datasets.pairs import PairSet
from sherd.benchmark.match.measurement import measured
from sherd.benchmark.match.page import write_benchmark_page
from sherd.benchmark.match.row import MatchRow
from sherd.benchmark.match.summary import summary
from sherd.benchmark.paper.drawing import check_plotting
from sherd.benchmark.runner import chosen_pairs, measured_pairs
from sherd.output import write_text

__all__ = ["match_benchmark"]


def match_benchmark(
    pair_set: PairSet,
    output: Path,
    *,
    only: tuple[str, ...] = (),
    limit: int | None = None,
    jobs: int = 1,
) -> dict[str, Any]:
    """Match all pairs, write ``bench.json`` and ``bench.html``, and return what the former holds.

    Parameters
    ----------
    pair_set
        The pairs of a data set and how they are shown.
    output
        Where results go; what is found there already is not measured again.
    only
        Names of the pairs to measure; all if empty.
    limit
        First pairs only.
    jobs
        Processes; each prepares the full shapes for itself.

    Raises
    ------
    MeshFileError
        If a file is missing or damaged.
    OptionError
        If `jobs` or `limit` is below 1, or matplotlib is not installed.
    OutputError
        If a result cannot be written.
    """
    check_plotting()
    settings = pair_set.settings
    pairs = chosen_pairs(pair_set.pairs, only, limit)
    rows = measured_pairs(
        # pairs of one full shape one after another: it is prepared once in each process
        sorted(pairs, key=lambda pair: str(pair.full)),
        partial(measured, settings=settings),
        kind=MatchRow,
        output=output,
        settings=settings,
        jobs=jobs,
    )
    by_name = {row.pair: row for row in rows}
    document = summary(pair_set, [by_name[pair.name] for pair in pairs])
    write_text(output / "bench.json", json.dumps(document, indent=1, allow_nan=False) + "\n")
    write_benchmark_page(document, output)
    return document
