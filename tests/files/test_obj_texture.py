"""A textured OBJ file with other coordinates: what belongs to corners of faces stays."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.errors import InputError, MeshFileError
from sherd.files.mesh_files import read_mesh
from sherd.files.obj_texture import has_texture, moved_obj

# A seam: vertex 2 has two places in the picture. Faces are written in all four ways, and one is a
# quadrangle; a line goes on in the next; a vertex has a color.
TEXTURED = """# made by hand
mtllib skin.mtl
v 0 0 0 0.5 0.5 0.5 # first
v 1 0 0
v 1 1 0
v 0 1 \\
0
v 2 0 0
vt 0 0
vt 1 0
vt 0.25 0.75
vn 0 0 1
g left
usemtl skin
f 1/1/1 2/2/1 3/3/1 4/1/1
g right
f 2/3 5/1 3/2
f 2//1 5//1 -3//1
f 5 3 2
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "skin.obj"
    path.write_text(TEXTURED)
    return path


def test_only_positions_change_and_normals_go(file, tmp_path) -> None:
    places = np.random.default_rng(0).normal(size=(5, 3))
    written = moved_obj(file, places)
    moved = tmp_path / "moved.obj"
    moved.write_bytes(written)
    assert np.array_equal(read_mesh(moved).vertices, places)
    assert np.array_equal(read_mesh(moved).faces, read_mesh(file).faces)
    lines = written.decode().splitlines()
    assert lines[:2] == ["# made by hand", "mtllib skin.mtl"]
    assert lines[2].endswith(" 0.5 0.5 0.5")
    assert lines[7:] == [
        "vt 0 0", "vt 1 0", "vt 0.25 0.75", "g left", "usemtl skin", "f 1/1 2/2 3/3 4/1",
        "g right", "f 2/3 5/1 3/2", "f 2 5 -3", "f 5 3 2",
    ]  # fmt: skip


def test_files_with_and_without_texture_are_told_apart(file, tmp_path) -> None:
    assert has_texture(file)
    plain = tmp_path / "plain.OBJ"
    plain.write_text("v 0 0 0\n# vt 0 0\n")
    assert not has_texture(plain)
    assert not has_texture(tmp_path / "nowhere.ply")
    with pytest.raises(MeshFileError, match=r"nowhere\.obj: cannot be read"):
        has_texture(tmp_path / "nowhere.obj")


@pytest.mark.parametrize("count", [4, 6])
def test_files_of_other_shapes_are_refused(file, count) -> None:
    with pytest.raises(InputError, match=f"has 5 vertices, but the full shape has {count}"):
        moved_obj(file, np.zeros((count, 3)))
