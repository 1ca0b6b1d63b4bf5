"""matched: one part matched and written."""

from __future__ import annotations

import os
import time
from typing import Any

from sherd.batching.choice import Chosen, best_match
from sherd.batching.gallery.thumbnail import thumbnail
from sherd.batching.guarded import finish, guarded, with_cost
from sherd.batching.ledger.fingerprint import Fingerprint
from sherd.batching.ledger.journal import Outcome
from sherd.batching.ledger.place import OUTCOME, PARTS, THUMBNAIL, staged
from sherd.batching.ledger.rows import BatchRow
from sherd.batching.task import MatchTask
from sherd.report.stored.folder import MATCH_FORMAT
from sherd.report.write import write_report
from sherd.result_folder import ResultKind, replaceable_files
from sherd.results.match_result import MatchResult
from sherd.results.status import Status
from sherd.scan.intake import scan_intake

__all__ = ["matched"]


def matched(task: MatchTask) -> Outcome:
    """Match the part and move its folder into place; what stands there already is not computed."""
    return guarded(task, _matched)


def _matched(task: MatchTask, read: tuple[Fingerprint, ...]) -> Outcome:
    start = time.perf_counter()
    scan = scan_intake(task.files[0])
    chosen = best_match(task.fulls, scan, task.options, fit_scale=task.fit_scale)
    full, result = chosen.full, chosen.match
    result = result.with_min_confidence(task.min_confidence)
    kind = ResultKind(MATCH_FORMAT, result.full.name, result.part.name)
    replaceable_files(task.target, kind, overwrite=task.overwrite, own=(OUTCOME, THUMBNAIL))
    with staged(task.target) as folder:
        document = write_report(result, folder, command=task.command(full), exports=task.exports)
        (folder / THUMBNAIL).write_bytes(thumbnail(folder / "match.png"))
        row = with_cost(_row(task, chosen, result, document), start)
        return finish(task, read, row, folder)


def _row(
    task: MatchTask, chosen: Chosen, result: MatchResult, document: dict[str, Any]
) -> BatchRow:
    sure = result.confidence[result.matched]
    return BatchRow(
        name=task.name,
        part=os.fspath(task.part.path),
        full=chosen.full.name,
        status=Status.DOUBTFUL.name.lower() if chosen.doubt else document["status"],
        reason=chosen.doubt or document["advice"],
        chance=document["chance"],
        error_estimate=1.0 - float(sure.mean()) if len(sure) else None,
        area_fraction=document["area_fraction"],
        unmatched=document["unmatched"],
        mean_confidence=document["mean_confidence"],
        score=document["scores"].get("best"),
        scale=document["scale"],
        folder=f"{PARTS}/{task.name}",
    )
