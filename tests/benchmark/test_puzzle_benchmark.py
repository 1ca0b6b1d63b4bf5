"""Puzzles of the benchmark: cut with one right answer, measured, and kept."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sherd.benchmark.puzzle.benchmark import puzzle_benchmark, puzzle_table, puzzle_totals
from sherd.benchmark.puzzle.measurement import BAD
from sherd.benchmark.puzzle.sources import KINDS, puzzle_sources
from sherd.errors import MeshFileError
from sherd.files.mesh_files import write_mesh
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


def test_a_folder_without_animated_shapes_is_refused(tmp_path) -> None:
    with pytest.raises(MeshFileError, match="no animated shapes"):
        puzzle_sources(tmp_path)
