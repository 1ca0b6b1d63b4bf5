"""Reading and writing: numbering, fields, notices, and one-line errors that name the element."""

from __future__ import annotations

import json
import logging
import os
import struct
import sys
import warnings

import numpy as np
import pytest

from sherd.errors import InvalidMeshError, MeshFileError, OptionError, OutputError
from sherd.files.mesh_files import FORMATS, read_mesh, read_mesh_with_notices, write_mesh
from sherd.mesh.triangle_mesh import TriangleMesh

PYRAMID = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1.25]])
SIDES = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [0, 2, 1], [0, 3, 2]])


def pyramid(**fields):
    return TriangleMesh(PYRAMID, SIDES, fields=fields)


def written(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


OFF = (
    "OFF\n5 6 0\n"
    + "\n".join(
        [" ".join(map(str, row)) for row in PYRAMID.tolist()]
        + ["3 " + " ".join(map(str, row)) for row in SIDES.tolist()]
    )
    + "\n"
)
OBJ = (
    "\n".join(
        ["v " + " ".join(map(str, row)) for row in PYRAMID.tolist()]
        + ["f " + " ".join(map(str, row)) for row in (SIDES + 1).tolist()]
    )
    + "\n"
)
PLY = (
    "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
    "property float z\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n"
    + OFF.split("\n", 2)[2]
)
STL = (
    "solid a\n"
    + "".join(
        "facet normal 0 0 1\nouter loop\n"
        + "".join("vertex {} {} {}\n".format(*PYRAMID[corner]) for corner in side)
        + "endloop\nendfacet\n"
        for side in SIDES
    )
    + "endsolid a\n"
)
TEXTS = {"off": OFF, "obj": OBJ, "ply": PLY, "stl": STL}


@pytest.mark.parametrize("suffix", list(FORMATS))
def test_round_trip_keeps_vertices_and_faces(tmp_path, suffix):
    path = tmp_path / f"shape{suffix}"
    write_mesh(pyramid(), path)
    mesh, notices = read_mesh_with_notices(path)
    assert notices == ()
    assert mesh.name == path.name
    assert np.array_equal(mesh.vertices[mesh.faces], PYRAMID[SIDES])
    if suffix != ".stl":
        assert np.array_equal(mesh.vertices, PYRAMID)
        assert np.array_equal(mesh.faces, SIDES)


@pytest.mark.parametrize("suffix", list(TEXTS))
@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("\n", "\r\n").encode(),
        lambda text: b"\xef\xbb\xbf" + text.encode(),
        lambda text: text.encode("utf-16"),
        lambda text: b"\xfe\xff" + text.encode("utf-16-be"),
        lambda text: text.rstrip().encode(),
        lambda text: text.replace(" ", "  \t").encode(),
    ],
    ids=["crlf", "bom", "utf16", "utf16be", "no-last-line-end", "blanks"],
)
def test_text_survives_other_line_ends_and_encodings(tmp_path, suffix, change):
    mesh = read_mesh(written(tmp_path, f"shape.{suffix}", change(TEXTS[suffix])))
    assert np.array_equal(mesh.vertices[mesh.faces], PYRAMID[SIDES])


def test_stl_stays_soup_in_the_order_of_the_file(tmp_path):
    mesh = read_mesh(written(tmp_path, "shape.stl", STL))
    assert np.array_equal(mesh.faces, np.arange(18).reshape(6, 3))
    assert np.array_equal(mesh.vertices, PYRAMID[SIDES].reshape(-1, 3))


def test_several_stl_solids_stay_in_order(tmp_path):
    mesh = read_mesh(written(tmp_path, "shape.stl", STL + STL.replace("solid a", "solid b")))
    assert np.array_equal(mesh.vertices[18:], mesh.vertices[:18])


def test_obj_with_seams_groups_and_materials_keeps_its_numbering(tmp_path):
    lines = ["mtllib ../../secret.mtl", "o thing", *OBJ.splitlines()[:5]]
    lines += ["vt 0 0", "vt 1 0", "vt 0 1", "vn 0 0 1"]
    for index, face in enumerate((SIDES + 1).tolist()):
        lines += [f"usemtl m{index % 2}", f"g part{index % 3}"]
        lines += ["f " + " ".join(f"{v}/{(index + k) % 3 + 1}/1" for k, v in enumerate(face))]
    mesh = read_mesh(written(tmp_path, "seams.obj", "\n".join(lines)))
    assert np.array_equal(mesh.vertices, PYRAMID)
    assert np.array_equal(mesh.faces, SIDES)


