"""The assets of the page are what viewer/ builds; skips where npm cannot fetch its packages."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ASSETS = ROOT / "src" / "sherd" / "report" / "assets"
NPM = shutil.which("npm")
INSTALL = ["ci", "--engine-strict", "--ignore-scripts", "--no-audit", "--no-fund",
           "--prefer-offline", "--fetch-retries=1", "--fetch-retry-mintimeout=1000"]  # fmt: skip
# npm's words for a lock file that does not fit package.json or the packages: not the network.
BROKEN_LOCK = ("EUSAGE", "EINTEGRITY", "EJSONPARSE")

pytestmark = pytest.mark.skipif(
    NPM is None or shutil.which("node") is None,
    reason="no node or no npm in the path; the built assets are not compared (install Node.js)",
)


def npm(words: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    assert NPM is not None
    return subprocess.run(
        [NPM, *words], cwd=folder, capture_output=True, text=True, timeout=300, check=False
    )


@pytest.fixture
def viewer(tmp_path: Path) -> Path:
    """A copy of viewer/ with its packages installed."""
    folder = tmp_path / "viewer"
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


def test_assets_are_what_the_viewer_builds(viewer: Path, tmp_path: Path) -> None:
    built = tmp_path / "built"
    built.mkdir()
    done = npm(["run", "build", "--", str(built)], viewer)
    assert done.returncode == 0, done.stderr
    stored = {path.name: path.read_bytes() for path in ASSETS.iterdir()}
    fresh = {path.name: path.read_bytes() for path in built.iterdir()}
    names = sorted(stored.keys() | fresh.keys())
    differing = [name for name in names if stored.get(name) != fresh.get(name)]
    assert differing == [], "run `make viewer` and commit what changes in the assets"
