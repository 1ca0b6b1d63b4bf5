"""Where compiled code is kept: nowhere is no error, and nothing stale or planted is loaded."""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import sherd
from sherd import compiled

ROOT = Path(sherd.__file__).parent
CODE = """
import numpy as np
from sherd.spectral.farthest_kernel import farthest_in_space
print(farthest_in_space(np.eye(3), 2, 0).tolist())
"""


def installed(folder: Path) -> Path:
    """A copy of the package whose `__pycache__` cannot be written, even by root."""
    skipped = shutil.ignore_patterns("__pycache__", "assets")
    shutil.copytree(ROOT, folder / "sherd", ignore=skipped)
    (folder / "sherd" / "__pycache__").write_text("in the way")
    return folder


def run(folder: Path, **settings: str) -> subprocess.CompletedProcess[str]:
    hidden = ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "LOCALAPPDATA")
    usual = {name: value for name, value in os.environ.items() if name not in hidden}
    environment = {**usual, "HOME": "/dev/null", "PYTHONPATH": str(folder), **settings}
    return subprocess.run(
        [sys.executable, "-c", CODE], capture_output=True, text=True, env=environment, check=False
    )


@pytest.mark.skipif(os.name == "nt", reason="names a home as POSIX does")
def test_a_read_only_installation_without_a_home_works_and_says_so_once(tmp_path) -> None:
    folder, temporary = installed(tmp_path), tmp_path / "temporary"
    temporary.mkdir()
    done = run(folder, TMPDIR=str(temporary))
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "[0, 1]"
    assert done.stderr.count("no lasting folder") == 1
    (kept,) = temporary.iterdir()
    assert kept.stat().st_mode & 0o077 == 0
    assert list(kept.rglob("*.nbi"))
    kept.chmod(0o777)  # anybody could have put code there: it is not used
    done = run(folder, TMPDIR=str(temporary))
    assert done.stdout.strip() == "[0, 1]"
    assert "compiles anew" in done.stderr
    done = run(folder, NUMBA_CACHE_DIR=str(tmp_path / "chosen"))
    assert done.stderr == ""
    assert list((tmp_path / "chosen").rglob("*.nbi"))


def test_a_renamed_tuple_or_a_new_version_gets_a_folder_of_its_own(tmp_path, monkeypatch) -> None:
    """A stale index names classes that are gone, and is loaded before its age is looked at."""
    folder = installed(tmp_path) / "sherd"
    monkeypatch.setattr(compiled, "ROOT", folder)
    before = compiled.kernel_hash.__wrapped__()
    (folder / "match.py").write_text("# no kernel\n")
    assert compiled.kernel_hash.__wrapped__() == before
    data = folder / "correspondence" / "labels" / "labeling_data.py"
    data.write_text(data.read_text().replace("class State(", "class Situation("))
    assert compiled.kernel_hash.__wrapped__() != before
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    names = set()
    for version in ("1", "2"):
        monkeypatch.setattr(compiled, "__version__", version)
        names.add(compiled.cache_folder.__wrapped__())
    assert len(names) == 2


def test_all_named_tuples_that_kernels_take_are_hashed() -> None:
    """Every kernel that takes one imports it, for the types or to document its arguments."""
    tuples = {
        path.relative_to(compiled.ROOT).as_posix()
        for path in compiled.ROOT.rglob("*.py")
        if "(NamedTuple):" in path.read_text() and not path.stem.endswith("_kernel")
    }
    taken = {
        name
        for name in tuples
        for kernel in compiled.ROOT.rglob("*_kernel.py")
        if f"from sherd.{name[:-3].replace('/', '.')} import" in kernel.read_text()
    }
    assert taken == set(compiled.TUPLES)


def test_other_users_of_numba_keep_their_settings() -> None:
    import numba  # noqa: PLC0415

    before = numba.config.CACHE_DIR
    compiled.compiled()(lambda x: x)
    assert before == numba.config.CACHE_DIR


def test_no_kernel_assigns_arrays_to_slices() -> None:
    """Numba compiles an error message that no kernel ever needs along with each: two seconds."""
    found = [
        f"{path.name}:{node.lineno}"
        for path in sorted(ROOT.rglob("*_kernel.py"))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Assign) and not isinstance(node.value, ast.Constant)
        for target in node.targets
        if isinstance(target, ast.Subscript)
        and any(isinstance(part, ast.Slice) for part in ast.walk(target.slice))
    ]
    assert found == []
