"""The command line as a user meets it: files, exit codes, one-line errors."""

from __future__ import annotations

import csv
import hashlib
import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

from sherd.files.mesh_files import read_mesh, write_mesh
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes.creature import creature, landmarks
from sherd.shapes.fragment import cut_by_ball, decimated, whole
from sherd.spectral.sampling import decimate

FILES = ("region.csv", "region.ply", "part.ply", "region.png", "report.html", "result.json")


@pytest.fixture(scope="module")
def pair(tmp_path_factory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("pair")
    animal, _ = decimate(creature(5000), 2000)
    nose = int(
        np.linalg.norm(
            animal.vertices - creature(5000).vertices[landmarks(creature(5000))["nose"]], axis=1
        ).argmin()
    )
    part = decimated(cut_by_ball(whole(animal, animal), nose, 0.6), 700).mesh
    write_mesh(animal, folder / "full.off")
    write_mesh(part, folder / "part.ply")
    return folder / "full.off", folder / "part.ply"


@pytest.fixture(scope="module")
def located(run, pair, tmp_path_factory) -> tuple[Path, subprocess.CompletedProcess[str]]:
    out = tmp_path_factory.mktemp("located") / "new" / "folder"
    return out, run("locate", *pair, "-o", out, "--json")


def test_locate_writes_all_files(located, pair) -> None:
    out, done = located
    assert done.returncode == 0, done.stderr
    assert sorted(path.name for path in out.iterdir()) == sorted(FILES)
    result = json.loads((out / "result.json").read_text())
    assert json.loads(done.stdout) == result
    assert result["format"] == "sherd region 1"
    assert result["status"] == "converged"
    assert 0 < result["area_fraction"] < 1
    assert result["check"]["passed"] is True
    assert set(result["timings"]) >= {"eigenbasis", "descriptors", "votes", "region"}
    for name, digest in result["files"].items():
        assert hashlib.sha256((out / name).read_bytes()).hexdigest() == digest
    assert result["command"].startswith("sherd locate ")
    assert str(pair[0]) in result["command"]


def test_numbers_agree_between_files(located, pair) -> None:
    out, _ = located
    with (out / "region.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    full = read_mesh(pair[0])
    assert [int(row["full_vertex"]) for row in rows] == list(range(full.vertex_count))
    colored = read_mesh(out / "region.ply")
    np.testing.assert_array_equal(colored.vertices, full.vertices)
    membership = np.array([float(row["membership"]) for row in rows])
    np.testing.assert_allclose(colored.fields["membership"], membership, atol=1e-6)
    inside = np.array([row["in_region"] == "1" for row in rows])
    part = read_mesh(pair[1])
    assert full.vertex_areas[inside].sum() == pytest.approx(part.area, rel=0.02)


def test_same_command_same_bytes(run, located, pair, tmp_path) -> None:
    run("locate", *pair, "-o", tmp_path)
    assert (tmp_path / "region.csv").read_bytes() == (located[0] / "region.csv").read_bytes()


def test_output_is_numbered_as_the_file_whatever_repair_did(run, pair, tmp_path) -> None:
    """Unreferenced vertices and a doubled face: rows for all vertices, and a visible notice."""
    full = read_mesh(pair[0])
    extra = np.concatenate([[[9.0, 9, 9]], full.vertices])
    faces = np.concatenate([full.faces + 1, full.faces[:1] + 1])
    write_mesh(TriangleMesh(extra, faces), tmp_path / "odd.off")
    done = run("locate", tmp_path / "odd.off", pair[1], "-o", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert "odd.off: repaired for this run" in done.stderr
    lines = (tmp_path / "out" / "region.csv").read_text().splitlines()
    assert len(lines) == len(extra) + 1
    assert lines[1] == "0,0,0"
    result = json.loads((tmp_path / "out" / "result.json").read_text())
    assert len(result["full"]["notices"]) == 2


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, "no such file"),
        (b"", "empty"),
        (b"OFF\n3 1 0\n0 0 0\n1 0 0\n", "truncated"),
        (b"OFF\n3 1 0\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n", "vertices[1, 1]"),
        (b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 9\n", "9"),
        (b"OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n", " points"),  # a part may be a point cloud
        (b"OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n", "no area"),
        (b"OFF\n1000000000000 1 0\n0 0 0\n", "1000000000000"),
    ],
)
@pytest.mark.parametrize("side", ["full", "part"])
def test_bad_files_end_in_one_line(run, content, words, side, pair, tmp_path) -> None:
    bad = tmp_path / "bad.off"
    if content is not None:
        bad.write_bytes(content)
    files = (bad, pair[1]) if side == "full" else (pair[0], bad)
    done = run("locate", *files, "-o", tmp_path / "out")
    assert done.returncode == 3
    assert done.stderr.count("\n") == 1
    assert "bad.off" in done.stderr
    assert words in done.stderr
    assert not (tmp_path / "out").exists()


def test_part_larger_than_full_is_refused(run, pair, tmp_path) -> None:
    done = run("locate", pair[1], pair[0], "-o", tmp_path / "out")
    assert done.returncode == 3
    assert "swapped" in done.stderr
    assert not (tmp_path / "out").exists()


def test_huge_coordinates_and_quads(run, located, pair, tmp_path) -> None:
    for file, name in zip(pair, ("full.ply", "part.ply"), strict=True):
        mesh = read_mesh(file)
        write_mesh(mesh.with_vertices(mesh.vertices * 2.0**30), tmp_path / name)
    done = run("locate", tmp_path / "full.ply", tmp_path / "part.ply", "-o", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    usual, huge = (
        np.loadtxt(folder / "region.csv", delimiter=",", skiprows=1)
        for folder in (located[0], tmp_path / "out")
    )
    # by a power of two, so that no coordinate is rounded: by 1e9 memberships near the border differ
    # by 0.03 to 0.06, on one processor more than on another
    np.testing.assert_array_equal(huge, usual)
    quad = tmp_path / "quad.off"
    quad.write_text("OFF\n4 1 0\n0 0 0\n.1 0 0\n.1 .1 0\n0 .1 0\n4 0 1 2 3\n")
    done = run("locate", pair[0], quad, "-o", tmp_path / "quad")
    assert done.returncode == 4, done.stderr  # a flat square fits anywhere
    assert "triangles" in done.stderr


def test_output_that_cannot_be_written(run, pair, tmp_path) -> None:
    (tmp_path / "file").write_text("in the way")
    done = run("locate", *pair, "-o", tmp_path / "file")
    assert done.returncode == 5
    assert "cannot be written" in done.stderr


def test_usage_errors(run, pair, tmp_path) -> None:
    assert run("locate", pair[0]).returncode == 2
    assert run("nonsense").returncode == 2
    done = run("locate", *pair, "-o", tmp_path / "out", "--basis-size", "1")
    assert done.returncode == 2
    assert "basis_size is 1" in done.stderr


def test_internal_errors_are_one_line(run, pair, tmp_path) -> None:
    (tmp_path / "sitecustomize.py").write_text(
        "import importlib\n"
        "m = importlib.import_module('sherd.locate')\n"
        "def broken(*a, **k): raise RuntimeError('boom')\n"
        "m.locate = broken\n"
    )
    done = run("locate", *pair, "-o", tmp_path / "out", modules=tmp_path)
    assert done.returncode == 70
    assert "internal error: RuntimeError: boom" in done.stderr
    assert "Traceback" not in done.stderr


def test_what_control_c_makes_of_compiled_code_is_no_internal_error(run, pair, tmp_path) -> None:
    (tmp_path / "sitecustomize.py").write_text(
        "import importlib\n"
        "m = importlib.import_module('sherd.locate')\n"
        "def ended(*a, **k): raise SystemError('kernel') from KeyboardInterrupt()\n"
        "m.locate = ended\n"
    )
    done = run("locate", *pair, "-o", tmp_path / "out", modules=tmp_path)
    assert done.returncode == 130
    assert "interrupted; nothing was left half-written" in done.stderr


def test_check_says_usable_repairable_or_not(run, pair, tmp_path) -> None:
    assert run("check", pair[0]).returncode == 0
    full = read_mesh(pair[0])
    doubled = TriangleMesh(full.vertices, np.concatenate([full.faces, full.faces[:3]]))
    write_mesh(doubled, tmp_path / "doubled.off")
    done = run("check", tmp_path / "doubled.off", "--repair", tmp_path / "mended.ply")
    assert done.returncode == 0
    assert "3 faces" in done.stdout
    assert read_mesh(tmp_path / "mended.ply").face_count == full.face_count
    (tmp_path / "no.off").write_text("OFF\n")
    assert run("check", tmp_path / "no.off").returncode == 3
    done = run("check", tmp_path / "no.off", "--json")
    assert done.returncode == 3
    assert json.loads(done.stdout)["usable"] == "unusable"


def test_help_loads_nothing_slow_and_is_on_one_screen(run) -> None:
    done = run("--help", PYTHONPROFILEIMPORTTIME="1")
    assert done.returncode == 0
    loaded = {line.rpartition("|")[2].strip().split(".")[0] for line in done.stderr.splitlines()}
    assert {"click", "sherd"} <= loaded
    assert not loaded & {"numpy", "numba", "scipy", "trimesh", "PIL"}
    assert len(done.stdout.splitlines()) <= 30
    assert "sherd match template.ply scan.ply -o out/" in done.stdout
    assert run("--version").stdout.strip().startswith("sherd, version")
