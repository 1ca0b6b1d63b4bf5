"""Folders looked at again, files for other programs, and results in notebooks."""

from __future__ import annotations

import base64
import csv
import io
import json
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
import scipy.io
from click.testing import CliRunner
from PIL import Image

import sherd
from sherd.cli.main import main
from sherd.errors import InputError, OptionError
from sherd.report.exports import MAP_EXPORTS, SHAPE_EXPORTS, exported
from sherd.report.notebook import exhibit_of, plot, show
from sherd.report.stored.stored_exhibit import read_exhibit
from sherd.report.stored.stored_match import read_match
from sherd.report.write import report_of, write_report
from sherd.result_folder import NAMES
from sherd.results.advice import Doubts, UnfollowedLandmark
from sherd.results.match_result import MatchResult


@pytest.fixture(scope="module")
def result(match_result_of, exhibit) -> MatchResult:
    return match_result_of(exhibit)


@pytest.fixture(scope="module")
def folder(result, tmp_path_factory):
    out = tmp_path_factory.mktemp("match")
    errors = np.linspace(0, 0.1, result.part.vertex_count)
    document = write_report(result, out, errors=errors, exports=SHAPE_EXPORTS + MAP_EXPORTS)
    assert set(document["files"]) <= NAMES  # others might be taken for the user's, or replaced
    return out


def named(layers, name):
    return next(layer for layer in layers if layer.name == name)


def test_a_folder_shows_again_what_the_report_showed(result, folder) -> None:
    errors = np.linspace(0, 0.1, result.part.vertex_count)
    before = report_of(result, errors=errors).exhibit
    again = read_exhibit(folder)
    assert again.verdict == before.verdict
    assert again.title == before.title
    for side in ("full_layers", "part_layers"):
        assert [layer.name for layer in getattr(again, side)] == [
            layer.name for layer in getattr(before, side)
        ]
        for old, new in zip(getattr(before, side), getattr(again, side), strict=True):
            assert (old.kind, old.limits, old.color_map) == (new.kind, new.limits, new.color_map)
            np.testing.assert_allclose(new.values, old.values, atol=1e-12)
    np.testing.assert_array_equal(again.region, before.region)


def test_the_picture_drawn_again_is_the_picture_of_the_folder(folder) -> None:
    with Image.open(folder / "match.png") as image:
        stored = np.asarray(image.convert("RGB"), dtype=float)
    again = np.asarray(plot(read_exhibit(folder)).convert("RGB"), dtype=float)
    assert again.shape == stored.shape
    assert np.abs(again - stored).mean() < 0.2


def test_orientation_finds_exactly_the_faces_that_are_turned_over(result, exhibit) -> None:
    assert (named(exhibit_of(result).part_layers, "orientation").values == 1).all()
    # exchanging the answers of two neighbors turns over some faces around them and no others
    a, b = result.part.edges[40]
    order = np.arange(result.part.vertex_count)
    order[[a, b]] = b, a
    wrong = MatchResult(
        **{
            **{name: getattr(result, name) for name in result.__dataclass_fields__},
            "best": replace(result.best, points=result.points[order]),
        }
    )
    share = named(exhibit_of(wrong).part_layers, "orientation").values
    touched = np.unique(result.part.faces[np.isin(result.part.faces, [a, b]).any(axis=1)])
    assert share[[a, b]].max() < 1
    untouched = np.setdiff1d(np.arange(result.part.vertex_count), touched)
    assert (share[untouched] == 1).all()


def test_landmarks_that_were_not_followed_are_written_and_read_back(result, tmp_path) -> None:
    wrong = (UnfollowedLandmark(3, 5, 0.25, (7,)), UnfollowedLandmark(7, 9, 0.125))
    doubts = Doubts(unfollowed=wrong)
    options = sherd.MatchOptions(landmarks=((3, 5), (7, 9)), part_unit="mm", full_unit="cm")
    asked = replace(
        result,
        status=doubts.status,
        advice=doubts.advice,
        unfollowed_landmarks=doubts.unfollowed,
        options=options,
    )
    document = write_report(asked, tmp_path / "out")
    assert document["advice"] == doubts.advice
    assert document["unfollowed_landmarks"][0]["distance"] == 0.25
    again = sherd.read_match(tmp_path / "out")
    assert again.unfollowed_landmarks == wrong
    assert (again.status, again.advice) == (doubts.status, doubts.advice)
    assert again.options == options
    assert "part vertex 3 on full vertex 5" in (tmp_path / "out" / "report.html").read_text("utf-8")


