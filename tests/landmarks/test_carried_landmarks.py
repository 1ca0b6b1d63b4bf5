"""Landmarks carried to specimens: exact where the map is, missing where the specimen ends."""

from __future__ import annotations

import csv
import io
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from click.testing import CliRunner

from sherd.cli.many.landmarking import landmarks_command
from sherd.cli.transferring import transfer_command
from sherd.errors import InputError
from sherd.landmarks.attached import attached
from sherd.landmarks.carried import carry_landmarks, landmarks_of_part
from sherd.landmarks.landmark_files import read_landmarks, write_landmarks
from sherd.landmarks.landmark_list import Landmarks
from sherd.landmarks.landmark_table import landmark_table
from sherd.landmarks.several import geometric_median, median_landmarks
from sherd.mesh.surface_points import points_at_vertices
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.write import write_report
from sherd.results.match_options import MatchOptions
from sherd.results.match_result import MatchResult
from sherd.results.placement import Placement
from sherd.results.status import Status


@pytest.fixture(scope="module")
def result(exhibit_of_size, match_result_of) -> MatchResult:
    """The half with x > 0, turned, with an exact map; two of its vertices are unmatched."""
    exact = match_result_of(exhibit_of_size())
    return replace(exact, best=replace(exact.best, confidence=np.full(len(exact.points), 0.9)))


@pytest.fixture(scope="module")
def turn(result) -> np.ndarray:
    """(3, 3) with `specimen = template @ turn`."""
    return np.linalg.lstsq(result.positions, result.part.vertices, rcond=None)[0]


def _landmarks(result: MatchResult, vertices: list[int], **words: object) -> Landmarks:
    names = [f"L{k}" for k in range(len(vertices))]
    return Landmarks(names, result.full.vertices[vertices], **words)


def _inside(result: MatchResult, count: int) -> list[int]:
    """Vertices of the template well inside the region."""
    order = np.argsort(-result.full.vertices[:, 0])
    return order[: 8 * count : 8].tolist()


def test_landmarks_follow_an_exact_map(result, turn) -> None:
    landmarks = _landmarks(result, _inside(result, 5), space="LPS")
    carried = carry_landmarks(result, landmarks)
    np.testing.assert_allclose(carried.landmarks.positions, landmarks.positions @ turn, atol=1e-9)
    assert carried.status == ("good",) * 5
    np.testing.assert_allclose(carried.confidence, 0.9)
    assert carried.landmarks.space == "LPS"
    assert carried.notes[0] == "good, confidence 0.90"
    assert repr(carried) == "CarriedLandmarks('piece.ply': 5 good)"


def test_between_vertices_and_off_the_surface_the_foot_is_carried(result, turn) -> None:
    face = result.full.faces[np.argmax(result.full.vertices[result.full.faces].mean(axis=1)[:, 0])]
    middle = result.full.vertices[face].mean(axis=0)
    normal = result.full.vertex_normals[face].mean(axis=0)
    off = Landmarks(["a"], [middle + 0.002 * result.full.length * normal / np.linalg.norm(normal)])
    carried = carry_landmarks(result, off)
    apart = np.linalg.norm(carried.landmarks.positions[0] - middle @ turn)
    assert apart < 2e-4 * result.full.length


def test_what_the_specimen_lacks_is_missing(result) -> None:
    there, gone = _inside(result, 1)[0], int(result.full.vertices[:, 0].argmin())
    names = ["there", "gone", "unset"]
    positions = np.vstack([result.full.vertices[[there, gone]], np.full(3, np.nan)])
    carried = carry_landmarks(result, Landmarks(names, positions))
    assert carried.status == ("good", "missing", "missing")
    assert np.isnan(carried.landmarks.positions[1:]).all()
    assert np.isnan(carried.confidence[1:]).all()
    foreign = carry_landmarks(replace(result, status=Status.FOREIGN), Landmarks(names, positions))
    assert foreign.status == ("foreign",) * 3
    assert not foreign.landmarks.known.any()
    doubtful = replace(result, status=Status.DOUBTFUL)
    assert carry_landmarks(doubtful, Landmarks(names, positions)).status[0] == "doubtful"


