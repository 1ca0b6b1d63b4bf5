"""What cannot be written, or must not be replaced, is said before the work; quiet is quiet."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from sherd.cli.main import main
from sherd.files.mesh_files import read_mesh, write_mesh
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes.creature import creature, landmarks
from sherd.shapes.fragment import cut_by_ball, whole
from sherd.spectral.sampling import decimate


def call(*words: object) -> Result:
    return CliRunner().invoke(main, [str(word) for word in words])


@pytest.fixture(scope="module")
def pair(tmp_path_factory) -> tuple[Path, Path]:
    """The part has a doubled face, so that there is something to note."""
    folder = tmp_path_factory.mktemp("pair")
    animal = creature(5000)
    piece = cut_by_ball(whole(animal, animal), landmarks(animal)["nose"], 0.6).mesh
    piece = decimate(piece, 700)[0]
    spoiled = TriangleMesh(piece.vertices, np.concatenate([piece.faces, piece.faces[:1]]))
    write_mesh(decimate(animal, 2000)[0], folder / "animal.ply")
    write_mesh(spoiled, folder / "head.ply")
    return folder / "animal.ply", folder / "head.ply"


@pytest.mark.parametrize("command", ["match", "locate"])
def test_nothing_is_computed_for_an_output_that_is_refused(
    command, pair, tmp_path, monkeypatch
) -> None:
    def working(*_: object, **__: object) -> None:
        raise AssertionError("worked first")

    for module, name in (("matching", "match"), ("locating", "locate"), ("inputs", "Template")):
        monkeypatch.setattr(f"sherd.cli.{module}.{name}", working)
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis.txt").write_text("mine")
    done = call(command, *pair, "-o", tmp_path / "out", "--template", blocked / "t.npz")
    assert (done.exit_code, done.stderr.count("cannot be written")) == (5, 1)
    done = call(command, *pair, "-o", blocked)
    assert (done.exit_code, done.stderr.count("cannot be written")) == (5, 1)
    done = call(command, *pair, "-o", mine)
    assert (done.exit_code, done.stderr.count("holds thesis.txt")) == (5, 1)
    part = shutil.copy(pair[1], tmp_path / "part.ply")
    done = call(command, pair[0], part, "-o", tmp_path, "--overwrite")
    assert (done.exit_code, done.stderr.count("would be replaced")) == (5, 1)
    assert not (tmp_path / "out").exists()


def test_a_folder_is_used_again_by_its_own_command_only(pair, tmp_path) -> None:
    out, template = tmp_path / "out", tmp_path / "animal.npz"
    words = ("locate", *pair, "-o", out)
    done = call(*words, "--export", "npz", "--template", template)
    assert done.exit_code == 0, done.output
    assert f"template written: {template} (" in done.stderr
    assert "head.ply: repaired for this run" in done.stderr
    assert (out / "result.npz").exists()
    done = call(*words, "-q", "--template", template)
    assert (done.exit_code, done.stdout, done.stderr) == (0, "", "")
    assert not (out / "result.npz").exists()
    done = call("match", *pair, "-o", out)
    assert done.exit_code == 5
    assert "holds the region of head.ply on animal.ply" in done.stderr
    assert json.loads((out / "result.json").read_text())["format"] == "sherd region 1"
    done = call("demo", "-o", out)
    assert done.exit_code == 5


def test_repaired_and_written_is_success(pair, tmp_path) -> None:
    assert call("check", pair[1]).exit_code == 1
    done = call("check", pair[1], "--repair", tmp_path / "mended.ply")
    assert done.exit_code == 0
    assert call("check", tmp_path / "mended.ply").exit_code == 0
    assert read_mesh(tmp_path / "mended.ply").face_count == read_mesh(pair[1]).face_count - 1
