"""sherd overlap: its files, its exit code, and how it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from click.testing import CliRunner

from sherd.cli.main import main
from sherd.files.mesh_files import read_mesh, write_mesh
from sherd.report.stored.stored_exhibit import read_exhibit
from sherd.shapes.creature import creature, landmarks
from sherd.shapes.fragment import cut_by_ball, whole

SCHEMA = Path(__file__).parents[2] / "docs" / "schema" / "overlap.json"


@pytest.fixture(scope="module")
def answered(tmp_path_factory) -> tuple[Path, Path, Path, int]:
    """Two files, the folder of their overlap, and the exit code."""
    folder = tmp_path_factory.mktemp("overlap")
    full = creature(5000)
    nose = landmarks(full)["nose"]
    first, second = folder / "a.ply", folder / "b.ply"
    write_mesh(cut_by_ball(whole(full, full), nose, 0.8).mesh, first)
    walking = creature(5000, pose="walk")
    write_mesh(cut_by_ball(whole(walking, full), nose, 0.6).mesh, second)
    command = ["overlap", str(first), str(second), "-o", str(folder / "out"), "-q"]
    code = CliRunner().invoke(main, command).exit_code
    return first, second, folder / "out", code


def test_all_files_are_written_and_obey_their_schema(answered) -> None:
    first, second, out, code = answered
    document = json.loads((out / "result.json").read_text())
    jsonschema.validate(document, json.loads(SCHEMA.read_text()))
    assert set(document) == set(json.loads(SCHEMA.read_text())["properties"])
    assert code == (0 if document["status"] == "good" else 4)
    assert set(document["files"]) == {
        "correspondence.csv", "inverse.csv", "first_region.csv", "second_region.csv",
        "first.ply", "second.ply", "overlap.png", "report.html",
    }  # fmt: skip
    counts = {"first": read_mesh(first).vertex_count, "second": read_mesh(second).vertex_count}
    for name, header, rows in (
        (
            "correspondence.csv",
            "second_vertex,first_face,b0,b1,b2,first_vertex,matched,confidence",
            "second",
        ),
        (
            "inverse.csv",
            "first_vertex,second_face,b0,b1,b2,second_vertex,matched,confidence",
            "first",
        ),
        ("first_region.csv", "first_vertex,in_region,membership", "first"),
        ("second_region.csv", "second_vertex,in_region,membership", "second"),
    ):
        lines = (out / name).read_text().splitlines()
        assert lines[0] == header
        assert len(lines) == 1 + counts[rows]
    inside = np.genfromtxt(out / "second_region.csv", delimiter=",", names=True)["in_region"]
    matched = np.genfromtxt(out / "correspondence.csv", delimiter=",", names=True)["matched"]
    assert np.array_equal(inside, matched)
    assert "How alike is enough" in (out / "report.html").read_text()


def test_the_folder_is_shown_again(answered) -> None:
    exhibit = read_exhibit(answered[2])
    assert exhibit.names == ("First shape", "Second shape")
    assert exhibit.curve is not None
    assert exhibit.curve.chosen == 0.6


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["--strain", "0"], 2, "strain is 0"),
        (["--seed", "-1"], 2, "seed"),
        (["--landmarks", "missing.csv"], 3, "missing.csv: cannot be read"),
    ],
)
def test_wrong_words_are_refused_in_one_line(answered, tmp_path, words, code, said) -> None:
    first, second, _, _ = answered
    command = ["overlap", str(first), str(second), "-o", str(tmp_path / "out"), *words]
    result = CliRunner().invoke(main, command)
    assert result.exit_code == code
    assert said in result.output
    assert not (tmp_path / "out").exists()
