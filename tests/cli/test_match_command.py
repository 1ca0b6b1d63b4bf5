"""sherd match and sherd transfer from files to files."""

from __future__ import annotations

import csv
import json
import subprocess
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from sherd.files.mesh_files import read_mesh, write_mesh
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.stored.folder import folder_problems
from sherd.shapes.creature import creature, landmarks
from sherd.shapes.fragment import Fragment, cut_by_ball, moved, remeshed, whole

FILES = {
    "correspondence.csv", "correspondence.corr", "region.csv", "full.ply", "part.ply",
    "match.png", "report.html", "result.json",
}  # fmt: skip


@pytest.fixture(scope="module")
def fragment() -> Fragment:
    full = creature(5000)
    piece = cut_by_ball(whole(creature(5000, pose="walk"), full), landmarks(full)["nose"], 0.6)
    return moved(remeshed(piece, 1.1), np.random.default_rng(3))


@pytest.fixture(scope="module")
def files(fragment, tmp_path_factory) -> tuple[Path, Path]:
    """The full shape inside out, with a doubled face in front: repair turns and renumbers faces."""
    folder = tmp_path_factory.mktemp("files")
    full = fragment.full
    faces = full.faces[:, ::-1]
    spoiled = TriangleMesh(full.vertices, np.concatenate([faces[:1], faces]), fields=full.fields)
    write_mesh(spoiled, folder / "full.ply")
    write_mesh(fragment.mesh, folder / "part.ply")
    truth = fragment.truth
    (folder / "truth.baryc_gt").write_text(
        "\n".join(
            f"{face + 2} {' '.join(f'{w:.12g}' for w in weights[::-1])}"
            for face, weights in zip(truth.faces, truth.barycentric, strict=True)
        )
    )
    nose = landmarks(full)["nose"]
    near = np.linalg.norm(truth.positions(full) - full.vertices[nose], axis=1).argmin()
    (folder / "pairs.csv").write_text(f"part_vertex,full_vertex\n{near},{nose}\n")
    return folder / "full.ply", folder / "part.ply"


@pytest.fixture(scope="module")
def matched(run, files, tmp_path_factory) -> tuple[Path, subprocess.CompletedProcess[str]]:
    out = tmp_path_factory.mktemp("matched")
    folder = files[0].parent
    done = run(
        "match", *files, "-o", out, "--json", "--ground-truth", folder / "truth.baryc_gt",
        "--landmarks", folder / "pairs.csv", "--template", folder / "template.npz",
    )  # fmt: skip
    return out, done


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


def test_match_writes_everything_and_is_right(matched, fragment) -> None:
    out, done = matched
    assert done.returncode == 0, done.stderr
    assert {path.name for path in out.iterdir()} - {"alternatives.npz"} == FILES
    assert folder_problems(out) == ()
    result = json.loads(done.stdout)
    assert result["format"] == "sherd match 1"
    assert result["status"] == "good"
    assert result["ground_truth"]["mean_error_x100"] < 2
    assert result["check"]["passed"] is True
    assert "repaired for this run" in done.stderr
    assert len(rows_of(out / "correspondence.csv")) == fragment.mesh.vertex_count
    schema = Path(__file__).parents[2] / "docs" / "schema" / "match.json"
    jsonschema.validate(result, json.loads(schema.read_text()))


def test_answers_are_in_the_numbering_of_the_files(matched, files, fragment) -> None:
    """Places computed from the written faces and weights are near the truth."""
    rows = rows_of(matched[0] / "correspondence.csv")
    full = read_mesh(files[0])
    weights = np.array([[float(row[f"b{k}"]) for k in range(3)] for row in rows])
    corners = full.faces[[int(row["full_face"]) for row in rows]]
    places = (full.vertices[corners] * weights[:, :, None]).sum(axis=1)
    truth = fragment.truth.positions(fragment.full)
    error = np.linalg.norm(places - truth, axis=1) / fragment.full.length
    assert np.median(error) < 0.02
    nearest = corners[np.arange(len(rows)), weights.argmax(axis=1)]
    np.testing.assert_array_equal(nearest, [int(row["full_vertex"]) for row in rows])
    corr = (matched[0] / "correspondence.corr").read_text().splitlines()
    assert len(corr) == len(rows)
    for line, row in zip(corr, rows, strict=True):  # faces from 1; -1 where there is no partner
        face = int(row["full_face"]) + 1 if row["matched"] == "1" else -1
        assert int(float(line.split()[0])) == face