def test_obj_counts_negative_references_from_the_line_they_stand_in(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 1 1 0\nf -3 -1 -2\n"
    mesh = read_mesh(written(tmp_path, "negative.obj", text))
    assert mesh.faces.tolist() == [[0, 1, 2], [1, 3, 2]]


def test_polygons_become_triangles_with_a_notice(tmp_path):
    text = "OFF\n5 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n.5 2 0\n4 0 1 2 3\n3 3 2 4\n"
    mesh, notices = read_mesh_with_notices(written(tmp_path, "house.off", text))
    assert mesh.face_count == 3
    assert mesh.area == pytest.approx(1.5)
    assert notices == ("cut 1 face with more than three corners into triangles",)


def test_read_mesh_logs_the_notices(tmp_path, caplog):
    path = written(tmp_path, "q.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
    with caplog.at_level(logging.INFO, logger="sherd.files.mesh_files"):
        assert read_mesh(path).face_count == 2
    assert "into triangles" in caplog.text


@pytest.mark.parametrize("order", ["<", ">"])
def test_binary_ply_with_mixed_polygons_and_extra_lists(tmp_path, order):
    name = {"<": "little", ">": "big"}[order]
    head = (
        f"ply\nformat binary_{name}_endian 1.0\nelement vertex 5\nproperty double x\n"
        "property double y\nproperty double z\nproperty uchar red\nproperty uchar green\n"
        "property uchar blue\nproperty short age\nelement face 3\nproperty uchar flags\n"
        "property list uchar int vertex_index\nproperty list uchar float texcoord\nend_header\n"
    )
    body = b"".join(
        struct.pack(f"{order}3d3Bh", *row, 255, 51 * i, 0, -i) for i, row in enumerate(PYRAMID)
    )
    for face, uv in (([0, 3, 2, 1], 8), ([0, 1, 4], 6), ([1, 2, 4], 0)):
        body += struct.pack(f"{order}BB{len(face)}iB{uv}f", 7, len(face), *face, uv, *[0.5] * uv)
    mesh, notices = read_mesh_with_notices(written(tmp_path, "mixed.ply", head.encode() + body))
    assert mesh.faces.tolist() == [[0, 3, 2], [0, 2, 1], [0, 1, 4], [1, 2, 4]]
    assert mesh.fields["age"].tolist() == [0, -1, -2, -3, -4]
    assert mesh.fields["color"][:, 1] == pytest.approx(np.arange(5) / 5)
    assert len(notices) == 1


def test_ply_fields_and_colors_round_trip(tmp_path):
    rng = np.random.default_rng(0)
    fields = {"quality": rng.random(5), "wave": rng.random((5, 2)), "unknown": np.full(5, np.nan)}
    colors = np.array([[0, 0, 0], [255, 128, 1], [3, 4, 5], [9, 9, 9], [250, 0, 250]], np.uint8)
    path = tmp_path / "fields.ply"
    write_mesh(pyramid(), path, fields=fields, colors=colors)
    mesh = read_mesh(path)
    assert np.array_equal(mesh.fields["quality"], fields["quality"])
    assert np.array_equal(mesh.fields["wave_1"], fields["wave"][:, 1])
    assert np.isnan(mesh.fields["unknown"]).all()
    assert np.array_equal(np.rint(mesh.fields["color"] * 255), colors)
    again = tmp_path / "again.ply"
    write_mesh(mesh, again)  # the fields of the mesh are the default
    assert again.read_bytes() == path.read_bytes()


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".glb"])
def test_colors_round_trip(tmp_path, suffix):
    colors = np.linspace(0, 1, 15).reshape(5, 3)
    path = tmp_path / f"colored{suffix}"
    write_mesh(pyramid(), path, colors=colors)
    assert read_mesh(path).fields["color"] == pytest.approx(colors, abs=0.5 / 255 + 1e-9)


