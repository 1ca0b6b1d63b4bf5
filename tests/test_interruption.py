"""Interrupted, killed, or out of disk: every file is the old one or the new one, never half."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from sherd.errors import OutputError
from sherd.files.mesh_files import write_mesh
from sherd.report.stored.folder import folder_problems
from sherd.result_folder import ResultFolder
from sherd.shapes.creature import creature

NAMES = ("a.csv", "b.ply", "report.html")


def write_all(folder: Path, content: str) -> None:
    with ResultFolder(folder) as output:
        for name in NAMES:
            output.add(name, f"{name} {content}\n" * 2000)
        output.finish({"content": content})


def contents(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text().split()[-1] for path in sorted(folder.iterdir())}


@pytest.mark.parametrize("error", [KeyboardInterrupt, OSError(28, "No space left on device")])
@pytest.mark.parametrize("step", ["fsync", "replace"])
@pytest.mark.parametrize("call", range(len(NAMES) + 1))
def test_a_failure_at_any_step_leaves_whole_files(tmp_path, monkeypatch, error, step, call) -> None:
    folder = tmp_path / "out"
    write_all(folder, "old")
    before = contents(folder)
    calls = []
    where, name = (os, "fsync") if step == "fsync" else (Path, "replace")
    original = getattr(where, name)

    def failing(*arguments):
        calls.append(arguments)
        if len(calls) == call + 1:
            raise error
        return original(*arguments)

    monkeypatch.setattr(where, name, failing)
    with pytest.raises((KeyboardInterrupt, OutputError)):
        write_all(folder, "new")
    monkeypatch.undo()
    after = contents(folder)
    assert set(after) == set(before)
    if step == "fsync" or call == 0:  # nothing was renamed yet
        assert after == before
        assert folder_problems(folder) == ()
    else:  # some files are new, and the folder says that they do not belong together
        assert after["a.csv"] == "new"
        assert len(folder_problems(folder)) == call
    write_all(folder, "again")
    assert folder_problems(folder) == ()


KILLED = """
import os, pathlib, sys
sys.path.insert(0, sys.argv[3])
from test_interruption import write_all
step, call = sys.argv[2].split(":")
where = os if step == "fsync" else pathlib.Path
original, calls = getattr(where, step), []
def deadly(*arguments):
    calls.append(0)
    if len(calls) == int(call):
        os.kill(os.getpid(), 9)
    return original(*arguments)
setattr(where, step, deadly)
write_all(pathlib.Path(sys.argv[1]), "new")
"""


@pytest.mark.parametrize("step", ["fsync:2", "replace:1", "replace:3"])
def test_a_killed_process_leaves_whole_files(tmp_path, step) -> None:
    """What was staged stays behind under temporary names; the files themselves are whole."""
    write_all(tmp_path / "out", "old")
    program = [
        sys.executable,
        "-c",
        KILLED,
        str(tmp_path / "out"),
        step,
        str(Path(__file__).parent),
    ]
    assert subprocess.run(program, check=False).returncode == -signal.SIGKILL
    for path in (tmp_path / "out").iterdir():
        if ".partial" not in path.name:
            text = path.read_text()
            assert path.name == "result.json" or len(set(text.splitlines())) == 1
    renamed = int(step[-1]) - 1 if step.startswith("replace") else 0
    assert len(folder_problems(tmp_path / "out")) == renamed


def limited(size: int) -> None:
    import resource  # noqa: PLC0415 - not on every system

    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


@pytest.mark.skipif(not hasattr(signal, "SIGXFSZ"), reason="files cannot be limited here")
def test_a_full_disk_is_said_in_one_line_and_changes_nothing(tmp_path) -> None:
    """`sherd check --repair` onto a file that stood there before."""
    mesh, target = tmp_path / "animal.ply", tmp_path / "mended.ply"
    write_mesh(creature(5000), mesh)
    target.write_bytes(b"old")
    done = subprocess.run(
        [sys.executable, "-m", "sherd", "check", str(mesh), "--repair", str(target)],
        capture_output=True, text=True, check=False, preexec_fn=lambda: limited(20_000),
    )  # fmt: skip
    assert done.returncode == 5
    assert "mended.ply: cannot be written (File too large)" in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert target.read_bytes() == b"old"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["animal.ply", "mended.ply"]


# A process that starts with this module on its path gets Ctrl-C once it asks for geodesics, and
# once more half a second later, while it leaves and waits for the thread that still sleeps. Shells
# start background jobs with SIGINT ignored, and that is inherited; a terminal does not ignore it.
INTERRUPTING = """
import os, signal, time
signal.signal(signal.SIGINT, signal.default_int_handler)
import sherd.spectral.geodesics as geodesics
def interrupted(*arguments, **options):
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(0.5)
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(5)
geodesics.Geodesics.__init__ = interrupted
"""


def before_all(folder: Path) -> str:
    """The search path for modules of a process that looks in `folder` first."""
    usual = os.environ.get("PYTHONPATH")
    return str(folder) if usual is None else f"{folder}{os.pathsep}{usual}"


@pytest.mark.parametrize("command", ["locate", "match"])
def test_control_c_ends_with_130_and_leaves_nothing(tmp_path, command) -> None:
    """The signal arrives while the meshes are matched: no folder appears."""
    mesh = tmp_path / "animal.ply"
    write_mesh(creature(5000), mesh)
    (tmp_path / "sitecustomize.py").write_text(INTERRUPTING)
    process = subprocess.Popen(
        [sys.executable, "-m", "sherd", command, str(mesh), str(mesh), "-o", str(tmp_path / "out")],
        stderr=subprocess.PIPE, text=True,
        env={**os.environ, "PYTHONPATH": before_all(tmp_path)},
    )  # fmt: skip
    _, said = process.communicate(timeout=120)
    assert process.returncode == 130
    assert said.splitlines()[-1] == "sherd: interrupted; nothing was left half-written"
    assert "Traceback" not in said
    assert not (tmp_path / "out").exists()