def test_the_inner_side_of_a_thin_wall_is_not_taken() -> None:
    """A shell whose inner side passes nearer to the landmark than its outer side does."""
    ball = trimesh.creation.icosphere(subdivisions=3)
    count = len(ball.vertices)
    shell = TriangleMesh(
        np.vstack([ball.vertices, 0.99 * ball.vertices]),
        np.vstack([ball.faces, ball.faces[:, ::-1] + count]),
        name="shell",
    )
    # the map sinks: the outer side lies 0.004 below itself, the inner one 0.008 above
    sunk = np.concatenate([np.arange(count), np.arange(count) + count])
    places = points_at_vertices(shell, sunk)
    outward = shell.vertices * np.where(np.arange(2 * count) < count, 0.996, 1.008)[:, None]
    full = shell.with_vertices(outward)
    result = MatchResult(
        full=full,
        part=shell,
        best=Placement(
            mask=np.ones(2 * count, dtype=bool),
            membership=np.ones(2 * count),
            score=0.9,
            points=places,
            matched=np.ones(2 * count, dtype=bool),
            confidence=np.full(2 * count, 0.9),
        ),
        alternatives=(),
        scale=1.0,
        second_score=None,
        twin_score=None,
        status=Status.GOOD,
        timings={},
        options=MatchOptions(),
    )
    vertices = np.arange(0, count, 40)
    landmarks = Landmarks([str(k) for k in vertices], full.vertices[vertices])
    carried = carry_landmarks(result, landmarks)
    radii = np.linalg.norm(carried.landmarks.positions, axis=1)
    assert (radii > 0.995).all()  # the outer sheet of the specimen, not the inner one at 0.99


def test_other_axes_are_recognized(result) -> None:
    landmarks = _landmarks(result, _inside(result, 4), space="RAS").flipped()
    assert landmarks.space == "LPS"
    with pytest.raises(InputError, match=r"LPS and the mesh RAS \(--mesh-space RAS"):
        carry_landmarks(result, landmarks)
    carried = carry_landmarks(result, landmarks, mesh_space="RAS")
    straight = carry_landmarks(result, landmarks.flipped())
    np.testing.assert_array_equal(carried.landmarks.positions, straight.landmarks.positions)
    large = Landmarks(landmarks.names, 10 * landmarks.positions, space="LPS")
    with pytest.raises(InputError, match="are they of this mesh, and in its unit"):
        attached(large, result.full)


def test_there_and_back(result) -> None:
    landmarks = _landmarks(result, _inside(result, 3))
    there = carry_landmarks(result, landmarks).landmarks
    back = landmarks_of_part(result, attached(there, result.part))
    np.testing.assert_allclose(back.positions, landmarks.positions, atol=1e-9)


def test_the_median_of_templates(result) -> None:
    inside = _inside(result, 3)
    one = carry_landmarks(result, _landmarks(result, inside))
    shifted = replace(
        one,
        templates=("b",),
        landmarks=Landmarks(one.landmarks.names[::-1], one.landmarks.positions[::-1] + 0.3),
        confidence=one.confidence[::-1],
    )
    lost = replace(
        one,
        templates=("c",),
        landmarks=Landmarks(
            one.landmarks.names, np.vstack([one.landmarks.positions[:1], np.full((2, 3), np.nan)])
        ),
        status=("doubtful", "missing", "missing"),
        confidence=np.array([0.3, np.nan, np.nan]),
    )
    found = median_landmarks([one, shifted, lost])
    assert found.templates == ("w.ply", "b", "c")
    assert found.status == ("good",) * 3
    np.testing.assert_allclose(found.landmarks.positions[0], one.landmarks.positions[0], atol=1e-6)
    np.testing.assert_allclose(found.landmarks.positions[1], one.landmarks.positions[1] + 0.15)
    assert found.spread[0] == pytest.approx(0.0, abs=1e-6)
    assert found.spread[1] == pytest.approx(0.15 * np.sqrt(3))
    rare = median_landmarks([lost, replace(lost, templates=("d",)), one])
    assert rare.status == ("doubtful", "missing", "missing")
    foreign = replace(lost, status=("foreign",) * 3, templates=("e",))
    assert median_landmarks([foreign, one]).status == ("good",) * 3
    assert median_landmarks([foreign, foreign]).status == ("foreign",) * 3
    with pytest.raises(InputError, match="have no median"):
        median_landmarks([one, replace(one, specimen="other")])
    with pytest.raises(InputError, match="no landmarks are given"):
        median_landmarks([])
    renamed = replace(one, landmarks=Landmarks(["x", "y", "z"], one.landmarks.positions))
    with pytest.raises(InputError, match="landmarks of other names"):
        median_landmarks([one, renamed])


