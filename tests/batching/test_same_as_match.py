"""A part of a batch is what `sherd match` makes of it alone, bit for bit but for the times."""

from __future__ import annotations

import json
import re
import shlex
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from sherd.batching.batch import batch
from sherd.batching.ledger.place import OUTCOME, THUMBNAIL
from sherd.batching.options import BatchOptions
from sherd.cli.main import main
from sherd.files.mesh_files import write_mesh
from sherd.results.match_options import MatchOptions
from sherd.shapes.creature import creature, landmarks
from sherd.shapes.fragment import cut_by_ball, moved, whole
from sherd.spectral.sampling import decimate


@pytest.fixture(scope="module")
def folders(tmp_path_factory) -> tuple[Path, Path]:
    """Of the part alone, and of the same part in a batch that was given the single one's words."""
    home = tmp_path_factory.mktemp("same")
    full = creature(5000)
    walking = whole(creature(5000, pose="walk"), full)
    piece = moved(
        cut_by_ball(walking, landmarks(full)["nose"], 0.55), np.random.default_rng(3)
    ).mesh
    write_mesh(decimate(full, 2000)[0], home / "full.ply")
    (home / "scans").mkdir()
    write_mesh(decimate(piece, 700)[0], home / "scans" / "head.ply")
    out = home / "out"
    with ThreadPoolExecutor(1) as here:
        result = batch(
            home / "full.ply", home / "scans", out, MatchOptions(seed=5), executor=here,
            batch_options=BatchOptions(min_confidence=0.1, exports=("map",)),
        )  # fmt: skip
    assert result.all_good, result.rows
    made = out / "parts" / "head"
    batched = made.rename(home / "batched")
    command = json.loads((batched / "result.json").read_text())["command"]
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(sys, "argv", shlex.split(command))
        done = CliRunner().invoke(main, sys.argv[1:])
    assert done.exit_code == 0, done.output
    return made, batched


def timeless(path: Path) -> object:
    if path.name == "result.json":
        document = json.loads(path.read_text())
        del document["timings"], document["files"]["report.html"]
        return document
    if path.name == "report.html":
        return re.sub(r"<h2>Seconds</h2>.*?</table>", "", path.read_text(), flags=re.DOTALL)
    return path.read_bytes()


def test_all_files_are_the_same_but_for_the_times(folders) -> None:
    alone, batched = folders
    names = {path.name for path in alone.iterdir()}
    assert {path.name for path in batched.iterdir()} == names | {OUTCOME, THUMBNAIL}
    assert "correspondence.map" in names
    for name in names:
        assert timeless(batched / name) == timeless(alone / name), name


def test_the_thumbnail_is_small(folders) -> None:
    assert 500 < (folders[1] / THUMBNAIL).stat().st_size < 12_000
