"""The Blender extension: files and command without Blender; with `bpy`, objects in a scene."""

from __future__ import annotations

import csv
import importlib.util
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import sherd
from sherd.files.mesh_files import read_mesh, write_mesh
from sherd.shapes import creature, cut_by_ball, whole

ROOT = Path(__file__).parents[2]
EXTENSION = ROOT / "extras" / "blender"
TRIANGLE = [(0.0, 0.0, 0.0), (1.0 / 3.0, 0.0, 0.0), (0.0, 1e7, 0.0)]


def loaded(name: str, path: Path):
    spec = importlib.util.spec_from_file_location(
        name, path, submodule_search_locations=[str(path.parent)]
    )
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def exchange():
    return loaded("sherd_blender_exchange", EXTENSION / "exchange.py")


@pytest.fixture(scope="module")
def shapes():
    animal = creature(5000)
    return animal, cut_by_ball(whole(creature(5000, pose="walk"), animal), 0, 0.5).mesh


@pytest.fixture(scope="module")
def matched(exchange, shapes, tmp_path_factory) -> Path:
    """The folder that the command writes for what the extension wrote."""
    folder = tmp_path_factory.mktemp("blender")
    for name, mesh in zip(("full", "part"), shapes, strict=True):
        exchange.write_ply(
            folder / f"{name}.ply", [tuple(v) for v in mesh.vertices.tolist()], mesh.faces.tolist()
        )
    words = exchange.match_command("sherd", folder)
    done = subprocess.run(
        [sys.executable, "-m", *words], capture_output=True, text=True, check=False
    )
    assert exchange.failure(done.returncode, done.stderr) is None
    return folder / "out"


def test_sherd_reads_the_very_numbers_that_were_written(exchange, tmp_path) -> None:
    exchange.write_ply(tmp_path / "a.ply", TRIANGLE, [(2, 0, 1)])
    mesh = read_mesh(tmp_path / "a.ply")
    np.testing.assert_array_equal(mesh.vertices, TRIANGLE)
    np.testing.assert_array_equal(mesh.faces, [[2, 0, 1]])


def test_the_command_is_refused_before_it_starts(exchange, tmp_path) -> None:
    words = exchange.match_command(" /opt/my sherd/bin/sherd ", tmp_path, scale="unknown")
    assert words[:2] == ["/opt/my sherd/bin/sherd", "match"]
    assert words[words.index("--scale") + 1] == "unknown"
    with pytest.raises(ValueError, match="where the sherd command is"):
        exchange.match_command("  ", tmp_path)
    with pytest.raises(ValueError, match="'tiny'"):
        exchange.match_command("sherd", tmp_path, scale="tiny")


def test_only_a_missing_answer_is_a_failure(exchange) -> None:
    assert exchange.failure(0, "a warning") is None
    assert exchange.failure(4, "") is None
    assert exchange.failure(3, "Traceback\nError: part.ply is empty\n\n") == (
        "Error: part.ply is empty"
    )
    assert "exit code 70" in exchange.failure(70, "")


def test_the_answer_is_that_of_the_files(exchange, matched, shapes) -> None:
    answer = exchange.read_answer(matched)
    result = sherd.read_match(matched)
    np.testing.assert_array_equal(answer.matched, result.matched)
    np.testing.assert_allclose(answer.confidence, result.confidence, atol=1e-8)
    np.testing.assert_array_equal(answer.region, result.best.mask)
    assert answer.doubtful == (result.status is not sherd.Status.GOOD)
    for colors, name in ((answer.full_colors, "full"), (answer.part_colors, "part")):
        wanted = read_mesh(matched / f"{name}.ply").fields["color"]
        np.testing.assert_allclose(np.array(colors)[:, :3], wanted, atol=1e-12)
        assert (np.array(colors)[:, 3] == 1).all()


def test_other_files_are_refused(exchange, matched, shapes, tmp_path) -> None:
    for file in matched.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    write_mesh(shapes[1], tmp_path / "part.ply")
    with pytest.raises(ValueError, match=r"part\.ply has no colors"):
        exchange.read_answer(tmp_path)
    (tmp_path / "part.ply").write_text("ply\nformat ascii 1.0\nend_header\n")
    with pytest.raises(ValueError, match="no binary PLY"):
        exchange.read_answer(tmp_path)
    (tmp_path / "correspondence.csv").write_text("part_vertex,matched\n0,1\n")
    with pytest.raises(ValueError, match="no column confidence"):
        exchange.read_answer(tmp_path)


def test_rows_count_by_their_vertex_not_by_their_line(exchange, matched, tmp_path) -> None:
    for file in matched.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    head, *lines = (matched / "correspondence.csv").read_text().splitlines()
    (tmp_path / "correspondence.csv").write_text("\n".join([head, *reversed(lines)]) + "\n")
    assert exchange.read_answer(tmp_path) == exchange.read_answer(matched)


