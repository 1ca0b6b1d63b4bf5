"""The assets of the page are what viewer/ builds; skips where npm cannot fetch its packages."""

from __future__ import annotations

from pathlib import Path

ASSETS = Path(__file__).parents[2] / "src" / "sherd" / "report" / "assets"


def test_assets_are_what_the_viewer_builds(viewer: Path, npm, tmp_path: Path) -> None:
    built = tmp_path / "built"
    built.mkdir()
    done = npm(["run", "build", "--", str(built)], viewer)
    assert done.returncode == 0, done.stderr
    stored = {path.name: path.read_bytes() for path in ASSETS.iterdir()}
    fresh = {path.name: path.read_bytes() for path in built.iterdir()}
    names = sorted(stored.keys() | fresh.keys())
    differing = [name for name in names if stored.get(name) != fresh.get(name)]
    assert differing == [], "run `make viewer` and commit what changes in the assets"
