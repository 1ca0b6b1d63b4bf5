"""Ten thousand parts: what is around them costs next to nothing, and a resume begins at once."""

from __future__ import annotations

import json
import os
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from sherd.batching.ledger.fingerprint import Fingerprint
from sherd.batching.ledger.journal import Outcome
from sherd.batching.ledger.place import PARTS
from sherd.batching.ledger.rows import BatchRow
from sherd.batching.parts import batch_parts
from sherd.batching.run import BatchRun
from sherd.batching.task import MatchTask
from sherd.batching.templates import FullShape
from sherd.results.match_options import MatchOptions

COUNT = 10_000
# The smallest parts take 4 s of a core; a twentieth of that would be 200 ms.
LARGEST_COST = 0.005
LONGEST_RESUME = 5.0


@pytest.fixture
def folder(tmp_path) -> Path:
    (tmp_path / "scans").mkdir()
    for k in range(COUNT):
        (tmp_path / "scans" / f"{k:05}.ply").write_bytes(b"")
        (tmp_path / PARTS / f"{k:05}").mkdir(parents=True)
        (tmp_path / PARTS / f"{k:05}" / "result.json").write_bytes(b"{}")
    return tmp_path


def run_of(folder: Path) -> tuple[BatchRun[MatchTask], list[MatchTask]]:
    full = FullShape("whole.ply", "whole.ply", "0", folder / "whole.npz")
    tasks = [
        MatchTask(part, (full,), MatchOptions(), folder, submitter=os.getpid())
        for part in batch_parts(folder / "scans")
    ]
    return BatchRun(folder, BatchRow, tasks, lambda _: None, tables=True), tasks


def answered(task: MatchTask) -> Outcome:
    read = Fingerprint.of(task.files[0])
    result = Fingerprint.of(task.target / "result.json")
    row = BatchRow(task.name, task.part.path.name, status="good", chance=0.9, folder="x")
    return Outcome(BatchRow(**{**vars(row), "key": task.key([read.sha256])}), (read,), result)


def test_bookkeeping_is_cheap_and_resumes_at_once(folder) -> None:
    run, tasks = run_of(folder)
    start = time.process_time()
    with run, ThreadPoolExecutor(1) as here:
        run.compute(answered, here, window=4)
    assert len(run.rows) == COUNT == len(tasks)
    assert time.process_time() - start < LARGEST_COST * COUNT
    start = time.process_time()
    again, _ = run_of(folder)
    assert time.process_time() - start < LONGEST_RESUME
    assert (again.left, again.waiting) == ([], ())
    document = json.loads((folder / "summary.json").read_text())
    assert document["counts"]["good"] == COUNT
