"""join: pieces of the generated animal without a whole, and one of something else."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import sherd
from sherd.cli.assembling import joined_summary
from sherd.errors import InfeasibleError, InputError, InvalidMeshError, OptionError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.puzzle.joined_report import joined_report
from sherd.report.stored.folder import folder_problems
from sherd.report.stored.stored_exhibit import read_exhibit
from sherd.results.puzzle.joined import Joined
from sherd.shapes import creature, cut_by_ball, landmarks, moved, puzzle_pieces, whole
from sherd.shapes.fragment import Fragment, noisy

SCHEMA = Path(__file__).parents[1] / "docs" / "schema" / "assembly-alone.json"


@pytest.fixture(scope="module")
def pieces() -> list[Fragment]:
    """Two pieces, each from the nose on, of two poses."""
    rng = np.random.default_rng(4)
    full, walking = creature(5000), creature(5000, pose="walk")
    nose = landmarks(full)["nose"]
    sizes = ((walking, 0.75), (full, 1.0))
    return [moved(cut_by_ball(whole(pose, full), nose, reach), rng) for pose, reach in sizes]


@pytest.fixture(scope="module")
def answer(pieces: list[Fragment], bottle: TriangleMesh) -> Joined:
    """Both, and a bottle with a twentieth of the area of the larger one."""
    own = [piece.mesh for piece in pieces]
    small = bottle.with_vertices(bottle.vertices * np.sqrt(0.05 * own[1].area / bottle.area))
    return sherd.join([*own, small])


def test_what_belongs_together_is_one_group_and_the_foreign_piece_is_alone(answer) -> None:
    assert answer.groups == ((0, 1), (2,))
    assert answer.group_of == (0, 0, 1)


def test_each_piece_has_its_points_on_the_others(answer, pieces) -> None:
    assert set(answer.maps) == {(0, 1), (1, 0)}
    for (here, there), found in answer.maps.items():
        rows = np.flatnonzero(found.matched)
        own, other = pieces[here], pieces[there]
        assert len(rows) > 0.5 * min(own.mesh.vertex_count, other.mesh.vertex_count)
        at = found.points[rows].interpolate(other.mesh, other.truth.positions(other.full))
        off = np.linalg.norm(at - own.truth[rows].positions(own.full), axis=1)
        assert off.mean() < 0.02 * own.full.length


def test_noisy_scans_are_joined_as_surely_as_clean_ones() -> None:
    full, walking = creature(5000), creature(5000, pose="walk")
    rng = np.random.default_rng(0)
    scans = [
        noisy(piece, 0.002, rng=rng) for piece in puzzle_pieces(full, [walking, full], overlap=0.5)
    ]
    found = sherd.join([scan.mesh for scan in scans])
    assert found.groups == ((0, 1),)
    assert found.sure
    assert found.pairs[0].chance > 0.85  # 0.72 where each is as noisy as its file
    assert all("noisy" in said[-1] for said in found.notices)
    there = found.maps[0, 1]
    rows = np.flatnonzero(there.matched)
    at = there.points[rows].interpolate(scans[1].mesh, scans[1].truth.positions(full))
    off = np.linalg.norm(at - scans[0].truth[rows].positions(full), axis=1)
    assert off.mean() < 0.015 * full.length


def test_files_are_written_and_read_back(answer, tmp_path) -> None:
    document = sherd.write_report(answer, tmp_path / "out")
    assert folder_problems(tmp_path / "out") == ()
    schema = json.loads(SCHEMA.read_text())
    jsonschema.validate(document, schema)
    assert set(document) == set(schema["properties"])
    assert document["full"] is None
    assert [piece["group"] for piece in document["pieces"]] == [0, 0, 1]
    rows = (tmp_path / "out" / "piece_0" / "partners.csv").read_text().splitlines()
    assert rows[0] == "part_vertex,piece,face,b0,b1,b2,vertex,confidence"
    assert {row.split(",")[1] for row in rows[1:]} == {"1"}
    largest = max(answer.pieces, key=lambda piece: piece.area)
    page = (tmp_path / "out" / "report.html").read_text()
    assert f"1 sqrt(area) of {largest.name} is {np.sqrt(largest.area):.4g}" in page
    exhibit = read_exhibit(tmp_path / "out")
    assert exhibit.part.vertex_count == sum(piece.vertex_count for piece in answer.pieces)
    assert exhibit.partner.known.any()


def test_one_piece_and_rigid_pieces_are_refused(pieces) -> None:
    with pytest.raises(InputError, match="two pieces are needed"):
        sherd.join([pieces[0].mesh])
    for option in ({"rigid": True}, {"may_overlap": True}, {"side": "given"}):
        with pytest.raises(OptionError, match="needs a whole"):
            sherd.join([piece.mesh for piece in pieces], **option)


def test_one_shape_instead_of_several_is_refused(pieces) -> None:
    with pytest.raises(InputError, match=r"write \[piece\]"):
        sherd.join(pieces[0].mesh)
    with pytest.raises(InputError, match=r"write \[piece\]"):
        sherd.join("piece.ply")


def test_another_unit_is_refused_with_the_factor(pieces) -> None:
    small = pieces[1].mesh.with_vertices(pieces[1].mesh.vertices / 1000)
    with pytest.raises(InfeasibleError, match="multiply the vertices of"):
        sherd.join([pieces[0].mesh, small])


def test_one_piece_of_another_unit_is_alone_and_the_others_are_joined(pieces, bottle) -> None:
    own = [piece.mesh for piece in pieces]
    far = bottle.with_vertices(bottle.vertices * 1000)
    found = sherd.join([own[0], far, own[1]])
    assert found.groups == ((0, 2), (1,))
    assert set(found.maps) == {(0, 2), (2, 0)}
    assert [pair.asked for pair in found.pairs] == [True, False, False]
    assert [len(said) for said in found.notices] == [0, 1, 0]
    assert "was not compared" in found.notices[1][0]
    assert "multiply the vertices of bottle by" in found.notices[1][0]
    exhibit = joined_report(found).exhibit
    assert exhibit.unit_of is own[1]
    assert np.ptp(exhibit.part.vertices, axis=0).max() < 10 * own[1].length
    assert any("1 bottle is drawn as large as the others" in said for said in exhibit.summary)
    assert any("was not compared" in said for said in exhibit.summary)


def test_what_is_only_likely_is_said_to_be_so(answer: Joined, tmp_path: Path) -> None:
    doubted = replace(answer, groups=((0, 1, 2),), likely={2: 0.6})
    document = sherd.write_report(doubted, tmp_path)
    jsonschema.validate(document, json.loads(SCHEMA.read_text()))
    assert [piece["likely"] for piece in document["pieces"]] == [None, None, 0.6]
    assert document["status"] == "good"
    assert "likely, 0.60" in joined_summary(doubted, tmp_path)
    report = (tmp_path / "report.html").read_text()
    assert "with a chance of 0.60" in report
    assert "twin" not in report
    assert not any(piece["by_twin"] for piece in document["pieces"])
    by_twin = replace(doubted, by_twin=(2,))
    told = sherd.write_report(by_twin, tmp_path / "twin")
    jsonschema.validate(told, json.loads(SCHEMA.read_text()))
    assert [piece["by_twin"] for piece in told["pieces"]] == [False, False, True]
    assert "likely by its twin, 0.60" in joined_summary(by_twin, tmp_path)
    assert "Only its twin tells" in (tmp_path / "twin" / "report.html").read_text()
    with pytest.raises(InvalidMeshError, match="chance"):
        replace(answer, by_twin=(1,))
    nothing_sure = replace(answer, likely={1: 0.6}, sure=False)
    assert sherd.write_report(nothing_sure, tmp_path / "doubtful")["status"] == "doubtful"


def test_what_belongs_without_a_place_is_said_to_do_so(answer: Joined, tmp_path: Path) -> None:
    unplaced = replace(answer, groups=((0, 1, 2),), unplaced=(2,))
    document = sherd.write_report(unplaced, tmp_path)
    jsonschema.validate(document, json.loads(SCHEMA.read_text()))
    assert [piece["unplaced"] for piece in document["pieces"]] == [False, False, True]
    summary = joined_summary(unplaced, tmp_path)
    assert "(belongs; where it lies is not known)" in summary
    assert summary.count("where it lies") == 1
    report = (tmp_path / "report.html").read_text()
    assert "belongs to its group, but where" in report
    assert "1 without a place" in report
    # also where only skin tells that two belong together
    verdict = joined_report(replace(unplaced, sure=False)).exhibit.verdict
    assert verdict.words == "Doubtful"
    assert "1 without a place" in verdict.advice
    with pytest.raises(InvalidMeshError, match="one of the pieces"):
        replace(answer, unplaced=(3,))
