"""Benchmarks between individuals and species: their truth, their cuts, their rows."""

from __future__ import annotations

import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.spatial import cKDTree

from sherd.benchmark.datasets.faust import faust_pairs, faust_set
from sherd.benchmark.datasets.landmark_truth import landmark_map
from sherd.benchmark.datasets.pairs import BenchmarkSettings
from sherd.benchmark.datasets.random_cuts import CUTS, random_cut
from sherd.benchmark.datasets.smal import smal_pairs, smal_set
from sherd.benchmark.match import measurement as match_measurement
from sherd.benchmark.match.benchmark import match_benchmark
from sherd.benchmark.match.measurement import measured
from sherd.benchmark.match.row import MatchRow
from sherd.benchmark.match.summary import summary, summary_table
from sherd.benchmark.row_file import restored_row
from sherd.cli.main import main
from sherd.errors import InputError, MeshFileError, OptionError
from sherd.files.mesh_files import write_mesh
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.match_options import MatchOptions
from sherd.scan.intake import Intake
from sherd.shapes.creature import creature
from sherd.spectral.sampling import remesh

MIRROR = np.array([1.0, -1.0, 1.0])


@pytest.fixture(scope="module")
def bodies() -> tuple[TriangleMesh, TriangleMesh]:
    """Two animals with one numbering: the second walks, and is longer and thinner."""
    walking = creature(5_000, pose="walk")
    return creature(5_000), walking.with_vertices(walking.vertices * [1.15, 0.95, 1.0])


@pytest.fixture(scope="module")
def meshed(bodies) -> list[tuple[TriangleMesh, SurfacePoints]]:
    """Both meshed on their own, with the places of the vertices on the old meshes."""
    return [
        remesh(body, factor * body.mean_edge_length)
        for body, factor in zip(bodies, (1.1, 1.2), strict=True)
    ]


def nearest(mesh: TriangleMesh, points: np.ndarray) -> np.ndarray:
    return cKDTree(mesh.vertices).query(points)[1]


def test_rounded_landmarks_give_a_map_finer_than_the_mesh(bodies, meshed) -> None:
    full, walking = bodies
    (target, _), (source, places) = meshed
    some = np.random.default_rng(0).permutation(full.vertex_count)[:4000]
    pairs = nearest(source, walking.vertices[some]), nearest(target, full.vertices[some])
    found = landmark_map(source, target, pairs, mirrored=False).positions(target)
    truth = places.positions(full)  # the same face and weights, in the other pose
    error = np.linalg.norm(found - truth, axis=1) / target.mean_edge_length
    assert error.mean() < 0.25
    assert np.quantile(error, 0.99) < 0.8
    rounded = np.linalg.norm(target.vertices[pairs[1]] - full.vertices[some], axis=1)
    assert error.mean() < 0.7 * rounded.mean() / target.mean_edge_length


def test_a_mirror_map_is_fitted_only_if_asked_for(bodies) -> None:
    full, _ = bodies
    other = TriangleMesh(full.vertices * MIRROR, full.faces[:, ::-1])
    every = np.arange(full.vertex_count)
    answers = landmark_map(full, other, (every, every), mirrored=True).positions(other)
    assert np.abs(answers - other.vertices).max() < 1e-9 * full.length
    turned = landmark_map(full, other, (every, every), mirrored=False).positions(other)
    assert np.abs(turned - other.vertices).max() > 1e-3 * full.length


def test_landmarks_that_do_not_suffice_are_refused(bodies) -> None:
    full, walking = bodies
    with pytest.raises(InputError, match=r"has 2 landmarks, .* 1"):
        landmark_map(full, walking, (np.array([0, 1]), np.array([0])), mirrored=False)
    few = np.arange(20)
    with pytest.raises(InputError, match="fewer than 6 landmarks within 8 edges"):
        landmark_map(full, walking, (few, few), mirrored=False)


@pytest.mark.parametrize("kind", CUTS)
def test_cuts_have_their_size_and_know_their_place(bodies, kind) -> None:
    body = bodies[1]
    sizes = []
    for seed in range(3):
        part = random_cut(body, kind, np.random.default_rng(seed))
        again = random_cut(body, kind, np.random.default_rng(seed))
        assert np.array_equal(part.mesh.vertices, again.mesh.vertices)
        assert np.allclose(part.truth.positions(body), part.mesh.vertices)
        assert part.mesh.component_count == 1
        sizes.append(part.mesh.area / body.area)
    assert 0.3 <= min(sizes) <= max(sizes) <= 0.8
    assert np.ptp(sizes) > 0.01