def test_the_geometric_median_is_the_least_sum_of_distances() -> None:
    rng = np.random.default_rng(0)
    for count in (1, 2, 3, 5, 8):
        points = rng.normal(size=(count, 3))
        middle = geometric_median(points)
        best = np.linalg.norm(points - middle, axis=1).sum()
        tried = middle + 1e-3 * rng.normal(size=(50, 3))
        others = np.linalg.norm(points[None] - tried[:, None], axis=2).sum(axis=1)
        assert (others >= best - 1e-9).all()
    outlier = np.array([[0, 0, 0], [0, 0, 0], [9.0, 0, 0]])
    np.testing.assert_allclose(geometric_median(outlier), 0, atol=1e-6)


def test_the_table_leaves_missing_ones_empty(result) -> None:
    there, gone = _inside(result, 1)[0], int(result.full.vertices[:, 0].argmin())
    carried = carry_landmarks(result, _landmarks(result, [there, gone]))
    rows = list(csv.DictReader(io.StringIO(landmark_table([carried, carried]))))
    assert len(rows) == 4
    assert rows[0]["specimen"] == "piece.ply"
    assert float(rows[0]["x"]) == pytest.approx(carried.landmarks.positions[0, 0])
    assert [rows[1][name] for name in ("x", "y", "z", "confidence", "spread")] == [""] * 5
    assert (rows[1]["status"], rows[1]["templates"]) == ("missing", "1")


@pytest.fixture(scope="module")
def folder(result, tmp_path_factory):
    path = tmp_path_factory.mktemp("landmarks")
    write_report(result, path / "out")
    inside = _inside(result, 3)
    write_landmarks(_landmarks(result, inside, space="RAS"), path / "points.fcsv")
    flipped = _landmarks(result, inside, space="LPS").flipped()
    write_landmarks(flipped, path / "flipped.mrk.json")
    return path


def _invoke(command, *words: object):
    return CliRunner().invoke(command, [str(word) for word in words])


def test_the_commands_read_and_write_files_of_slicer(folder, result, turn, tmp_path) -> None:
    wanted = result.full.vertices[_inside(result, 3)] @ turn
    out = tmp_path / "specimen.mrk.json"
    done = _invoke(transfer_command, folder / "out", folder / "points.fcsv", "-o", out)
    assert done.exit_code == 0, done.output
    found = read_landmarks(out)
    np.testing.assert_allclose(found.positions, wanted, atol=1e-6)
    assert found.space == "RAS"
    back = _invoke(transfer_command, folder / "out", out, "-o", tmp_path / "b.fcsv", "--to", "full")
    assert back.exit_code == 0, back.output
    np.testing.assert_allclose(
        read_landmarks(tmp_path / "b.fcsv").positions @ turn, wanted, atol=1e-6
    )
    table = tmp_path / "all.csv"
    words = ["--landmarks", f"w.ply={folder / 'flipped.mrk.json'}", "-o", table]
    refused = _invoke(landmarks_command, folder / "out", *words)
    assert "--mesh-space LPS" in str(refused.exception)
    assert not table.exists()
    done = _invoke(landmarks_command, folder / "out", *words, "--mesh-space", "LPS")
    assert done.exit_code == 0, done.output
    assert "piece.ply: 3 good" in done.output
    rows = list(csv.DictReader(io.StringIO(table.read_text())))
    np.testing.assert_allclose([float(row["z"]) for row in rows], wanted[:, 2], atol=1e-6)


def test_the_commands_refuse_what_does_not_belong_together(folder, tmp_path) -> None:
    out, points, table = folder / "out", folder / "points.fcsv", tmp_path / "all.csv"

    def said(*words: object) -> str:
        done = _invoke(landmarks_command, *words, "-o", table)
        return f"{done.output} {done.exception}"

    assert "name one of them" in said(out, out, "--landmarks", points)
    assert "of the template w.ply" in said(out, "--landmarks", f"v.ply={points}")
    assert "name each template once" in said(out, "--landmarks", points, "--landmarks", points)
    both = ["--landmarks", points, "--landmarks", f"w.ply={points}"]
    assert "name each" in said(out, *both)
    assert not table.exists()