def test_the_manifest_names_the_version_of_sherd() -> None:
    manifest = tomllib.loads((EXTENSION / "blender_manifest.toml").read_text(encoding="utf-8"))
    assert manifest["version"] == sherd.__version__
    assert manifest["license"] == ["SPDX:MIT"]


@pytest.fixture(scope="module")
def bpy():
    if "pymeshlab" in sys.modules:
        pytest.skip("bpy and pymeshlab bring different versions of Embree: run this file alone")
    return pytest.importorskip(
        "bpy", reason="Blender as a module (bpy) is not installed: see docs/contributing.md"
    )


@pytest.fixture
def extension(bpy):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    module = loaded("sherd_match", EXTENSION / "__init__.py")
    module.register()
    yield module
    module.unregister()


@pytest.fixture
def pair(bpy, shapes):
    """Both shapes in a scene; the part is moved, and enlarged and mirrored back in its object."""
    things = []
    for name, mesh in zip(("whole", "piece"), shapes, strict=True):
        data = bpy.data.meshes.new(name)
        stored = mesh.vertices.copy()
        if name == "piece":
            stored *= [-0.5, 0.5, 0.5]
        faces = mesh.faces[:, ::-1] if name == "piece" else mesh.faces
        data.from_pydata(stored.tolist(), [], faces.tolist())
        thing = bpy.data.objects.new(name, data)
        bpy.context.collection.objects.link(thing)
        things.append(thing)
    things[1].scale = (-2.0, 2.0, 2.0)
    things[1].location = (3.0, 0.0, 0.0)
    bpy.context.view_layer.update()
    for thing in things:
        thing.select_set(True)
    bpy.context.view_layer.objects.active = things[0]
    return things


def weights(thing, name: str) -> np.ndarray:
    group = thing.vertex_groups[name].index
    return np.array(
        [
            sum(member.weight for member in vertex.groups if member.group == group)
            for vertex in thing.data.vertices
        ]
    )


def test_blender_writes_what_stands_in_the_scene(extension, pair, shapes) -> None:
    for thing, mesh, shift in zip(pair, shapes, ([0, 0, 0], [3, 0, 0]), strict=True):
        vertices, triangles = extension.world_mesh(thing)
        np.testing.assert_allclose(vertices, mesh.vertices + shift, atol=1e-5)
        # a triangle may start at another of its corners
        start = np.argmin(triangles, axis=1)[:, None]
        turned = np.take_along_axis(np.array(triangles), (start + np.arange(3)) % 3, axis=1)
        start = np.argmin(mesh.faces, axis=1)[:, None]
        wanted = np.take_along_axis(mesh.faces, (start + np.arange(3)) % 3, axis=1)
        np.testing.assert_array_equal(turned, wanted)


def test_blender_shows_the_match_on_both_objects(bpy, extension, pair, tmp_path) -> None:
    program = tmp_path / "sherd"
    program.write_text(
        f'#!/bin/sh\ncp "$3" "{tmp_path}/part.ply"\n"{sys.executable}" -m sherd "$@"\n'
        f'code=$?\ncp -r "$5" "{tmp_path}/kept"\nexit $code\n'
    )
    program.chmod(0o755)
    bpy.context.scene.sherd.command = str(program)
    assert bpy.ops.object.sherd_match() == {"FINISHED"}
    whole_object, piece = pair
    with (tmp_path / "kept" / "correspondence.csv").open() as file:
        rows = list(csv.DictReader(file))
    known = np.array([row["matched"] == "1" for row in rows])
    confidence = np.array([float(row["confidence"]) for row in rows])
    np.testing.assert_allclose(
        weights(piece, "sherd_confidence"), np.where(known, confidence, 0), atol=1e-6
    )
    np.testing.assert_array_equal(weights(piece, "sherd_unmatched"), ~known)
    inside = sherd.read_match(tmp_path / "kept").best.mask
    np.testing.assert_array_equal(weights(whole_object, "sherd_region"), inside)
    for thing, name in ((whole_object, "full"), (piece, "part")):
        attribute = thing.data.color_attributes.active_color
        assert attribute.name == "sherd_correspondence"
        shown = np.array([tuple(entry.color_srgb)[:3] for entry in attribute.data])
        wanted = read_mesh(tmp_path / "kept" / f"{name}.ply").fields["color"]
        np.testing.assert_allclose(shown, wanted, atol=1e-3)


def test_blender_says_why_there_is_no_answer(bpy, extension, pair) -> None:
    with pytest.raises(RuntimeError, match="say where the sherd command is"):
        bpy.ops.object.sherd_match()
    bpy.context.scene.sherd.command = "/nowhere/sherd"
    with pytest.raises(RuntimeError, match="cannot be started"):
        bpy.ops.object.sherd_match()
    pair[1].select_set(False)
    with pytest.raises(RuntimeError, match="poll"):
        bpy.ops.object.sherd_match()
