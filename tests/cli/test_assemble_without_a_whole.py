"""sherd assemble --no-full: its files, and how it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from sherd.cli.main import main
from sherd.files.mesh_files import write_mesh
from sherd.shapes import creature, cut_by_ball, landmarks, moved, whole


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> list[str]:
    """Three overlapping pieces, each from the nose on, of two poses."""
    rng = np.random.default_rng(4)
    full, walking = creature(5000), creature(5000, pose="walk")
    nose = landmarks(full)["nose"]
    folder = tmp_path_factory.mktemp("pieces")
    names = []
    for number, (pose, reach) in enumerate(((full, 0.75), (walking, 0.9), (full, 1.0))):
        names.append(str(folder / f"{number}.ply"))
        write_mesh(moved(cut_by_ball(whole(pose, full), nose, reach), rng).mesh, names[-1])
    return names


def test_pieces_are_joined_to_a_loop_that_closes(files, tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = CliRunner().invoke(main, ["assemble", "--no-full", *files, "-o", str(out)])
    assert done.exit_code == 0
    assert "together: 0 0.ply, 1 1.ply, 2 2.ply" in done.output
    document = json.loads((out / "result.json").read_text())
    assert document["groups"] == [[0, 1, 2]]
    assert document["cycle_after"] < 0.02
    partners = (out / "piece_0" / "partners.csv").read_text().splitlines()[1:]
    assert {row.split(",")[1] for row in partners} == {"1", "2"}


@pytest.mark.parametrize("option", [["--rigid"], ["--may-overlap"], ["--side", "given"]])
def test_what_needs_a_whole_is_refused_without_one(files, option, tmp_path: Path) -> None:
    words = ["assemble", "--no-full", *files, *option, "-o", str(tmp_path)]
    refused = CliRunner().invoke(main, words)
    assert refused.exit_code == 2
    assert "leave --no-full out" in refused.output
