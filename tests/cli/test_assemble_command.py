"""sherd assemble: its files, its exit code, and how it refuses."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from click.testing import CliRunner

from sherd.cli.main import main
from sherd.files.mesh_files import read_mesh, write_mesh
from sherd.report.stored.folder import folder_problems
from sherd.report.stored.stored_exhibit import read_exhibit
from sherd.shapes import creature, puzzle_pieces

SCHEMA = Path(__file__).parents[2] / "docs" / "schema" / "assembly.json"


@pytest.fixture(scope="module")
def answered(tmp_path_factory) -> tuple[list[str], Path, int]:
    """The files of a puzzle with one piece twice, the folder of the answer, the exit code."""
    folder = tmp_path_factory.mktemp("puzzle")
    full = creature(5000)
    cut = puzzle_pieces(full, [creature(5000, pose="walk"), full, full])
    write_mesh(full, folder / "whole.ply")
    names = []
    for name, piece in zip(
        ("head.ply", "middle.ply", "again.ply"), (cut[0], cut[1], cut[1]), strict=True
    ):
        write_mesh(piece.mesh, folder / name)
        names.append(str(folder / name))
    files = [str(folder / "whole.ply"), *names]
    code = CliRunner().invoke(main, ["assemble", *files, "-o", str(folder / "out"), "-q"]).exit_code
    return files, folder / "out", code


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def test_all_files_are_written_and_obey_their_schema(answered) -> None:
    files, out, code = answered
    document = json.loads((out / "result.json").read_text())
    schema = json.loads(SCHEMA.read_text())
    jsonschema.validate(document, schema)
    assert set(document) == set(schema["properties"])
    assert code == (0 if document["status"] == "good" else 4)
    assert [piece["placed"] for piece in document["pieces"]].count(True) == 2
    assert folder_problems(out) == ()
    whole = read_mesh(Path(files[0]))
    labels = rows(out / "labels.csv")
    assert list(labels[0]) == ["full_vertex", "piece", "membership"]
    assert [int(row["full_vertex"]) for row in labels] == list(range(whole.vertex_count))
    placed = {k for k, piece in enumerate(document["pieces"]) if piece["placed"]}
    assert {int(row["piece"]) for row in labels} == placed | {-1}
    assert all(0 <= float(row["membership"]) <= 1 for row in labels)
    for number, piece in enumerate(document["pieces"]):
        assert (piece["file"] is None) == (not piece["placed"])
        if piece["placed"]:
            assert piece["file"] == f"piece_{number}/correspondence.csv"
            answers = rows(out / piece["file"])
            assert list(answers[0])[:2] == ["part_vertex", "full_face"]
            assert len(answers) == piece["vertices"]
        else:
            assert piece["instead"] in placed


def test_meshes_are_painted_with_one_color_a_piece(answered) -> None:
    _, out, _ = answered
    document = json.loads((out / "result.json").read_text())
    full = read_mesh(out / "full.ply")
    for number, piece in enumerate(document["pieces"]):
        part = read_mesh(out / f"piece_{number}" / "part.ply")
        assert part.vertex_count == piece["vertices"]
        own = np.unique(part.fields["piece"])
        assert len(own) == 1
        assert (own[0] == number) == piece["placed"]
        assert (number in np.unique(full.fields["piece"])) == piece["placed"]


def test_the_folder_can_be_looked_at_again_and_written_again(answered) -> None:
    files, out, code = answered
    exhibit = read_exhibit(out)
    document = json.loads((out / "result.json").read_text())
    assert exhibit.part.vertex_count == sum(piece["vertices"] for piece in document["pieces"])
    picture = CliRunner().invoke(main, ["view", str(out), "--png", "--width", "400", "-q"])
    assert picture.exit_code == 0
    (out / "view.png").unlink()
    again = CliRunner().invoke(main, ["assemble", *files, "-o", str(out), "-q"])
    assert again.exit_code == code
    both = [json.loads((out / "result.json").read_text())["files"], document["files"]]
    for files_ in both:
        files_.pop("report.html")  # it names the seconds
    assert both[0] == both[1]
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "is refused" in page


def test_the_page_names_refused_pieces_and_offers_no_landmarks(answered) -> None:
    """Landmarks and vertices to ignore cannot be given to this question."""
    _, out, _ = answered
    exhibit = read_exhibit(out)
    assert not exhibit.takes_hints
    assert '"takesHints":false' in (out / "report.html").read_text(encoding="utf-8")
    piece = next(layer for layer in exhibit.part_layers if layer.name == "piece")
    assert "refused" in {piece.labels[k] for k in np.unique(piece.values)}


def test_a_folder_with_others_files_is_not_touched(answered, tmp_path) -> None:
    files, _, _ = answered
    taken = tmp_path / "out" / "piece_0"
    taken.mkdir(parents=True)
    (taken / "correspondence.csv").write_text("mine")
    refused = CliRunner().invoke(main, ["assemble", *files, "-o", str(tmp_path / "out"), "-q"])
    assert refused.exit_code == 5
    assert "piece_0/correspondence.csv" in refused.output
    assert (taken / "correspondence.csv").read_text() == "mine"


def test_what_is_missing_or_wrong_is_said_in_a_line(answered, tmp_path) -> None:
    files, _, _ = answered
    runner = CliRunner()
    none = runner.invoke(main, ["assemble", files[0], "-o", str(tmp_path / "a")])
    assert none.exit_code == 2
    lost = runner.invoke(
        main, ["assemble", *files, str(tmp_path / "no.ply"), "-o", str(tmp_path / "b")]
    )
    assert lost.exit_code == 3
    assert "no.ply" in lost.output
    words = ["assemble", *files, "-o", str(tmp_path / "c"), "--tolerance"]
    for wrong, said in (([*words, "3", "--rigid"], "0.1"), ([*words, "0.02"], "give --rigid")):
        refused = runner.invoke(main, wrong)
        assert refused.exit_code == 2
        assert said in refused.output
    assert not (tmp_path / "c").exists()
