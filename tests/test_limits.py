"""Every number that can be typed has limits, and says why; memory is asked before it is taken."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from sherd import limits
from sherd.cli.main import main
from sherd.errors import OptionError
from sherd.files.mesh_files import write_mesh
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.locate_options import LocateOptions
from sherd.results.match_options import MatchOptions
from sherd.spectral.basis import eigenbasis


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("locate {} {} -o out --basis-size 100000", "basis_size is 100000, but a whole number"),
        ("locate {} {} -o out --method full --iterations 1000000", "iterations is 1000000"),
        (
            "locate {} {} -o out --method full --vocabulary-size 99999",
            "vocabulary_size is 99999",
        ),
        ("locate {} {} -o out --seed -1", "seed is -1"),
        ("locate {} {} -o out --smoothness 1e300", "smoothness is 1e+300"),
        ("match {} {} -o out --seed 99999999999999999999", "not read back exactly"),
        ("match {} {} -o out --min-confidence 2", "min_confidence is 2.0"),
        ("bench degrade --vertices 100000000 -o out", "vertex_count is 100000000"),
        ("bench size --largest 5 -o out", "largest is 5"),
        ("bench robustness . --seconds 0 -o out", "seconds is 0.0"),
        ("bench region . --limit 0", "limit is 0"),
    ],
)
def test_numbers_out_of_range_are_usage_errors_with_a_reason(words, said, tmp_path) -> None:
    mesh = tmp_path / "mesh.ply"
    write_mesh(TriangleMesh(np.eye(3), np.array([[0, 1, 2]])), mesh)
    done = CliRunner().invoke(main, words.format(mesh, mesh).split())
    assert done.exit_code == 2, done.output
    assert said in done.output
    assert "is needed" in done.output
    assert not (tmp_path / "out").exists()


def test_python_has_the_same_limits() -> None:
    with pytest.raises(OptionError, match="time grows with the square"):
        LocateOptions(basis_size=1001)
    with pytest.raises(OptionError, match="seed"):
        MatchOptions(seed=2**53)
    assert MatchOptions(seed=np.int64(3)).seed == 3


def test_free_memory_is_what_the_system_says_it_is(monkeypatch, tmp_path) -> None:
    """In bytes, whatever the system of the tests: its files are those of `tmp_path`."""
    monkeypatch.setattr(limits, "Path", lambda name: tmp_path / name.lstrip("/"))
    total = 3 * 10**9
    monkeypatch.setattr(os, "sysconf_names", {"SC_PHYS_PAGES": 0}, raising=False)
    pages = {"SC_PHYS_PAGES": total // 4000, "SC_PAGE_SIZE": 4000}
    monkeypatch.setattr(os, "sysconf", pages.__getitem__, raising=False)
    assert limits.available_memory() == total  # nobody says what is free
    (tmp_path / "proc").mkdir()
    (tmp_path / "proc/meminfo").write_text("MemTotal: 2000000 kB\nMemAvailable: 1000000 kB\n")
    assert limits.available_memory() == 1024 * 10**6
    group = tmp_path / "sys/fs/cgroup"
    group.mkdir(parents=True)
    for name, text in (("max", "900000000"), ("current", "500000000")):
        (group / f"memory.{name}").write_text(text)
    (group / "memory.stat").write_text("anon 400000000\ninactive_file 100000000\n")
    assert limits.available_memory() == 500_000_000  # the container's limit, its cache given back


def test_free_memory_here_is_a_part_of_all() -> None:
    free = limits.available_memory()
    if free is not None:
        assert free > 10**8  # in bytes: with less these tests could not run
    if Path("/proc/meminfo").exists():
        assert free is not None
        assert free < os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def test_memory_is_asked_before_it_is_taken(monkeypatch, exhibit_to_draw) -> None:
    from sherd.drawing.picture import picture  # noqa: PLC0415

    monkeypatch.setattr(limits, "available_memory", lambda: 10**5)
    with pytest.raises(OptionError, match=r"a basis of 50 eigenvectors needs about"):
        eigenbasis(exhibit_to_draw.full, 50)
    with pytest.raises(OptionError, match="a picture 5000 wide needs"):
        picture(exhibit_to_draw, width=5000)
    monkeypatch.undo()
    for width in (399, 100_000):
        with pytest.raises(OptionError, match=f"width is {width}"):
            picture(exhibit_to_draw, width=width)


@pytest.fixture
def exhibit_to_draw():
    import trimesh  # noqa: PLC0415

    from sherd.drawing.exhibit import Exhibit  # noqa: PLC0415

    ball = trimesh.creation.icosphere(subdivisions=3)
    mesh = TriangleMesh(ball.vertices, ball.faces)
    return Exhibit("ball", mesh, mesh)
