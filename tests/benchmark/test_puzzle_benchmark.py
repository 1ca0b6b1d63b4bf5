"""Puzzles of the benchmark: cut with one right answer, measured, and kept."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from sherd.benchmark.puzzle import joining
from sherd.benchmark.puzzle.benchmark import puzzle_benchmark, puzzle_table, puzzle_totals
from sherd.benchmark.puzzle.measurement import BAD
from sherd.benchmark.puzzle.sources import KINDS, Puzzle, puzzle_sources
from sherd.errors import MeshFileError, OptionError
from sherd.files.mesh_files import write_mesh
from sherd.mesh.surface_points import closest_points
from sherd.shapes import creature


@pytest.fixture(scope="module")
def animals(tmp_path_factory) -> Path:
    """Two generated animals, one as arrays and one as a folder of meshes."""
    folder = tmp_path_factory.mktemp("animated")
    poses = [creature(5000), creature(5000, pose="walk")]
    np.savez(folder / "one.npz", vertices=[pose.vertices for pose in poses], faces=poses[0].faces)
    (folder / "two-poses").mkdir()
    for name, pose in (("rest_pose", "stand"), ("1", "walk")):
        mesh = creature(5000, pose=pose, individual=1)
        write_mesh(mesh, folder / "two-poses" / f"{name}.ply")
    return folder


def test_the_first_puzzles_are_of_all_kinds_and_numbers(animals) -> None:
    sources = puzzle_sources(animals)
    names = [source.name for source in sources]
    assert len(set(names)) == len(names)
    assert {source.kind for source in sources} == set(KINDS)
    assert {source.count for source in sources} == {2, 4, 8, 12}
    assert len({source.kind for source in sources[:12]}) > 2


@pytest.mark.parametrize("kind", KINDS)
def test_a_puzzle_has_what_its_kind_says(animals, kind) -> None:
    source = next(s for s in puzzle_sources(animals) if s.kind == kind and s.count == 4)
    puzzle = source.load()
    assert len(puzzle.foreign) == ("foreign" in kind)
    assert len(puzzle.own) == 4 - ("missing" in kind)
    assert (puzzle.labels < 0).any() == ("missing" in kind)
    areas = puzzle.full.vertex_areas
    covered = np.array([piece.region for piece in puzzle.own])
    twice = areas @ (covered.sum(axis=0) > 1) / areas.sum()
    assert (twice > 0.05) == (kind == "overlapping")
    row = np.arange(len(puzzle.labels))
    assert puzzle.allowed[np.where(puzzle.labels < 0, len(puzzle.own), puzzle.labels), row].all()
    assert (~puzzle.own[0].present).any() == (kind == "clutter")


def test_a_puzzle_is_measured_beside_single_matches_and_kept(animals, tmp_path) -> None:
    (row,) = puzzle_benchmark(animals, tmp_path, only=("one 2 disjoint",))
    assert row.together.labels > 0.97
    assert row.together.labels >= row.single.labels - 0.005
    assert max(row.together.errors) < 0.02 < BAD
    before = (tmp_path / "puzzle.json").read_bytes()
    assert puzzle_benchmark(animals, tmp_path, only=("one 2 disjoint",)) == [row]
    assert (tmp_path / "puzzle.json").read_bytes() == before
    assert "one 2 disjoint" in puzzle_table([row])
    assert puzzle_totals([row], "together")["own"] == 2


def test_pieces_without_a_whole_are_measured_and_kept(animals, tmp_path, monkeypatch) -> None:
    puzzle = joining.sources_of_joining(animals, 2)[0].load()
    assert len(puzzle.own) == 2
    assert len(puzzle.foreign) == 1
    answer = SimpleNamespace(
        groups=((0, 1), (2,)),
        pairs=[
            SimpleNamespace(first=0, second=1, joined=True),
            SimpleNamespace(first=0, second=2, joined=False),
        ],
        maps=_true_maps(puzzle),
        cycle_before=np.nan,
        cycle_after=np.nan,
        unplaced=(),
    )
    monkeypatch.setattr(joining, "join", lambda pieces: answer)
    (row,) = joining.join_benchmark(animals, tmp_path, count=2, limit=1)
    assert row.right
    assert (row.neighbors, row.joined, row.joined_right) == (1, 1, 1)
    assert row.error is not None
    assert row.error < 0.001
    assert row.known > 0.97
    before = (tmp_path / "join.json").read_bytes()
    assert joining.join_benchmark(animals, tmp_path, count=2, limit=1) == [row]
    assert (tmp_path / "join.json").read_bytes() == before
    assert "groups right in 1 of 1" in joining.join_table([row])
    assert "without a place" not in joining.join_table([row])
    answer.unplaced = (1,)
    (row,) = joining.join_benchmark(animals, tmp_path / "unplaced", count=2, limit=1)
    assert (row.right, row.unplaced) == (True, 1)
    assert "1 without a place" in joining.join_table([row])
    answer.groups, answer.pairs[0].joined, answer.pairs[1].joined = ((0, 2), (1,)), False, True
    (row,) = joining.join_benchmark(animals, tmp_path / "other", count=2, limit=1)
    assert (row.together, row.foreign_alone, row.right) == (1, False, False)
    assert (row.joined, row.joined_right) == (1, 0)
    assert "a foreign piece joined" in joining.join_table([row])


def test_puzzles_of_one_shape_have_names_of_their_own(animals, tmp_path) -> None:
    names = [source.name for source in joining.sources_of_joining(animals, 3, per_shape=10)]
    assert len(set(names)) == len(names) == 10 * len(joining.sources_of_joining(animals, 3)) // 2
    with pytest.raises(OptionError, match="per shape"):
        joining.join_benchmark(animals, tmp_path, per_shape=11)


def test_overlaps_of_any_width_are_cut_from_the_same_cells(animals) -> None:
    narrow = joining.sources_of_joining(animals, 3)[0]
    wide = joining.sources_of_joining(animals, 3, 0.4)[0]
    assert narrow.name != wide.name
    for one, other in zip(narrow.load().own, wide.load().own, strict=True):
        areas = one.full.vertex_areas
        assert areas @ (one.region & ~other.region) < 0.01 * areas @ one.region
        assert 1.2 < areas @ other.region / (areas @ one.region) < 1.35


def test_balls_have_one_area_and_overlap(animals) -> None:
    cells, balls = (
        joining.sources_of_joining(animals, 4, 0.5, cut)[0] for cut in ("cells", "balls")
    )
    assert cells.name != balls.name
    puzzle = balls.load()
    areas = puzzle.full.vertex_areas / puzzle.full.area
    regions = np.array([piece.region for piece in puzzle.own])
    np.testing.assert_allclose(regions @ areas, 1.5 / 4, atol=0.01)
    assert areas @ (regions.sum(axis=0) > 1) > 0.2
    with pytest.raises(OptionError, match="cells or balls"):
        joining.join_benchmark(animals, Path("out"), cut="slices")


def _true_maps(puzzle: Puzzle) -> dict[tuple[int, int], SimpleNamespace]:
    images = [piece.mesh.with_vertices(piece.truth.positions(puzzle.full)) for piece in puzzle.own]
    maps = {}
    for here, there in ((0, 1), (1, 0)):
        points = closest_points(images[there], images[here].vertices)
        off = np.linalg.norm(points.positions(images[there]) - images[here].vertices, axis=1)
        maps[here, there] = SimpleNamespace(points=points, matched=off < 0.01 * puzzle.full.length)
    return maps


def test_a_folder_without_animated_shapes_is_refused(tmp_path) -> None:
    with pytest.raises(MeshFileError, match="no animated shapes"):
        puzzle_sources(tmp_path)
