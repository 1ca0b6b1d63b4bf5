"""Run :func:`sherd.match.match` over the pairs of a data set, going on where a run stopped.

Every vertex of every part is answered and counted. Each finished pair is one small file under
`output/pairs`, named by a hash of its input files, the version and the settings, so that an
interrupted run goes on where it stopped and a changed input is measured anew.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from sherd._version import __version__
from sherd.benchmark.match_row import BenchmarkSettings, MatchRow, measured
from sherd.benchmark.match_summary import summary
from sherd.benchmark.pairs import PairSource
from sherd.errors import OptionError
from sherd.output import Stages, write_text
from sherd.threads import set_thread_count

__all__ = ["match_benchmark"]


def match_benchmark(
    sources: Sequence[PairSource],
    output: Path,
    *,
    settings: BenchmarkSettings,
    words: dict[str, str],
    jobs: int = 1,
) -> dict[str, Any]:
    """Match all pairs, write ``bench.json`` to `output`, and return its content.

    Parameters
    ----------
    sources
        The pairs.
    output
        Where results go; what is found there already is not measured again.
    settings
        See :class:`sherd.benchmark.match_row.BenchmarkSettings`.
    words
        About the data set: ``"title"``, ``"data"`` and ``"meshes"``, kept in bench.json.
    jobs
        Processes; each prepares the full shapes for itself.

    Raises
    ------
    MeshFileError
        If a file is missing or damaged.
    OptionError
        If `jobs` is below 1.
    OutputError
        If a result cannot be written.
    """
    if jobs < 1:
        raise OptionError(f"jobs is {jobs}, but at least 1 process is needed")
    keys = [_key(source, settings) for source in sources]
    rows = {key: row for key in keys if (row := _stored(output, key)) is not None}
    waiting = [(key, source) for key, source in zip(keys, sources, strict=True) if key not in rows]
    stages = Stages(len(waiting))
    for key, row in _measured_all(waiting, settings, jobs):
        with stages(row.pair):
            rows[key] = row
            write_text(_place(output, key), json.dumps(row.plain(), allow_nan=False) + "\n")
    stages.close()
    document = summary([rows[key] for key in keys], settings, words)
    write_text(output / "bench.json", json.dumps(document, indent=1, allow_nan=False) + "\n")
    return document


def _measured_all(
    waiting: list[tuple[str, PairSource]], settings: BenchmarkSettings, jobs: int
) -> Iterator[tuple[str, MatchRow]]:
    # pairs of one full shape one after another: it is prepared once in each process
    waiting = sorted(waiting, key=lambda entry: str(entry[1].full))
    if jobs == 1 or len(waiting) < 2:
        for key, source in waiting:
            yield key, measured(source, settings)
        return
    keys, sources = zip(*waiting, strict=True)
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        work = pool.map(partial(_measured_beside_others, settings=settings), sources)
        yield from zip(keys, work, strict=True)


def _measured_beside_others(source: PairSource, settings: BenchmarkSettings) -> MatchRow:
    set_thread_count(1)  # the processes share the cores
    return measured(source, settings)


def _key(source: PairSource, settings: BenchmarkSettings) -> str:
    """Hash of everything that the measurement depends on."""
    content = hashlib.sha256()
    question = {
        **asdict(settings), "kind": source.kind, "version": __version__, "pair": source.name
    }  # fmt: skip
    content.update(json.dumps(question, sort_keys=True).encode())
    for path in source.inputs:
        content.update(path.read_bytes() if path.exists() else b"")
    return content.hexdigest()[:24]


def _place(output: Path, key: str) -> Path:
    return output / "pairs" / f"{key}.json"


def _stored(output: Path, key: str) -> MatchRow | None:
    try:
        return MatchRow.from_plain(json.loads(_place(output, key).read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError, AttributeError):
        return None  # not measured yet, or written by another version
