"""sherd fit: its files, what reads them, and how it refuses."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import trimesh
from click.testing import CliRunner

import sherd
from sherd.cli.main import main
from sherd.errors import InputError
from sherd.files.mesh_files import read_mesh
from sherd.report.stored.folder import folder_problems
from sherd.report.stored.stored_exhibit import read_exhibit
from sherd.report.stored.stored_fit import read_fit
from sherd.report.write import write_report

SCHEMA = Path(__file__).parents[2] / "docs" / "schema" / "fit.json"


def asked(*words: object):
    return CliRunner().invoke(main, [str(word) for word in words])


@pytest.fixture(scope="module")
def folders(match_result_of, exhibit_of_size, tmp_path_factory):
    """A match, its folder, and the folder of its fit."""
    folder = tmp_path_factory.mktemp("fit")
    match = match_result_of(exhibit_of_size(4))
    write_report(match, folder / "match")
    done = asked("fit", "--from", folder / "match", "-o", folder / "fit", "--merge")
    assert done.exit_code == 0, done.output
    return match, folder / "match", folder / "fit"


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def test_all_files_are_written_and_obey_their_schema(folders) -> None:
    match, _, out = folders
    document = json.loads((out / "result.json").read_text())
    schema = json.loads(SCHEMA.read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(document, schema)
    assert set(document) == set(schema["properties"])
    assert folder_problems(out) == ()
    assert set(document["files"]) == {
        "fit.ply", "fit.obj", "fit.glb", "fit.csv", "full.ply", "piece_0/part.ply",
        "piece_0/distances.csv", "completed.ply", "fit.png", "report.html",
    }  # fmt: skip
    fitted = read_mesh(out / "fit.ply")
    assert np.array_equal(fitted.faces, match.full.faces)
    table = rows(out / "fit.csv")
    assert list(table[0]) == [
        "vertex", "x", "y", "z", "seen", "chance", "distance", "strain", "size"
    ]  # fmt: skip
    assert np.allclose([float(row["x"]) for row in table], fitted.vertices[:, 0], atol=1e-6)
    assert document["completion"]["watertight"]
    origin = read_mesh(out / "completed.ply").fields["origin"]
    assert set(np.unique(origin)) == {-1, 0}


def test_the_folder_is_read_back_and_shown(folders) -> None:
    match, _, out = folders
    again = read_fit(out)
    assert again.full.vertex_count == match.full.vertex_count
    assert set(again.full.fields) == {"thickness"}
    assert again.options.merge
    assert again.seen.any()
    exhibit = read_exhibit(out)
    assert [layer.name for layer in exhibit.full_layers][:3] == [
        "correspondence", "distance", "seen"
    ]  # fmt: skip
    assert exhibit.part.vertex_count == match.part.vertex_count


def test_the_glb_morphs_from_the_full_shape_to_the_fit(folders) -> None:
    match, _, out = folders
    data = (out / "fit.glb").read_bytes()
    length = int.from_bytes(data[12:16], "little")
    header, content = json.loads(data[20 : 20 + length]), data[28 + length :]

    def array(number: int) -> np.ndarray:
        accessor = header["accessors"][number]
        view = header["bufferViews"][accessor["bufferView"]]
        start = view["byteOffset"]
        raw = content[start : start + view["byteLength"]]
        return np.frombuffer(raw, "<f4").reshape(accessor["count"], 3)

    primitive = header["meshes"][0]["primitives"][0]
    before = array(primitive["attributes"]["POSITION"])
    step = array(primitive["targets"][0]["POSITION"])
    fitted = read_mesh(out / "fit.ply")
    assert np.allclose(before + step, fitted.vertices, atol=1e-5)
    shift = before - match.full.vertices
    assert np.ptp(shift, axis=0).max() < 1e-5
    assert header["meshes"][0]["extras"] == {"targetNames": ["fit"]}
    assert header["accessors"][primitive["targets"][0]["POSITION"]]["max"] is not None
    loaded = trimesh.load(out / "fit.glb", process=False)
    (shape,) = loaded.geometry.values()
    assert len(shape.vertices) == match.full.vertex_count


def test_the_obj_keeps_the_texture_of_the_full_shape(folders, tmp_path) -> None:
    """A picture of two halves: vertices of the seam have two places in it."""
    match, matched, _ = folders
    full = match.full
    corners = [
        "f " + " ".join(f"{corner + 1}/{1 + (k < full.face_count // 2)}" for corner in face)
        for k, face in enumerate(full.faces.tolist())
    ]
    lines = [f"v {x} {y} {z}" for x, y, z in full.vertices.tolist()]
    file = tmp_path / "textured.obj"
    file.write_text("\n".join(["mtllib skin.mtl", *lines, "vt 0 0", "vt 1 1", *corners]) + "\n")
    done = asked("fit", "--from", matched, "-o", tmp_path / "fit", "--texture", file)
    assert done.exit_code == 0, done.output
    written = (tmp_path / "fit" / "fit.obj").read_text().splitlines()
    assert [line for line in written if line[0] != "v"] == ["mtllib skin.mtl", *corners]
    assert "vt 1 1" in written
    fitted = read_mesh(tmp_path / "fit" / "fit.ply")
    assert np.allclose(read_mesh(tmp_path / "fit" / "fit.obj").vertices, fitted.vertices)
    refused = asked("fit", file, file, "-o", tmp_path / "other", "--texture", file)
    assert refused.exit_code == 2
    assert "--texture is for --from" in refused.output
    with pytest.raises(InputError, match="a texture is for a fit"):
        write_report(match, tmp_path / "other", texture=file)


def test_transfer_marks_landmarks_that_nothing_was_seen_of(folders, tmp_path) -> None:
    match, _, out = folders
    fitted = read_fit(out)
    hidden, known = int(np.flatnonzero(~fitted.seen)[7]), int(np.flatnonzero(fitted.seen)[7])
    (tmp_path / "landmarks.csv").write_text(f"name,vertex\ntail,{hidden}\nnose,{known}\n")
    done = asked("transfer", out, tmp_path / "landmarks.csv", "-o", tmp_path / "there.csv")
    assert done.exit_code == 0, done.output
    table = rows(tmp_path / "there.csv")
    assert [row["extrapolated"] for row in table] == ["1", "0"]
    place = np.array([[float(row[axis]) for axis in "xyz"] for row in table])
    assert np.allclose(place, fitted.positions[[hidden, known]], atol=1e-6)
    values = "vertex,height\n" + "".join(
        f"{k},{z}\n" for k, z in enumerate(match.full.vertices[:, 2])
    )
    (tmp_path / "values.csv").write_text(values)
    asked("transfer", out, tmp_path / "values.csv", "-o", tmp_path / "height.csv")
    carried = np.array([float(row["height"]) for row in rows(tmp_path / "height.csv")])
    right = match.field_to_part(match.full.vertices[:, 2])
    both = np.isfinite(carried) & np.isfinite(right)
    assert both.mean() > 0.9
    assert np.abs(carried - right)[both].max() < 0.05
    back = asked(
        "transfer", out, tmp_path / "height.csv", "-o", tmp_path / "back.csv", "--to", "full"
    )
    assert back.exit_code == 0, back.output
    assert "nan" in {row["height"] for row in rows(tmp_path / "back.csv")}
    refused = asked("transfer", out, tmp_path / "values.csv", "-o", tmp_path / "n", "--piece", 4)
    assert refused.exit_code == 2
    assert "--piece is 4" in refused.output


def test_landmarks_of_other_programs_go_along_a_fit(folders, tmp_path) -> None:
    match, _, out = folders
    fitted = read_fit(out)
    chosen = [int(np.flatnonzero(~fitted.seen)[7]), int(np.flatnonzero(fitted.seen)[7])]
    given = sherd.Landmarks(["tail", "nose"], match.full.vertices[chosen], space="LPS")
    sherd.write_landmarks(given, tmp_path / "template.mrk.json")
    for name in ("scan.mrk.json", "scan.csv"):
        done = asked("transfer", out, tmp_path / "template.mrk.json", "-o", tmp_path / name)
        assert done.exit_code == 0, done.output
    there = sherd.read_landmarks(tmp_path / "scan.mrk.json")
    assert there.space == "LPS"
    assert np.allclose(there.positions, fitted.positions[chosen], atol=1e-6)
    assert [row["extrapolated"] for row in rows(tmp_path / "scan.csv")] == ["1", "0"]
    words = ("transfer", out, tmp_path / "template.mrk.json", "-o", tmp_path / "n.csv")
    assert asked(*words, "--to", "full").exit_code == 2


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "give FULL and PART, or --from"),
        (["one.ply"], "at least one PART"),
        (["a.ply", "b.ply", "--from", "c"], "give FULL and PART, or --from"),
        (["--from", "c", "--scale", "unknown"], "which --from has done"),
        (["a.ply", "b.ply", "c.ply", "--scale", "2"], "--scale is for one"),
        (["a.ply", "b.ply", "--near", "7"], "near is 7"),
    ],
)
def test_usage_errors(words, said, tmp_path) -> None:
    done = asked("fit", *words, "-o", tmp_path / "out")
    assert done.exit_code == 2
    assert said in done.output
    assert not (tmp_path / "out").exists()


def test_what_is_no_match_is_refused(folders, tmp_path) -> None:
    _, matched, out = folders
    done = asked("fit", "--from", out, "-o", tmp_path / "out")
    assert done.exit_code == 3
    assert "not the result of match or assemble" in done.output
    taken = asked("fit", "--from", matched, "-o", matched)
    assert taken.exit_code == 5
    assert "choose another folder" in taken.output