def test_another_library_reads_what_we_write(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    path = tmp_path / "ours.ply"
    write_mesh(pyramid(), path, fields={"quality": np.arange(5.0)}, colors=np.zeros((5, 3)))
    loaded = trimesh.load_mesh(path, process=False)
    assert np.array_equal(loaded.vertices, PYRAMID)
    assert np.array_equal(loaded.faces, SIDES)
    assert np.array_equal(loaded.metadata["_ply_raw"]["vertex"]["data"]["quality"], np.arange(5.0))


@pytest.mark.parametrize("scale", [1e-30, 1e-12, 1e9, 1e30])
@pytest.mark.parametrize("suffix", [".off", ".obj", ".ply"])
def test_any_unit_survives_exactly(tmp_path, suffix, scale):
    mesh = pyramid().with_vertices(PYRAMID * scale)
    write_mesh(mesh, tmp_path / f"s{suffix}")
    assert np.array_equal(read_mesh(tmp_path / f"s{suffix}").vertices, PYRAMID * scale)


def test_options_without_room_are_refused(tmp_path):
    mesh = pyramid()
    with pytest.raises(OptionError, match=r"\.off files have no room for vertex fields"):
        write_mesh(mesh, tmp_path / "a.off", fields={"a": np.zeros(5)})
    with pytest.raises(OptionError, match=r"\.stl files have no room for colors"):
        write_mesh(mesh, tmp_path / "a.stl", colors=np.zeros((5, 3)))
    with pytest.raises(OptionError, match=r"suffix '\.xyz' is unknown"):
        write_mesh(mesh, tmp_path / "a.xyz")
    with pytest.raises(OptionError, match="field name 'two words'"):
        write_mesh(mesh, tmp_path / "a.ply", fields={"two words": np.zeros(5)})
    with pytest.raises(OptionError, match="too large for"):
        write_mesh(mesh.with_vertices(PYRAMID * 1e50), tmp_path / "a.stl")
    with pytest.raises(InvalidMeshError, match=r"colors has shape \(4, 3\)"):
        write_mesh(mesh, tmp_path / "a.ply", colors=np.zeros((4, 3)))
    assert list(tmp_path.iterdir()) == []


def test_a_failed_write_leaves_the_old_file(tmp_path):
    target = tmp_path / "folder.ply"
    target.mkdir()
    (target / "inside").write_text("kept")
    with pytest.raises(OutputError, match="cannot be written"):
        write_mesh(pyramid(), target)
    assert [path.name for path in tmp_path.iterdir()] == ["folder.ply"]


def glb(header, body=b""):
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    chunks += struct.pack("<II", len(body), 0x004E4942) + body
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def triangle_glb(**changes):
    header = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 3}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36}],
        "images": [{"uri": "../../../etc/passwd"}],
    }
    return glb(header | changes, struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0))


def test_glb_with_pictures_elsewhere_is_read_without_them(tmp_path):
    mesh = read_mesh(written(tmp_path, "a.glb", triangle_glb()))
    assert mesh.area == pytest.approx(0.5)


def ply(vertices=3, faces=1, rows="0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", form="ascii"):
    return (
        f"ply\nformat {form} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n"
        f"property float z\nelement face {faces}\nproperty list uchar int vertex_indices\n"
        f"end_header\n{rows}"
    )