def test_unknown_cut(bodies) -> None:
    with pytest.raises(OptionError, match="quarters"):
        random_cut(bodies[0], "quarters", np.random.default_rng(0))


@pytest.fixture(scope="module")
def persons(bodies, meshed, tmp_path_factory) -> Path:
    """A folder in the layout of FAUST: person 0 in pose 0, person 1 in pose 1, twice as large."""
    home = tmp_path_factory.mktemp("faust")
    (home / "corres").mkdir()
    names = ("tr_reg_000", "tr_reg_011")
    for name, body, (mesh, _) in zip(names, bodies, meshed, strict=True):
        write_mesh(
            mesh.with_vertices(mesh.vertices * (2 if name[-1] == "1" else 1)), home / f"{name}.off"
        )
        np.savetxt(home / "corres" / f"{name}.vts", nearest(mesh, body.vertices) + 1, fmt="%d")
    standing, mesh = bodies[0], meshed[0][0]
    mirrored = nearest(mesh, standing.vertices * MIRROR)
    np.savetxt(home / "corres" / "tr_reg_000.sym.vts", mirrored + 1, fmt="%d")
    return home


def test_people_are_paired_with_others_in_other_poses(persons, tmp_path) -> None:
    pairs = faust_pairs(persons)
    assert [(pair.full.stem, pair.body.stem, pair.kind) for pair in pairs] == [
        (full, body, kind)
        for full, body in (("tr_reg_000", "tr_reg_011"), ("tr_reg_011", "tr_reg_000"))
        for kind in CUTS
    ]
    pair = pairs[0].load()
    assert 0.3 <= pair.part.area / pair.full.area <= 0.8  # of one size, whatever the files say
    there, mirrored = pair.truth.positions(pair.full), pair.mirrored_truth.positions(pair.full)
    off = np.linalg.norm(there * MIRROR - mirrored, axis=1)
    assert np.median(off) < pair.full.mean_edge_length
    assert pairs[3].load().mirrored_truth is None
    other = faust_pairs(persons, seed=1)[0].load()
    assert other.part.area != pair.part.area
    with pytest.raises(MeshFileError, match="two persons"):
        faust_pairs(tmp_path)


def test_faust_from_the_command_line(persons, tmp_path) -> None:
    name = "tr_reg_000_balls_of_tr_reg_011"
    arguments = ["bench", "faust", persons, "--rotate", "--only", name, "-o", tmp_path]
    done = CliRunner().invoke(main, [str(word) for word in arguments], standalone_mode=False)
    assert done.exception is None
    assert f"\n{name} " in done.output
    pair_set = faust_set(persons, BenchmarkSettings(rotate=True))
    document = match_benchmark(pair_set, tmp_path, only=(name,))
    (row,) = document["rows"]
    assert row["mean"] < 0.03
    assert row["mirror_forgiven"] == row["mean"]
    assert row["flips"] < 0.05
    assert row["iou"] > 0.85
    page = (tmp_path / "bench.html").read_text(encoding="utf-8")
    assert "mirror forgiven" in page
    assert "different people" in page


def _animal_parts(home: Path, front: TriangleMesh, back: TriangleMesh, table: np.ndarray) -> None:
    for folder in ("shapes", "maps"):
        (home / folder).mkdir(exist_ok=True)
    write_mesh(front, home / "shapes" / "cuts_1_cow_02.off")
    write_mesh(back, home / "shapes" / "cuts_3_dog_04.off")
    np.savetxt(home / "maps" / "cuts_1_cow_02_cuts_3_dog_04.vts", table, fmt="%d")


@pytest.fixture(scope="module")
def animals(bodies, tmp_path_factory) -> tuple[Path, np.ndarray]:
    """The front three fifths of the walking animal, and the rear four fifths of the other."""
    full, walking = bodies
    along = full.vertices[:, 0]
    faces = full.faces
    front, front_kept = walking.submesh((along > np.quantile(along, 0.4))[faces].all(axis=1))
    back, back_kept = full.submesh((along < np.quantile(along, 0.8))[faces].all(axis=1))
    number = np.full(full.vertex_count, -1)
    number[back_kept] = np.arange(len(back_kept))
    table = number[front_kept]
    home = tmp_path_factory.mktemp("smal")
    _animal_parts(home, front, back, table)
    return home, table


