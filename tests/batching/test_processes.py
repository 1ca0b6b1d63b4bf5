"""Worker processes die alone, end with their parent, and never end a batch."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path

import pytest

from sherd.batching.engine import finished_tasks
from sherd.batching.options import job_count
from sherd.batching.processes import IsolatedProcesses
from sherd.errors import OptionError, SherdError


@dataclass(frozen=True)
class Call:
    """Something to do, by its name."""

    name: str


def work(call: Call) -> str:
    kind, _, path = call.name.partition(" ")
    if kind == "die" or (kind == "once" and not Path(path).exists()):
        if path:
            Path(path).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    if kind == "hoard":
        return str(len(bytearray(3 * 10**9)))
    return f"{kind} done"


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="processes cannot be killed here")
def test_a_killed_worker_costs_its_own_task_and_is_asked_once_more(tmp_path) -> None:
    """And one that would hold more than its share hears no, before the system kills anyone."""
    calls = [Call(name) for name in ("a", "die", f"once {tmp_path / 'mark'}", "hoard", "b", "c")]
    with IsolatedProcesses(2, memory=2 * 10**9) as workers:
        found = dict(finished_tasks(calls, work, workers, window=2))
    assert [found[calls[k]] for k in (0, 2, 4, 5)] == ["a done", "once done", "b done", "c done"]
    assert isinstance(found[calls[1]], BrokenProcessPool)
    if sys.platform == "linux":
        assert isinstance(found[calls[3]], MemoryError)


PROGRAM = """
import os, sys, time
from sherd.batching.processes import IsolatedProcesses
if __name__ == "__main__":
    workers = IsolatedProcesses(1)
    print(workers.submit(os.getpid).result(), flush=True)
    workers.submit(time.sleep, 60)
    time.sleep(60)
"""


def ended(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    # where nobody has asked for its exit code yet, as in a container without init, it stays listed
    status = Path(f"/proc/{process}/stat")
    return status.exists() and status.read_text().split()[2] == "Z"


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="processes cannot be killed here")
def test_workers_end_when_their_parent_is_killed(tmp_path) -> None:
    (tmp_path / "program.py").write_text(PROGRAM)
    process = subprocess.Popen(
        [sys.executable, str(tmp_path / "program.py")], stdout=subprocess.PIPE, text=True
    )
    worker = int(process.stdout.readline())
    process.kill()
    process.wait()
    process.stdout.close()
    end = time.monotonic() + 60
    while not ended(worker):
        assert time.monotonic() < end
        time.sleep(0.05)


def test_a_program_without_a_guard_is_told_so(tmp_path) -> None:
    """Its workers would import it and begin again."""
    program = PROGRAM.replace('if __name__ == "__main__":', "if True:")
    (tmp_path / "program.py").write_text(program)
    done = subprocess.run(
        [sys.executable, str(tmp_path / "program.py")], capture_output=True, text=True, check=False
    )
    assert done.returncode != 0
    assert "under `if __name__" in done.stderr


def test_an_executor_that_is_shut_down_ends_the_run_with_advice() -> None:
    workers = IsolatedProcesses(1)
    workers.shutdown()
    with pytest.raises(SherdError, match="what is finished is kept"):
        list(finished_tasks([Call("a")], work, workers, window=1))


def test_jobs_fit_the_memory(monkeypatch) -> None:
    monkeypatch.setattr("sherd.batching.options.available_memory", lambda: 5 * 10**9)
    monkeypatch.setattr(os, "cpu_count", lambda: 8)
    assert job_count(None, None) == (5, 10**9)
    assert job_count(None, 2 * 10**9) == (2, 2 * 10**9)
    assert job_count(2, None) == (2, 25 * 10**8)
    with pytest.raises(OptionError, match=r"6 jobs need about 6\.0 GB .* ask for 5"):
        job_count(6, None)
    with pytest.raises(OptionError, match="jobs is 0"):
        job_count(0, None)
