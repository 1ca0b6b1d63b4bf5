"""batch(fulls, parts, folder): many parts, each matched with the full shape it belongs to."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

from sherd.batching.gallery.page import write_gallery
from sherd.batching.ledger.lock import lock_of
from sherd.batching.ledger.manifest import check_batch_folder, write_manifest
from sherd.batching.ledger.rows import BatchRow, Row
from sherd.batching.ledger.run_result import RunResult
from sherd.batching.options import BatchOptions
from sherd.batching.parts import BatchPart, PartSource, batch_parts, shared_list
from sherd.batching.run import BatchRun
from sherd.batching.task import MatchTask
from sherd.batching.templates import full_shapes, loaded_template, prepare_templates
from sherd.batching.work import matched
from sherd.batching.workers import workers
from sherd.errors import InputError, OptionError
from sherd.files.parquet import parquet_bytes
from sherd.library.fitted_scale import FITTED_ANYWAY
from sherd.output import write_bytes
from sherd.report.stored.folder import plain
from sherd.results.match_options import MatchOptions
from sherd.scan.intake import MeshSource
from sherd.surface.template import Template

__all__ = ["BatchResult", "batch", "write_pages"]


@dataclass(frozen=True, repr=False)
class BatchResult(RunResult[BatchRow]):
    """What became of the parts of a batch.

    Attributes
    ----------
    folder
        Where everything is.
    rows
        One for each part that has an answer or a reason why not, in the order of the names.
    waiting
        Names of the parts that nobody has come to, as of other shares.
    computed
        How many of the rows were computed in this run.

    Examples
    --------
    >>> BatchResult(Path("out"), (), ("leg",), 0).all_good
    False
    """

    @property
    def all_good(self) -> bool:
        """Whether every part has a good answer."""
        return not self.waiting and all(row.status == "good" for row in self.rows)


def batch(
    fulls: MeshSource | Template | Sequence[MeshSource | Template],
    parts: PartSource,
    folder: str | os.PathLike[str],
    options: MatchOptions | None = None,
    *,
    batch_options: BatchOptions | None = None,
    jobs: int | None = None,
    executor: Executor | None = None,
    tell: Callable[[BatchRow], None] | None = None,
) -> BatchResult:
    """Match every part with the full shape it belongs to, and write a folder of answers.

    Parameters
    ----------
    fulls
        One full shape or several: paths, meshes or templates; or the folder of a library, which
        stands for all its shapes.
    parts
        A folder, a pattern such as ``"scans/*.ply"``, or a sequence of files or
        :class:`BatchPart`.
    folder
        Has afterwards ``parts/NAME`` for each part, as :func:`sherd.write_report` makes it,
        ``summary.csv``, ``summary.json`` and ``gallery.html``. Started again with the same folder,
        a batch goes on where it was: what has an answer to the same question is not asked again.
    options
        Of each match; landmarks and ignored vertices are given with each part instead.
    batch_options
        See :class:`BatchOptions`.
    jobs
        Worker processes; as many as cores, or as memory is free for, if None. A program that
        calls this must begin under ``if __name__ == "__main__":``, as its workers import it.
    executor
        Computes instead of own processes: any :class:`concurrent.futures.Executor`. Its workers
        must see the files of full shapes and parts and the folder under the same paths.
    tell
        Called with each row as soon as it is known, first those of earlier runs.

    Returns
    -------
    BatchResult
        Rows for all parts. What goes wrong with one part is its row, and never an exception.

    Raises
    ------
    OptionError
        If options are out of range or do not apply to many parts.
    InputError
        If a full shape cannot be read, there are no parts, or two have one name.
    OutputError
        If the folder cannot be written, holds something else, or another process works in it.

    Examples
    --------
    >>> try:
    ...     batch("template.ply", "nowhere/", "out/")
    ... except InputError as error:
    ...     print(error)
    nowhere/: no such folder or file; check the path
    """
    target = Path(folder)
    asked = batch_options or BatchOptions()
    options = _options_of_all(options)
    if asked.fit_scale and options.scale == "unknown":
        raise OptionError(FITTED_ANYWAY)
    listed = batch_parts(parts)
    check_batch_folder(target, overwrite=asked.overwrite)
    shapes, missing = full_shapes(_as_sequence(fulls), target, template=asked.template)
    common = MatchTask(
        BatchPart(target),
        shapes,
        options,
        target,
        min_confidence=asked.min_confidence,
        fit_scale=asked.fit_scale,
        exports=asked.exports,
        overwrite=asked.overwrite,
        home=Path.cwd(),
        submitter=0 if executor is None else os.getpid(),
    )
    common = replace(common, settings=common.key(()))
    tasks = [_task(part, common) for part in listed]
    share = asked.share
    with lock_of(target, share):
        facts: dict[str, Any] = {
            "fulls": [shape.source for shape in shapes],
            "options": plain(asdict(options)),
        }
        facts |= {"exports": list(asked.exports), "settings": common.settings}
        write_manifest(target, [task.name for task in tasks], **facts)
        mine = shared_list(tasks, share)
        run = BatchRun(target, BatchRow, mine, _as_match_teller(tell), tables=share is None)
        try:
            with run:
                prepare_templates(missing if run.left else {})
                if run.left and asked.template is not None:
                    loaded_template(shapes[0])  # one that is damaged fails here, not for each part
                with workers(jobs, executor, asked.memory, len(run.left)) as (pool, window):
                    run.compute(matched, pool, window)
        finally:
            if share is None:
                write_pages(target, _match_rows(run.rows), asked.exports)
        return BatchResult(target, _match_rows(run.rows), run.waiting, run.computed)


def write_pages(folder: Path, rows: Sequence[BatchRow], exports: Sequence[str]) -> None:
    """Write ``gallery.html`` and, if correspondence is in that format, ``summary.parquet``.

    Raises
    ------
    OutputError
        If one cannot be written.
    """
    write_gallery(folder, rows)
    if "parquet" in exports:
        names = [each.name for each in fields(BatchRow)]
        columns = {name: [getattr(row, name) for row in rows] for name in names}
        write_bytes(folder / "summary.parquet", parquet_bytes(columns))


def _match_rows(rows: Iterable[Row]) -> tuple[BatchRow, ...]:
    return tuple(row for row in rows if isinstance(row, BatchRow))


def _as_match_teller(tell: Callable[[BatchRow], None] | None) -> Callable[[Row], None]:
    def told(row: Row) -> None:
        if tell is not None and isinstance(row, BatchRow):
            tell(row)

    return told


def _options_of_all(options: MatchOptions | None) -> MatchOptions:
    options = options or MatchOptions()
    if options.landmarks or options.ignore:
        raise OptionError(
            "landmarks and ignored vertices are those of one part: give them with each, as "
            "BatchPart(path, landmarks=..., ignore=...)"
        )
    return options


def _task(part: BatchPart, common: MatchTask) -> MatchTask:
    """The question of one part, from what all have in common."""
    fulls = common.fulls
    if part.full is not None:
        fulls = tuple(full for full in fulls if part.full in (full.name, full.source))
        if not fulls:
            known = ", ".join(full.name for full in common.fulls)
            raise InputError(f"{part.path}: belongs to {part.full}, but given were {known}")
    if part.landmarks and len(fulls) > 1:
        raise InputError(f"{part.path}: has landmarks; say which of the full shapes they are on")
    options = replace(common.options, landmarks=part.landmarks, ignore=part.ignore)
    return replace(common, part=part, fulls=fulls, options=options)


def _as_sequence(
    fulls: MeshSource | Template | Sequence[MeshSource | Template],
) -> Sequence[MeshSource | Template]:
    """Several are a list, or a tuple that is no pair (vertices, faces)."""
    if isinstance(fulls, list):
        return fulls
    if isinstance(fulls, tuple) and all(isinstance(each, str | os.PathLike) for each in fulls):
        return fulls
    return [fulls]
