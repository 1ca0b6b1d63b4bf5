"""`sherd batch --landmarks`: from one template or several to every specimen, in one table."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from sherd.batching.specimens import folders_by_template
from sherd.cli.exits import USAGE
from sherd.cli.main import main
from sherd.errors import InputError
from sherd.files.mesh_files import write_mesh
from sherd.landmarks.landmark_files import write_landmarks
from sherd.landmarks.landmark_list import Landmarks
from sherd.shapes.creature import creature, landmarks
from sherd.shapes.fragment import cut_by_ball, whole
from sherd.spectral.sampling import decimate

# The specimen's kind is larger than the first template and smaller than the second.
FACTORS = {"small": 1 / 1.08, "large": 1.08}


@pytest.fixture(scope="module")
def home(tmp_path_factory) -> Path:
    """Two templates with landmarks, and the front of a walking animal."""
    path = tmp_path_factory.mktemp("skulls")
    full = creature(5000)
    spots = landmarks(full)
    names = [name for name in spots if "nose" in name or "tail" in name]
    positions = full.vertices[[spots[name] for name in names]]
    coarse = decimate(full, 2000)[0]
    for name, factor in FACTORS.items():
        write_mesh(coarse.with_vertices(coarse.vertices * factor), path / f"{name}.ply")
        write_landmarks(Landmarks(names, positions * factor), path / f"{name}.fcsv")
    (path / "scans").mkdir()
    walking = whole(creature(5000, pose="walk"), full)
    head = cut_by_ball(walking, spots["nose"], 0.55).mesh
    write_mesh(decimate(head, 700)[0], path / "scans" / "head.ply")
    np.savetxt(path / "nose.txt", walking.mesh.vertices[spots["nose"]])
    return path


def rows_of(path: Path) -> dict[str, dict[str, str]]:
    with path.open(newline="") as stream:
        return {row["landmark"]: row for row in csv.DictReader(stream)}


def test_several_templates_are_all_asked_and_their_median_is_taken(home) -> None:
    words = ["batch", *(str(home / f"{name}.ply") for name in FACTORS)]
    words += ["--parts", str(home / "scans"), "-o", str(home / "out"), "--jobs", "1", "-q"]
    for name in FACTORS:
        words += ["--landmarks", f"{name}.ply={home / name}.fcsv"]
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 0, done.output
    rows = rows_of(home / "out" / "landmarks.csv")
    nose = rows.pop("nose")
    found = np.array([float(nose[axis]) for axis in "xyz"])
    size = np.sqrt(creature(5000).area)
    assert np.linalg.norm(found - np.loadtxt(home / "nose.txt")) < 0.03 * size
    assert (nose["templates"], nose["status"]) == ("2", "good")
    assert 0 < float(nose["spread"]) < 0.03 * size
    assert rows  # and the tail, which the piece lacks, is missing
    assert {(row["status"], row["x"]) for row in rows.values()} == {("missing", "")}
    for name, factor in FACTORS.items():
        made = home / "out" / "by_template" / name / "parts" / "head" / "result.json"
        document = json.loads(made.read_text())
        assert "--fit-scale" in document["command"]
        # a first answer at the wrong size gives way to it, so most of the difference is found
        assert 0.5 < np.log(document["scale"]) / np.log(factor) < 1.1


def test_templates_of_one_name_and_a_scale_that_is_fitted_anyway_are_refused(home) -> None:
    with pytest.raises(InputError, match="templates of one name, skull"):
        folders_by_template([Path("a/skull.ply"), Path("b/skull.ply")], home)
    words = ["batch", str(home / "small.ply"), "--parts", str(home / "scans")]
    words += ["-o", str(home / "no"), "--scale", "unknown", "--fit-scale"]
    done = CliRunner().invoke(main, words)
    assert done.exit_code == USAGE
    assert "fitted anyway" in done.stderr
    assert not (home / "no").exists()