HUGE = 10**12
BAD_FILES = {
    "empty.off": (b"", "is empty"),
    "blank.obj": (b" \n\n", "is empty"),
    "zeros.stl": (bytes(200), "is empty"),
    "noise.off": (bytes(range(256)), "binary data where text is expected"),
    "noise.obj": (bytes(range(256)), "binary data where text is expected"),
    "noise.stl": (bytes(range(1, 256)), "neither 'solid' nor a binary header"),
    "noise.ply": (bytes(range(256)), "no PLY header"),
    "noise.glb": (bytes(range(256)), "does not start with 'glTF'"),
    "a.xyz": (b"0 0 0", "unknown suffix '.xyz'; sherd reads .off, .obj, .ply, .stl, .glb"),
    "a.ply.gz": (b"\x1f\x8b", "is packed; unpack it first"),
    "not.off": ("PLY\n", "does not start with OFF but with 'PLY'"),
    "four.off": ("4OFF\n1 1 0\n0 0 0 0\n", "another dimension"),
    "binary.off": ("OFF BINARY\n1 1 0\n", "is a binary OFF file"),
    "header.off": ("OFF\n", "ends before the line with the counts"),
    "counts.off": ("OFF\nthree 1 0\n", "reads 'three 1 0'"),
    "hostile.off": (f"OFF\n{HUGE} 4 0\n0 0 0\n", f"promises {HUGE} vertices and 4 faces, but only"),
    "overflow.off": (f"OFF\n{HUGE**3} 4 0\n0 0 0\n", "the counts of vertices and faces belong"),
    "short.off": (OFF.rsplit("\n", 3)[0], "only 9 lines follow"),
    "few.off": (OFF.replace("5 6 0", "4 6 0"), "but 11 lines follow; the counts"),
    "shift.off": (OFF.replace("5 6 0", "6 5 0"), "vertex 5 has 4 columns where vertex 0 has 3"),
    "comma.off": (OFF.replace("0.5 0.5", "0,5 0,5"), "vertex 4 reads '0,5 0,5 1.25'.*decimal"),
    "word.off": (OFF.replace("0.5 0.5", "0.5 O.5"), "vertex 4 reads"),
    "nan.off": (OFF.replace("1.25", "nan"), r"vertices\[4, 2\] = nan"),
    "inf.off": (OFF.replace("1.25", "-inf"), r"vertices\[4, 2\] = -inf"),
    "range.off": (OFF.replace("3 1 2 4", "3 1 9 4"), r"face 1 names vertex 9, but there are 5"),
    "below.off": (OFF.replace("3 1 2 4", "3 1 -2 4"), "face 1 names vertex -2"),
    "half.off": (OFF.replace("3 1 2 4", "3 1 2.5 4"), "face 1 reads '3 1 2.5 4'"),
    "cut.off": (OFF.replace("3 1 2 4", "3 1 2"), "face 1 reads '3 1 2'"),
    "cloud.off": ("OFF\n2 0 0\n0 0 0\n1 1 1\n", "holds 2 points and no faces"),
    "none.off": ("OFF\n0 0 0\n", "holds no faces"),
    "flat.off": ("OFF\n3 1 0\n0 0 0\n1 1 1\n2 2 2\n3 0 1 2\n", "all 1 faces have no area"),
    "edges.off": ("OFF\n2 1 0\n0 0 0\n1 1 1\n2 0 1\n", "holds 2 points and no faces"),
    "cloud.obj": ("v 0 0 0\nv 1 0 0\nl 1 2\n", "holds 2 points and no faces"),
    "zero.obj": (OBJ + "f 0 1 2\n", r"face 6 names vertex 0, but there are 5 vertices \(1\.\.5\)"),
    "range.obj": (OBJ + "f 1 2 6\n", "face 6 names vertex 6"),
    "back.obj": (OBJ + "f -1 -2 -6\n", "face 6 names vertex -6"),
    "word.obj": (OBJ + "f 1 two 3\n", "face 6 reads '1 two 3'"),
    "long.obj": (OBJ + f"f 1 2 {HUGE**2}\n", "face 6"),
    "comma.obj": (OBJ.replace("0.5", "0,5"), "decimal points"),
    "two.obj": ("v 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "vertex 0 reads '0 0'"),
    "nan.obj": (OBJ.replace("1.25", "NaN"), r"vertices\[4, 2\] = nan"),
    "short.ply": (PLY.rsplit("\n", 3)[0], "promises 5 vertex, 6 face rows, but the file holds 9"),
    "hostile.ply": (ply(vertices=HUGE), f"promises {HUGE} vertex"),
    "hostile2.ply": (ply(faces=HUGE, form="binary_little_endian"), f"{HUGE} face rows"),
    "list.ply": (ply(rows="0 0 0\n1 0 0\n0 1 0\n255 0 1 2\n"), "face 0 reads '255 0 1 2'"),
    "width.ply": (ply(rows="0 0 0\n1 0\n0 1 0\n3 0 1 2\n"), "vertex 1 has 2 values"),
    "range.ply": (ply(rows="0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"), "face 0 names vertex 3"),
    "comma.ply": (ply(rows="0,5 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"), "vertex 0 reads.*decimal"),
    "nan.ply": (ply(rows="0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n"), r"vertices\[1, 1\] = nan"),
    "format.ply": (ply(form="binary"), "names the format 'binary'"),
    "type.ply": (ply().replace("float x", "quad x"), "header holds 'property quad x'"),
    "axis.ply": (ply().replace("float z", "float w"), "no coordinate 'z'"),
    "twice.ply": (ply().replace("float y", "float x"), "declares the property 'x'"),
    "index.ply": (ply().replace("list uchar int", "int"), "no list 'vertex_indices'"),
    "cloud2.ply": (ply(vertices=HUGE, faces=0), f"promises {HUGE} vertex"),
    "cloud3.ply": (ply(vertices=HUGE, faces=0, form="binary_little_endian"), f"{HUGE} vertex"),
    "cloud.ply": (ply(faces=0, rows="0 0 0\n1 0 0\n0 1 0\n"), "holds 3 points and no faces"),
    "extra.ply": (
        ply(form="binary_little_endian", rows="\1" * 90),
        "bytes more|faces with|promises",
    ),
    "short.stl": (STL[:-40], "begun"),
    "count.stl": (b"x" * 80 + struct.pack("<I", 2**32 - 1) + bytes(100), "room for 2"),
    "number.stl": (STL.replace("1.25", "1..5"), "could|reads|cannot|vertices"),
    "short.glb": (triangle_glb()[:-4], "promises .* bytes, but the file has"),
    "count.glb": (
        triangle_glb(
            accessors=[{"bufferView": 0, "componentType": 5126, "count": HUGE, "type": "VEC3"}]
        ),
        f"accessor 0 promises {HUGE} elements",
    ),
    "view.glb": (triangle_glb(bufferViews=[{"buffer": 0, "byteLength": 99}]), "bufferView 0 ends"),
    "uri.glb": (triangle_glb(buffers=[{"byteLength": 36, "uri": "../x.bin"}]), "in another file"),
    "cycle.glb": (triangle_glb(nodes=[{"children": [0]}]), "contain each other"),
    "json.glb": (triangle_glb().replace(b'"asset"', b'"asset\0'), "JSON part cannot be read"),
    "shape.glb": (triangle_glb(meshes=[{"primitives": 3}]), "JSON part is damaged"),
    "lines.glb": (
        triangle_glb(meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "mode": 1}]}]),
        "holds no faces",
    ),
}


