"""three.js and Blender read the GLB of a fit: its shape, the morph to it, texture coordinates.

Both are optional: three.js comes with the viewer's packages, Blender as a module (``bpy``, see
docs/contributing.md). Each reads in a process of its own, since Blender cannot share one with
MeshLab's reader.
"""

from __future__ import annotations

import importlib.util
import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.fitted.morph import morph_glb

SCRIPTS = Path(__file__).parent / "morph_readers"
ASKED = 7  # a vertex


@pytest.fixture(scope="module")
def shapes() -> tuple[TriangleMesh, np.ndarray]:
    """A ball whose place in a picture is known, and what it becomes."""
    ball = trimesh.creation.icosphere(subdivisions=2)
    vertices = np.asarray(ball.vertices) * [1.0, 0.8, 0.6]
    rng = np.random.default_rng(0)
    fields = {"s": rng.random(len(vertices)), "t": rng.random(len(vertices))}
    goal = vertices * [1.0, 1.5, 0.5] + [3.0, 0.0, 0.0]
    return TriangleMesh(vertices, np.asarray(ball.faces), fields=fields), goal


@pytest.fixture(scope="module")
def file(shapes, tmp_path_factory) -> Path:
    full, goal = shapes
    path = tmp_path_factory.mktemp("morph") / "fit.glb"
    path.write_bytes(morph_glb(full, goal, None))
    return path


def answer(words: list[str | Path]) -> dict:
    """The JSON object in the last line that a reader prints."""
    done = subprocess.run(
        [str(word) for word in words], capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stderr
    found: dict = json.loads(done.stdout.strip().splitlines()[-1])
    return found


def test_three_morphs_from_the_full_shape_to_the_fit(shapes, file, viewer) -> None:
    full, goal = shapes
    shutil.copy(SCRIPTS / "three.mjs", viewer)
    read = answer(["node", viewer / "three.mjs", file, str(ASKED)])
    assert read["count"] == full.vertex_count
    assert read["targets"] == {"fit": 0}
    assert read["weights"] == [1]
    shift = goal.mean(axis=0) - full.vertices.mean(axis=0)
    assert np.allclose(read["at 0"], full.vertices[ASKED] + shift, atol=1e-6)
    assert np.allclose(read["at 1"], goal[ASKED], atol=1e-6)
    place = [full.fields["s"][ASKED], 1 - full.fields["t"][ASKED]]
    assert np.allclose(read["uv"], place, atol=1e-6)


@pytest.mark.skipif(
    importlib.util.find_spec("bpy") is None,
    reason="Blender as a module (bpy) is not installed: see docs/contributing.md",
)
def test_blender_has_a_shape_key_for_the_fit(shapes, file) -> None:
    full, goal = shapes
    read = answer([sys.executable, SCRIPTS / "blender.py", file, str(ASKED)])
    assert read["count"] == full.vertex_count
    assert read["keys"]["fit"] == 1.0
    shift = goal.mean(axis=0) - full.vertices.mean(axis=0)
    # Blender's third axis points up, that of glTF toward the viewer
    for found, place in ((read["at 0"], full.vertices[ASKED] + shift), (read["at 1"], goal[ASKED])):
        assert np.allclose(found, [place[0], -place[2], place[1]], atol=1e-6)
    places = np.array(read["uv"])  # at corners, from the lower left again
    wanted = [full.fields["s"][ASKED], full.fields["t"][ASKED]]
    assert len(places)
    assert np.allclose(places, wanted, atol=1e-6)
