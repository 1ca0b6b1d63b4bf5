"""all_pairs(shapes, folder): what each two shapes of a collection share."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass
from itertools import combinations
from pathlib import Path

from sherd.batching.ledger.lock import lock_of
from sherd.batching.ledger.manifest import check_batch_folder, write_manifest
from sherd.batching.ledger.rows import PairRow, Row
from sherd.batching.ledger.run_result import RunResult
from sherd.batching.options import BatchOptions
from sherd.batching.pairs.matrix import (
    likeness_matrix,
    matrix_csv,
    matrix_picture,
    shared_matrix,
)
from sherd.batching.pairs.task import PairTask
from sherd.batching.pairs.work import overlapped
from sherd.batching.parts import BatchPart, PartSource, batch_parts, shared_list
from sherd.batching.run import BatchRun
from sherd.batching.task import question_hash
from sherd.batching.workers import workers
from sherd.errors import InputError
from sherd.output import write_bytes, write_text
from sherd.report.stored.folder import plain
from sherd.results.overlap_options import OverlapOptions

__all__ = ["PairsResult", "all_pairs", "write_matrices"]


@dataclass(frozen=True, repr=False)
class PairsResult(RunResult[PairRow]):
    """What each two shapes of a collection share.

    Attributes
    ----------
    folder
        Where everything is.
    rows
        One for each pair that was compared.
    waiting
        Names of the pairs that nobody has come to.
    computed
        How many of the rows were computed in this run.

    Examples
    --------
    >>> PairsResult(Path("out"), (), (), 0).all_answered
    True
    """


def all_pairs(
    shapes: PartSource,
    folder: str | os.PathLike[str],
    options: OverlapOptions | None = None,
    *,
    batch_options: BatchOptions | None = None,
    jobs: int | None = None,
    executor: Executor | None = None,
    tell: Callable[[Row], None] = lambda _: None,
) -> PairsResult:
    """Find what each two shapes share: cheap evidence first, the full question if it is worth it.

    Parameters
    ----------
    shapes
        As the parts of :func:`sherd.batch`.
    folder
        Has afterwards ``parts/FIRST--SECOND`` for each pair that was asked, as ``sherd overlap``
        makes it, ``summary.csv``, ``summary.json``, ``shared_area.csv``, ``likeness.csv`` and
        ``matrix.png``. Started again it goes on where it was.
    options
        Of each overlap.
    batch_options, jobs, executor, tell
        As of :func:`sherd.batch`.

    Raises
    ------
    OptionError, InputError, OutputError
        As :func:`sherd.batch`.
    """
    target, asked = Path(folder), batch_options or BatchOptions()
    options = options or OverlapOptions()
    listed = batch_parts(shapes)
    if len(listed) < 2:
        raise InputError(f"{listed[0].path}: is one shape, but pairs need two")
    check_batch_folder(target, overwrite=asked.overwrite)
    tasks = _tasks(listed, options, target, asked, 0 if executor is None else os.getpid())
    share = asked.share
    names = [part.name for part in listed]
    with lock_of(target, share):
        facts = {"shapes": names, "options": plain(asdict(options)), "settings": tasks[0].settings}
        write_manifest(target, [task.name for task in tasks], **facts)
        mine = shared_list(tasks, share)
        run = BatchRun(target, PairRow, mine, tell, tables=share is None)
        try:
            with run, workers(jobs, executor, asked.memory, len(run.left)) as (pool, window):
                run.compute(overlapped, pool, window)
        finally:
            if share is None:
                write_matrices(target, names, run.rows)
        return PairsResult(target, _pair_rows(run.rows), run.waiting, run.computed)


def _tasks(
    shapes: Sequence[BatchPart],
    options: OverlapOptions,
    folder: Path,
    asked: BatchOptions,
    submitter: int,
) -> list[PairTask]:
    common = {"pairs": True, "options": asdict(options), "exports": asked.exports}
    tasks = [
        PairTask(
            first,
            second,
            options,
            folder,
            exports=asked.exports,
            overwrite=asked.overwrite,
            home=Path.cwd(),
            settings=question_hash(common),
            submitter=submitter,
        )
        for first, second in combinations(shapes, 2)
    ]
    seen: set[str] = set()
    for task in tasks:
        if task.name in seen:
            raise InputError(f"two pairs would be called {task.name}; rename one of the shapes")
        seen.add(task.name)
    return tasks


def write_matrices(folder: Path, names: Sequence[str], rows: Sequence[Row]) -> None:
    """Write ``shared_area.csv``, ``likeness.csv`` and ``matrix.png``.

    Raises
    ------
    OutputError
        If one cannot be written.
    """
    known = _pair_rows(rows)
    shared, likeness = shared_matrix(names, known), likeness_matrix(names, known)
    write_text(folder / "shared_area.csv", matrix_csv(names, shared))
    write_text(folder / "likeness.csv", matrix_csv(names, likeness))
    write_bytes(folder / "matrix.png", matrix_picture(names, shared, likeness))


def _pair_rows(rows: Sequence[Row]) -> tuple[PairRow, ...]:
    return tuple(row for row in rows if isinstance(row, PairRow))