@pytest.mark.parametrize("name", list(BAD_FILES))
def test_bad_files_end_in_one_line_that_names_path_and_element(tmp_path, name):
    content, message = BAD_FILES[name]
    path = written(tmp_path, name, content)
    with pytest.raises((MeshFileError, InvalidMeshError), match=message) as caught:
        read_mesh(path)
    text = str(caught.value)
    assert text.startswith(f"{path}: ")
    assert "\n" not in text
    assert len(text) < len(str(path)) + 400


def test_missing_file_folder_and_device(tmp_path):
    with pytest.raises(MeshFileError, match=r"gone\.ply: no such file; check the path"):
        read_mesh(tmp_path / "gone.ply")
    with pytest.raises(MeshFileError, match="is a folder; name a mesh file in it"):
        read_mesh(tmp_path)
    (tmp_path / "folder.off").mkdir()
    with pytest.raises(MeshFileError, match="is a folder"):
        read_mesh(tmp_path / "folder.off")
    os.mkfifo(tmp_path / "pipe.off")  # must not wait for a writer
    with pytest.raises(MeshFileError, match="no ordinary file"):
        read_mesh(tmp_path / "pipe.off")
    with pytest.raises(MeshFileError, match="cannot be read"):
        read_mesh("bad\0name.off")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_no_permission(tmp_path):
    path = written(tmp_path, "secret.off", OFF)
    path.chmod(0)
    with pytest.raises(MeshFileError, match="may not be read; change its permissions"):
        read_mesh(path)


def test_reading_opens_no_other_file(tmp_path):
    opened = []
    watching = True

    def hook(event, arguments):
        if watching and event in ("open", "socket.connect"):
            opened.append(str(arguments[0]))

    secret = written(tmp_path, "secret.mtl", "newmtl m0\nmap_Kd secret.png\n")
    path = written(tmp_path, "a.obj", f"mtllib {secret.name}\nusemtl m0\n{OBJ}")
    textured = PLY.replace("element vertex", "comment TextureFile secret.mtl\nelement vertex", 1)
    cloth = written(tmp_path, "a.ply", textured)
    read_mesh(path), read_mesh(cloth)  # libraries are imported
    sys.addaudithook(hook)
    try:
        read_mesh(path), read_mesh(cloth)
    finally:
        watching = False
    assert [name for name in opened if "secret" in name] == []


def test_nothing_is_printed_or_warned(tmp_path, capfd):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for name, (content, _) in BAD_FILES.items():
            with pytest.raises((MeshFileError, InvalidMeshError)):
                read_mesh(written(tmp_path, name, content))
    assert capfd.readouterr() == ("", "")