def test_rows_of_minus_one_have_no_place(animals) -> None:
    home, table = animals
    (source,) = smal_pairs(home)
    assert source.kind == "other species"
    pair = source.load()
    assert np.array_equal(pair.present, table >= 0)
    assert 0.5 < pair.present.mean() < 0.9
    hit = pair.truth.nearest_vertices(pair.full)
    assert np.array_equal(hit[pair.present], table[table >= 0])


def test_only_vertices_with_a_place_count_as_errors(animals, monkeypatch) -> None:
    """An answer that is right where there is one, and sure of it, has no error and full marks."""
    home, table = animals
    (source,) = smal_pairs(home)
    pair = source.load()

    answer = SimpleNamespace(
        points=pair.truth,
        matched=pair.present,
        confidence=np.where(pair.present, 0.9, 0.1),
        best=SimpleNamespace(mask=np.isin(np.arange(pair.full.vertex_count), table), score=0.8),
        status=SimpleNamespace(name="GOOD"),
        scale=1.0,
        twin_score=0.2,
        timings={"anchors": 1.0},
    )
    monkeypatch.setattr(match_measurement, "match", lambda *_: answer)
    row = measured(source, BenchmarkSettings())
    assert (row.mean, row.near, row.coverage, row.recognized, row.ranking) == (0, 1, 1, 1, 1)
    assert row.present == pair.present.mean()
    assert row.iou > 0.95
    assert row.iou_vertices == 1.0
    counts = np.array(row.confidence)
    assert counts[9].tolist() == [pair.present.sum(), pytest.approx(0.9), 1.0]
    assert counts[1].tolist() == [(~pair.present).sum(), pytest.approx(0.1), 0.0]
    answer.confidence = 1 - answer.confidence
    assert measured(source, BenchmarkSettings()).ranking == 0


def test_a_part_larger_than_the_full_shape_is_refused_and_counted(animals, tmp_path) -> None:
    home, table = animals
    (source,) = smal_pairs(home)
    pair = source.load()
    large = pair.part.with_vertices(3 * pair.part.vertices)
    _animal_parts(tmp_path, large, pair.full, table)
    document = match_benchmark(smal_set(tmp_path), tmp_path / "out")
    (row,) = document["rows"]
    assert (row["status"], row["mean"], row["iou"]) == ("REFUSED", None, None)
    assert document["together"]["refused"] == 1
    assert "all refused" in summary_table(document)
    again = restored_row(MatchRow, row)
    assert not again.answered
    assert np.isnan(again.mean)
    assert summary(smal_set(tmp_path), [again])["rows"] == [row]


def test_damaged_maps_are_refused(animals, tmp_path) -> None:
    table = animals[1]
    home = Path(shutil.copytree(animals[0], tmp_path / "smal"))
    (source,) = smal_pairs(home)
    np.savetxt(source.table, table[:-1], fmt="%d")
    with pytest.raises(MeshFileError, match="a row for each of the"):
        source.load()
    np.savetxt(source.table, np.full_like(table, 10**6), fmt="%d")
    with pytest.raises(MeshFileError, match="outside -1"):
        source.load()
    np.savetxt(source.table, np.full_like(table, -1), fmt="%d")
    with pytest.raises(MeshFileError, match="every row is -1"):
        source.load()
    with pytest.raises(MeshFileError, match="holds no files"):
        smal_pairs(home / "shapes")


def test_the_method_is_told_no_more_than_it_should_be(animals, monkeypatch) -> None:
    (source,) = smal_pairs(animals[0])
    asked = []

    def ask(_: object, part: Intake, options: MatchOptions) -> None:
        asked.append((part.original, options))
        raise RuntimeError

    monkeypatch.setattr(match_measurement, "match", ask)
    for settings in (
        BenchmarkSettings(),
        BenchmarkSettings(rotate=True),
        BenchmarkSettings(unknown_scale=True),
    ):
        with pytest.raises(RuntimeError):
            measured(source, settings)
    stored = source.load().part
    assert np.array_equal(asked[0][0].vertices, stored.vertices)
    turned = asked[1][0]
    assert turned.area == pytest.approx(stored.area)
    assert np.abs(turned.vertices - stored.vertices).max() > 0.1 * stored.length
    factor = asked[2][0].length / stored.length
    assert 0.5 <= factor <= 2
    assert factor != 1
    assert [options.scale for _, options in asked] == ["same", "same", "unknown"]