def test_scipy_reads_the_mat_file_counted_from_one(result, folder) -> None:
    stored = scipy.io.loadmat(folder / "result.mat")
    np.testing.assert_array_equal(stored["full_faces"] - 1, result.full.faces)
    np.testing.assert_array_equal(stored["full_face"].ravel() - 1, result.points.faces)
    np.testing.assert_allclose(stored["barycentric"], result.points.barycentric)
    np.testing.assert_array_equal(stored["region"].ravel(), result.best.mask)
    assert stored["error"].shape == (result.part.vertex_count, 1)


def test_numpy_reads_the_npz_file_counted_from_zero(result, folder) -> None:
    with np.load(folder / "result.npz") as stored:
        np.testing.assert_array_equal(stored["part_faces"], result.part.faces)
        np.testing.assert_array_equal(stored["full_face"], result.points.faces)
        np.testing.assert_allclose(stored["confidence"], result.confidence)


def test_vertex_maps_count_from_zero_and_one(result, folder) -> None:
    zero = np.loadtxt(folder / "correspondence.map", dtype=int)
    one = np.loadtxt(folder / "correspondence.vts", dtype=int)
    matched = result.matched
    nearest = result.points.nearest_vertices(result.full)
    np.testing.assert_array_equal(zero[matched], nearest[matched])
    np.testing.assert_array_equal(one[matched], nearest[matched] + 1)
    assert (zero[~matched] == -1).all()


def test_paraview_files_hold_what_the_map_carries(result, folder) -> None:
    root = ET.parse(folder / "part.vtp").getroot()  # noqa: S314  our own text
    arrays = {array.get("Name"): array for array in root.iter("DataArray")}
    assert {"confidence", "orientation", "error", "correspondence"} <= set(arrays)
    raw = base64.b64decode(arrays["thickness_from_the_file"].text)[8:]
    carried = np.frombuffer(raw, dtype="<f8")
    expected = result.points.interpolate(result.full, result.full.fields["thickness"])
    expected[~result.matched] = np.nan
    np.testing.assert_allclose(carried, expected)


@pytest.mark.parametrize("side", ["full", "part"])
def test_paraview_files_have_the_colors_of_the_others(side, folder) -> None:
    root = ET.parse(folder / f"{side}.vtp").getroot()  # noqa: S314  our own text
    texts = {array.get("Name"): array.text for array in root.iter("DataArray")}
    raw = base64.b64decode(texts["correspondence"])[8:]
    painted = sherd.read_mesh(folder / f"{side}.ply").fields["color"]
    np.testing.assert_array_equal(
        np.frombuffer(raw, dtype=np.uint8).reshape(-1, 3), np.rint(255 * painted)
    )


def test_same_result_same_exported_bytes(exhibit) -> None:
    kinds = ("vtp", "glb", "npz", "mat", "map", "vts")
    assert exported(exhibit, kinds) == exported(exhibit, kinds)
    assert scipy.io.loadmat(io.BytesIO(exported(exhibit, ["mat"])["result.mat"]))


def test_exports_refuse_what_they_cannot_write(exhibit_of_size, exhibit) -> None:
    with pytest.raises(OptionError, match=r"\.vts file holds a map"):
        exported(exhibit_of_size(1, partner=None, alternatives=()), ["vts"])
    with pytest.raises(OptionError, match="stl"):
        exported(exhibit, ["stl"])


def test_results_are_shown_and_plotted(result) -> None:
    assert sherd.show is show
    assert "<iframe" in sherd.show(result)._repr_html_()
    image = sherd.plot(result, layer="confidence", width=500)
    assert image.width == 500
    with pytest.raises(OptionError, match="nonsense"):
        sherd.plot(result, layer="nonsense")


