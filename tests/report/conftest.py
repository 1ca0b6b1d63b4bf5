"""What the tests of reports share: the viewer with its packages."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
NPM = shutil.which("npm")
INSTALL = ["ci", "--engine-strict", "--ignore-scripts", "--no-audit", "--no-fund",
           "--prefer-offline", "--fetch-retries=1", "--fetch-retry-mintimeout=1000"]  # fmt: skip
# npm's words for a lock file that does not fit package.json or the packages: not the network.
BROKEN_LOCK = ("EUSAGE", "EINTEGRITY", "EJSONPARSE")


@pytest.fixture(scope="session")
def npm():
    """Runs npm with some words in a folder; skips where there is none."""
    if NPM is None or shutil.which("node") is None:
        pytest.skip(
            "no node or no npm in the path; what needs them is not tested (install Node.js)"
        )
    program = NPM

    def run(words: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [program, *words], cwd=folder, capture_output=True, text=True, timeout=300, check=False
        )

    return run


@pytest.fixture(scope="session")
def viewer(npm, tmp_path_factory) -> Path:
    """A copy of viewer/ with its packages installed; skips where npm cannot fetch them."""
    folder: Path = tmp_path_factory.mktemp("npm") / "viewer"
    shutil.copytree(ROOT / "viewer", folder, ignore=shutil.ignore_patterns("node_modules"))
    try:
        done = npm(INSTALL, folder)
    except subprocess.TimeoutExpired:
        pytest.skip("npm did not fetch the viewer's packages within five minutes")
    if done.returncode:
        assert not any(f"code {code}" in done.stderr for code in BROKEN_LOCK), done.stderr
        errors = [line for line in done.stderr.splitlines() if line.startswith("npm error")]
        pytest.skip(f"npm cannot fetch the viewer's packages ({'; '.join(errors[:2])})")
    return folder
