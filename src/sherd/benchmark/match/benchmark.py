"""Run :func:`sherd.match.match` over the pairs of a data set, going on where a run stopped.

Every vertex of every part is answered and counted. Each finished pair is one small file under
`output/pairs`, named by a hash of its input files, the version and the settings, so that an
interrupted run goes on where it stopped and a changed input is measured anew.
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
from sherd.benchmark.row_file import pair_file
from sherd.benchmark.runner import measured_rows
from sherd.output import write_text

__all__ = ["match_benchmark"]


def match_benchmark(
    pair_set: PairSet, output: Path, *, only: tuple[str, ...] = (), jobs: int = 1
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
    jobs
        Processes; each prepares the full shapes for itself.

    Raises
    ------
    MeshFileError
        If a file is missing or damaged.
    OptionError
        If `jobs` is below 1, or matplotlib is not installed.
    OutputError
        If a result cannot be written.
    """
    check_plotting()
    settings = pair_set.settings
    pairs = [pair for pair in pair_set.pairs if not only or pair.name in only]
    files = {pair.name: pair_file(output, pair, settings) for pair in pairs}

    def keep(name: str, row: MatchRow) -> None:
        write_text(files[name], json.dumps(row.plain(), allow_nan=False) + "\n")

    rows = measured_rows(
        # pairs of one full shape one after another: it is prepared once in each process
        sorted(pairs, key=lambda pair: str(pair.full)),
        partial(measured, settings=settings),
        known={name: row for name, path in files.items() if (row := _stored(path)) is not None},
        keep=keep,
        jobs=jobs,
    )
    by_name = {row.pair: row for row in rows}
    document = summary(pair_set, [by_name[pair.name] for pair in pairs])
    write_text(output / "bench.json", json.dumps(document, indent=1, allow_nan=False) + "\n")
    write_benchmark_page(document, output)
    return document


def _stored(path: Path) -> MatchRow | None:
    try:
        return MatchRow.from_plain(json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError, AttributeError):
        return None  # not measured yet, or written by another version