def test_match_stays_a_function_although_a_module_has_its_name() -> None:
    assert callable(sherd.match)
    assert callable(sherd.Template)


@pytest.mark.parametrize("change", ["no file", "other format", "another run"])
def test_folders_that_hold_no_result_are_refused(change, folder, tmp_path) -> None:
    for file in folder.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    document = json.loads((tmp_path / "result.json").read_text())
    if change == "no file":
        (tmp_path / "result.json").unlink()
    elif change == "other format":
        (tmp_path / "result.json").write_text(json.dumps(document | {"format": "soup 7"}))
    else:
        (tmp_path / "full.ply").write_bytes(b"ply")
    words = {"no file": "nothing was finished", "other format": "soup 7", "another run": "full.ply"}
    with pytest.raises(InputError, match=words[change]):
        read_exhibit(tmp_path)


def test_unsure_vertices_become_unmatched_and_the_folder_remembers(result, tmp_path) -> None:
    sure = result.with_min_confidence(0.6)
    np.testing.assert_array_equal(sure.matched, result.matched & (result.confidence >= 0.6))
    np.testing.assert_array_equal(sure.points.faces, result.points.faces)
    assert sure.with_min_confidence(0.1).min_confidence == 0.6
    assert result.min_confidence == 0
    document = write_report(sure, tmp_path)
    assert document["min_confidence"] == 0.6
    assert document["unmatched"] == (~sure.matched).sum() > (~result.matched).sum()
    stored = read_match(tmp_path)
    assert stored.min_confidence == 0.6
    np.testing.assert_array_equal(stored.matched, sure.matched)
    with pytest.raises(OptionError, match=r"min_confidence is 1\.5"):
        result.with_min_confidence(1.5)


def test_text_labels_and_gaps_are_carried(result, tmp_path) -> None:
    write_report(result, tmp_path / "out")
    full, part = result.full, result.part
    nearest, matched = result.nearest_vertices, result.matched
    bones = np.where(full.vertices[:, 1] > 0, "femur, left", "tibia")
    named = np.arange(full.vertex_count)[5:]  # the first five are not in the table

    def carried(rows, *options: str) -> tuple[int, str, list[dict[str, str]]]:
        (tmp_path / "in.csv").write_text("\n".join(["vertex,bone,height", *rows]) + "\n")
        words = ["transfer", tmp_path / "out", tmp_path / "in.csv", "-o", tmp_path / "to.csv"]
        done = CliRunner().invoke(main, [*map(str, words), *options])
        if done.exit_code:
            return done.exit_code, done.output, []
        with (tmp_path / "to.csv").open(newline="") as stream:
            return 0, done.output, list(csv.DictReader(stream))

    rows = [f'{v},"{bones[v]}",' for v in named]
    code, output, table = carried(rows, "--labels")
    assert code == 0, output
    found = np.array([row["bone"] for row in table])
    known = matched & (nearest >= 5)
    assert (found[known] == bones[nearest[known]]).all()
    assert (found[~known] == "").all()
    assert {row["height"] for row in table} == {"-1"}
    code, output, _ = carried(rows)
    assert code == 3
    assert f"row 2 of column bone is '{bones[named[0]]}', not a number" in output

    numbers = [f"{v},1,{full.vertices[v, 2]}" for v in named]
    _, _, table = carried(numbers)
    height = np.array([float(row["height"]) for row in table])
    np.testing.assert_allclose(height[known], full.vertices[nearest[known], 2], atol=1e-6)
    assert np.isnan(height[~known]).all()
    assert len(table) == part.vertex_count
    _, _, table = carried(numbers, "--labels", "--min-confidence", "1")
    assert carried(["7,a,1", "9,b,2", "7,c,3"], "--labels")[1].count("vertex 7 is there twice")
    assert "names vertex 99999" in carried(["99999,1,1"])[1]
    assert "no whole number" in carried(["1,2,0.5"], "--labels")[1]