def test_template_is_made_once_and_refused_for_another_mesh(run, matched, files, tmp_path) -> None:
    assert matched[1].returncode == 0
    template = files[0].parent / "template.npz"
    assert template.exists()
    done = run("match", files[1], files[1], "-o", tmp_path / "out", "--template", template)
    assert done.returncode == 3
    assert "made for another mesh" in done.stderr
    assert not (tmp_path / "out").exists()


def test_transfer_of_labels_landmarks_and_meshes(run, matched, files, fragment, tmp_path) -> None:
    out, full = matched[0], fragment.full
    labels = tmp_path / "labels.csv"
    side = (full.vertices[:, 0] > np.median(full.vertices[:, 0])).astype(int)
    labels.write_text("vertex,side\n" + "".join(f"{i},{s}\n" for i, s in enumerate(side)))
    done = run("transfer", out, labels, "-o", tmp_path / "part.csv", "--labels")
    assert done.returncode == 0, done.stderr
    carried = np.array([int(row["side"]) for row in rows_of(tmp_path / "part.csv")])
    expected = side[fragment.truth.nearest_vertices(full)]
    assert (carried == expected).mean() > 0.95

    names = tmp_path / "landmarks.csv"
    names.write_text(f"name,vertex\nnose,{landmarks(full)['nose']}\n")
    assert run("transfer", out, names, "-o", tmp_path / "found.csv").returncode == 0
    (row,) = rows_of(tmp_path / "found.csv")
    assert row["name"] == "nose"
    truth = fragment.truth.positions(full)[int(row["vertex"])]
    assert np.linalg.norm(truth - full.vertices[landmarks(full)["nose"]]) < 0.1 * full.length

    assert run("transfer", out, files[0], "-o", tmp_path / "painted.ply").returncode == 0
    painted = read_mesh(tmp_path / "painted.ply")
    assert painted.vertex_count == fragment.mesh.vertex_count
    assert "segment" in painted.fields

    done = run("transfer", tmp_path, names, "-o", tmp_path / "x.csv")
    assert done.returncode == 3
    assert "result.json" in done.stderr


@pytest.mark.parametrize(
    ("option", "content", "words"),
    [
        ("--landmarks", "part_vertex,full_vertex\n0,99999999\n", "names vertex 99999999"),
        ("--landmarks", "a,b\n0,1\n", "has no column 'part_vertex'"),
        ("--landmarks", "part_vertex,full_vertex\n0,x\n", "row 2 of column full_vertex is 'x'"),
        ("--ignore", "", "is empty"),
        ("--ground-truth", "1 1 0 0\n", "rows"),
    ],
)
def test_bad_hints_end_in_one_line(run, option, content, words, files, tmp_path) -> None:
    hints = tmp_path / "hints.csv"
    if option == "--ground-truth":
        hints = tmp_path / "hints.baryc_gt"
    hints.write_text(content)
    done = run("match", *files, "-o", tmp_path / "out", option, hints)
    assert done.returncode == 3
    assert done.stderr.count("\n") == 1
    assert words in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--scale", "large"), "'large' is neither same, unknown nor a number"),
        (("--scale", "-2"), "a positive number is needed"),
        (("--part-unit", "mm"), "give both or none"),
        (("--part-unit", "mm", "--full-unit", "m", "--scale", "2"), "give one of them"),
    ],
)
def test_scales_and_units_that_cannot_be_are_refused(run, words, said, files, tmp_path) -> None:
    done = run("match", *files, "-o", tmp_path / "out", *words)
    assert done.returncode == 2
    assert said in done.stderr


def test_units_on_the_command_line_reach_the_question(run, files, tmp_path) -> None:
    """The piece would be a thousand times as large: refused before anything is matched."""
    words = ("--part-unit", "m", "--full-unit", "mm")
    done = run("match", *files, "-o", tmp_path / "out", *words)
    assert done.returncode == 3
    assert "once its lengths are multiplied by 1000" in done.stderr
