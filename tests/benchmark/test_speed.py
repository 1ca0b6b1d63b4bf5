"""Timings of commands, in turn with another installation."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import pytest

from sherd.benchmark import speed
from sherd.benchmark.speed import speed_benchmark, speed_table
from sherd.benchmark.timed_command import THIS, timed
from sherd.errors import SherdError
from sherd.files.mesh_files import read_mesh


def test_an_installation_is_as_fast_as_itself(tmp_path: Path) -> None:
    rows = speed_benchmark(tmp_path, works=("help",), repeats=2, against=shlex.join(THIS))
    (row,) = rows
    assert row.work == "help"
    assert row.ratio is not None
    assert row.least_ratio <= row.ratio <= row.largest_ratio
    assert 0.1 < row.ratio < 10
    assert row.peak_gigabytes > 0.005
    stored = json.loads((tmp_path / "speed.json").read_text(encoding="utf-8"))
    assert stored["rows"][0]["ratio"] == pytest.approx(row.ratio)
    assert "help" in speed_table(rows)


def test_the_part_is_half_of_the_animal(tmp_path: Path) -> None:
    speed._write_shapes(tmp_path, large=False)
    full, part = read_mesh(tmp_path / "full.ply"), read_mesh(tmp_path / "part.ply")
    assert full.vertex_count == pytest.approx(10_000, rel=0.05)
    assert part.vertex_count == pytest.approx(5_000, rel=0.05)
    assert len((tmp_path / "points.xyz").read_text().splitlines()) == part.vertex_count


def test_without_another_installation_there_is_no_ratio(tmp_path: Path) -> None:
    (row,) = speed_benchmark(tmp_path, works=("help",), repeats=1)
    assert row.ratio is None
    assert speed_table([row]).count("\n") == 1


def test_a_command_that_is_missing_or_fails_is_named() -> None:
    with pytest.raises(SherdError, match=r"no_such_sherd: cannot be started"):
        timed(["./no_such_sherd", "--help"])
    with pytest.raises(SherdError, match="exit code 2"):
        timed([*THIS, "match", "--no-such-option"])
