"""Killed at any moment, on own processes and on a cluster: nothing is lost, nothing half-done."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import distributed
import pytest

from sherd.batching.batch import batch
from sherd.batching.ledger.place import OUTCOME
from sherd.files.mesh_files import write_mesh
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.stored.folder import folder_problems

STAND_IN = Path(__file__).with_name("stand_in.py")
COUNT = 24
BROKEN = ("broken-1", "broken-2", "broken-3")


@pytest.fixture
def home(tmp_path, exhibit) -> Path:
    """A full shape and parts that all differ, three of them broken."""
    (tmp_path / "scans").mkdir()
    write_mesh(exhibit.full, tmp_path / "whole.ply")
    part = exhibit.part
    for k in range(COUNT):
        mesh = TriangleMesh(part.vertices * (1 + k / 1000), part.faces)
        write_mesh(mesh, tmp_path / "scans" / f"scan-{k:02}.ply")
    for name in BROKEN:
        (tmp_path / "scans" / f"{name}.ply").write_text("ply\n")
    return tmp_path


def contents(out: Path) -> dict[str, bytes]:
    """All files of all parts but what says how long it took."""
    parts = out / "parts"
    return {
        path.relative_to(parts).as_posix(): path.read_bytes()
        for path in sorted(parts.rglob("*"))
        if path.is_file() and path.name != OUTCOME
    }


def serial(home: Path, out: Path) -> dict[str, bytes]:
    """What one process makes of the same parts."""
    program = (
        f"import sys; sys.path.insert(0, {str(STAND_IN.parent)!r})\n"
        "import stand_in; stand_in.take_place()\n"
        "from concurrent.futures import ThreadPoolExecutor\n"
        "from pathlib import Path\n"
        "import sherd\n"
        f"home = Path({str(home)!r})\n"
        "with ThreadPoolExecutor(1) as here:\n"
        f"    sherd.batch(home / 'whole.ply', home / 'scans', {str(out)!r}, executor=here)\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True)
    return contents(out)


def started(home: Path) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, str(STAND_IN), str(home), "2"],
        env={**os.environ, "STAND_IN_SECONDS": "0.02"},
    )


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="processes cannot be killed here")
def test_killed_twice_the_third_start_has_every_answer_as_one_process_makes_it(home) -> None:
    out = home / "out"
    for share in (1 / 4, 1 / 2):
        process = started(home)
        while len(list((out / "parts").glob("scan-*"))) < share * COUNT:
            assert process.poll() is None
            time.sleep(0.01)
        process.kill()
        process.wait()
    left = contents(out)
    assert started(home).wait() == 0
    assert not list((out / "parts").glob(".*"))
    rows = (out / "summary.csv").read_text().splitlines()
    assert len(rows) == 1 + COUNT + len(BROKEN)
    assert sum(",failed," in row and "truncated" in row for row in rows) == len(BROKEN)
    for k in range(COUNT):
        assert folder_problems(out / "parts" / f"scan-{k:02}") == ()
    found = contents(out)
    assert found == serial(home, home / "serial")
    assert {name: found[name] for name in left if "/." not in name and name[0] != "."}.items() <= (
        found.items()
    )


def test_a_dask_worker_is_killed_and_every_result_is_there(home, monkeypatch) -> None:
    monkeypatch.setenv("STAND_IN_SECONDS", "0.1")
    out = home / "out"
    killed = []

    def kill_one(_row) -> None:
        if len(killed) == 0 and len(list((out / "parts").glob("scan-*"))) >= 4:
            killed.append(client.scheduler_info()["workers"])
            os.kill(client.run(os.getpid).popitem()[1], signal.SIGKILL)

    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None,
            preload=str(STAND_IN), silence_logs=50,
        ) as cluster,
        distributed.Client(cluster) as client,
    ):  # fmt: skip
        monkeypatch.setattr("sherd.batching.batch.prepare_templates", lambda _missing: None)
        result = batch(
            home / "whole.ply", home / "scans", out,
            executor=client.get_executor(pure=False), tell=kill_one,
        )  # fmt: skip
    assert killed
    assert [row.status for row in result.rows] == ["failed"] * 3 + ["good"] * COUNT
    assert contents(out) == serial(home, home / "serial")
