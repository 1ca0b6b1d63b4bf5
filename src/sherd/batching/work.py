"""matched: one part matched and written, by whichever process is asked to; it never raises.

Whatever goes wrong with one part is its row, so that the others go on.
"""

from __future__ import annotations

import os
import sys
import time
from dataclasses import replace
from typing import Any

from sherd.batching.choice import best_match
from sherd.batching.fingerprint import Fingerprint
from sherd.batching.journal import Outcome, outcome_text, stored_outcome
from sherd.batching.place import OUTCOME, PARTS, THUMBNAIL, move_into_place, staged
from sherd.batching.rows import BatchRow, Failure
from sherd.batching.task import MatchTask
from sherd.batching.templates import FullShape
from sherd.batching.thumbnail import thumbnail
from sherd.errors import InputError, OutputError, SherdError
from sherd.report.stored.folder import MATCH_FORMAT
from sherd.report.write import write_report
from sherd.result_folder import RESULT, ResultKind, replaceable_files
from sherd.results.match_result import MatchResult
from sherd.scan.intake import scan_intake
from sherd.threads import set_thread_count

__all__ = ["failed", "finished_outcome", "matched"]


def matched(task: MatchTask) -> Outcome:
    """Match the part and move its folder into place; what stands there already is not computed."""
    if os.getpid() != task.submitter:
        set_thread_count(1)
    start = time.perf_counter()
    read: Fingerprint | None = None
    try:
        read = Fingerprint.of(task.file)
        outcome = finished_outcome(task, read) or _matched(task, read)
    except MemoryError:
        outcome = failed(task, "memory", "not enough memory; decimate the mesh", read)
    except OutputError as error:
        outcome = failed(task, "not written", str(error), read)
    except SherdError as error:
        outcome = failed(task, "refused", str(error), read)
    except OSError as error:
        reason = f"{task.part.path}: cannot be read ({error.strerror}); check the path"
        outcome = failed(task, "unreadable", reason, read)
    except Exception as error:
        said = f"internal error: {type(error).__name__}: {error}; please report it"
        outcome = failed(task, "internal", said, read)
    if outcome.row.seconds is None:
        return replace(outcome, row=replace(outcome.row, **_cost(start)))
    return outcome


def finished_outcome(task: MatchTask, part: Fingerprint) -> Outcome | None:
    """What stands in the folder of the part, if it answers this very question and is whole."""
    try:
        outcome = stored_outcome((task.target / OUTCOME).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    if outcome is None or outcome.result is None or outcome.row.key != task.key(part.sha256):
        return None
    return outcome if outcome.result.still_of(task.target / RESULT) else None


def failed(
    task: MatchTask, failure: Failure, reason: str, part: Fingerprint | None = None
) -> Outcome:
    """The row of a part that has no answer."""
    row = BatchRow(
        name=task.name,
        part=os.fspath(task.part.path),
        full=task.fulls[0].name if len(task.fulls) == 1 else None,
        reason=" ".join(reason.split()),
        failure=failure,
        key="" if part is None else task.key(part.sha256),
    )
    return Outcome(row, part)


def _matched(task: MatchTask, read: Fingerprint) -> Outcome:
    start = time.perf_counter()
    scan = scan_intake(task.file)
    full, result = best_match(task.fulls, scan, task.options)
    result = result.with_min_confidence(task.min_confidence)
    kind = ResultKind(MATCH_FORMAT, result.full.name, result.part.name)
    replaceable_files(task.target, kind, overwrite=task.overwrite, own=(OUTCOME, THUMBNAIL))
    with staged(task.target) as folder:
        document = write_report(result, folder, command=task.command(full), exports=task.exports)
        (folder / THUMBNAIL).write_bytes(thumbnail(folder / "match.png"))
        if not read.still_of(task.file):
            raise InputError(f"{task.part.path}: was changed while it was matched; start again")
        row = replace(_row(task, full, result, document), **_cost(start))
        row = replace(row, key=task.key(read.sha256))
        outcome = Outcome(row, read, Fingerprint.of(folder / RESULT))
        (folder / OUTCOME).write_text(outcome_text(outcome) + "\n", encoding="utf-8")
        move_into_place(folder, task.target)
    return outcome


def _row(
    task: MatchTask, full: FullShape, result: MatchResult, document: dict[str, Any]
) -> BatchRow:
    sure = result.confidence[result.matched]
    return BatchRow(
        name=task.name,
        part=os.fspath(task.part.path),
        full=full.name,
        status=document["status"],
        reason=document["advice"],
        chance=document["chance"],
        error_estimate=1.0 - float(sure.mean()) if len(sure) else None,
        area_fraction=document["area_fraction"],
        unmatched=document["unmatched"],
        mean_confidence=document["mean_confidence"],
        score=document["scores"].get("best"),
        scale=document["scale"],
        folder=f"{PARTS}/{task.name}",
    )


def _cost(start: float) -> dict[str, Any]:
    return {"seconds": round(time.perf_counter() - start, 3), "memory": _peak_memory()}


def _peak_memory() -> int | None:
    """The most that this process ever held, in bytes."""
    try:
        import resource  # not on every system  # noqa: PLC0415
    except ImportError:
        return None
    unit = 1 if sys.platform == "darwin" else 1024
    return unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
