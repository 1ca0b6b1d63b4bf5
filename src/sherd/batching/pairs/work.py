"""overlapped: one pair compared, and asked in full if it is worth it."""

from __future__ import annotations

import os
import time
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from sherd.batching.guarded import finish, guarded, with_cost
from sherd.batching.ledger.fingerprint import Fingerprint
from sherd.batching.ledger.journal import Outcome
from sherd.batching.ledger.place import OUTCOME, PARTS, staged
from sherd.batching.ledger.rows import PairRow
from sherd.batching.pairs.task import PairTask
from sherd.overlap import overlap
from sherd.puzzle.pairs import LEAST_EVIDENCE, pair_evidence
from sherd.report.stored.folder import OVERLAP_FORMAT
from sherd.report.write import write_report
from sherd.result_folder import ResultKind, replaceable_files
from sherd.results.status import Status
from sherd.scan.intake import Intake, scan_intake
from sherd.surface.described import DescribedSurface
from sherd.surface.prepared import described_part

__all__ = ["overlapped"]

# Pairs come in the order of their first shapes, so one shape is described for many of them.
KEPT_SURFACES = 8


def overlapped(task: PairTask) -> Outcome:
    """Compare two shapes, and move what they share into place if it is more than chance."""
    return guarded(task, _overlapped)


def _overlapped(task: PairTask, read: tuple[Fingerprint, ...]) -> Outcome:
    start = time.perf_counter()
    shapes = [_intake(str(f), r.sha256) for f, r in zip(task.files, read, strict=True)]
    row = PairRow(task.name, os.fspath(task.first.path), os.fspath(task.second.path))
    likeness = _likeness(task, read, max(shape.mesh.length for shape in shapes))
    row = replace(row, likeness=likeness)
    if likeness < LEAST_EVIDENCE:
        said = "no more alike than unrelated shapes are, so the full question was not asked"
        key = task.key([each.sha256 for each in read])
        row = replace(row, status=Status.FOREIGN.name.lower(), reason=said, key=key)
        return Outcome(with_cost(row, start), read, settings=task.settings)
    result = overlap(shapes[0], shapes[1], task.options)
    kind = ResultKind(OVERLAP_FORMAT, result.first.name, result.second.name)
    replaceable_files(task.target, kind, overwrite=task.overwrite, own=(OUTCOME,))
    with staged(task.target) as folder:
        write_report(result, folder, command=task.command(), exports=task.exports)
        row = replace(
            row,
            status=result.status.name.lower(),
            reason=result.advice,
            asked=True,
            chance=result.chance,
            shared_of_first=result.shared_of_first,
            shared_of_second=result.shared_of_second,
            folder=f"{PARTS}/{task.name}",
        )
        return finish(task, read, with_cost(row, start), folder)


def _likeness(task: PairTask, read: tuple[Fingerprint, ...], unit: float) -> float:
    """As :func:`sherd.join` ranks pairs; of shapes of unknown scale each has its own unit."""
    known = task.options.scale == "same"
    surfaces = [
        _surface(str(file), each.sha256, unit if known else None)
        for file, each in zip(task.files, read, strict=True)
    ]
    return float(pair_evidence(surfaces, task.options.seed)[0, 1])


@lru_cache(maxsize=KEPT_SURFACES)
def _intake(file: str, content: str) -> Intake:  # noqa: ARG001 - part of what is remembered
    return scan_intake(Path(file))


@lru_cache(maxsize=KEPT_SURFACES)
def _surface(file: str, content: str, unit: float | None) -> DescribedSurface:
    mesh = _intake(file, content).mesh
    return described_part(mesh, unit or mesh.length)
