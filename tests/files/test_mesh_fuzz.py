"""Damaged bytes: every case ends in a mesh that can be examined, or in an error of sherd.

SHERD_FUZZ_CASES sets the number of cases for each format (60 if unset; 4000 makes 20,000 in all).
"""

from __future__ import annotations

import copy
import json
import os
import struct
import time

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from sherd.errors import InputError
from sherd.files.encode import encoded
from sherd.files.mesh_files import read_mesh_with_notices
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.repair.inspection import inspect

CASES = int(os.environ.get("SHERD_FUZZ_CASES", "60"))
SECONDS = 5.0

PLATE = TriangleMesh(
    [[0, 0, 0], [1, 0, 0.25], [0, 1, 0], [1, 1, -0.5]],
    [[0, 1, 2], [2, 1, 3]],
    fields={"quality": [0.0, 1.0, 2.0, 3.0], "color": np.eye(4, 3)},
)
ASCII_PLY = (
    b"ply\nformat ascii 1.0\ncomment plate\nelement vertex 4\nproperty float x\nproperty float y\n"
    b"property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    b"element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    b"0 0 0 1 2 3\n1 0 0.25 4 5 6\n0 1 0 7 8 9\n1 1 -.5 0 0 0\n3 0 1 2\n4 2 1 3 0\n"
)
ASCII_STL = b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1e0 0\n"
ASCII_STL += b"endloop\nendfacet\nendsolid a\n"
SEEDS = {
    "off": (".off", encoded(PLATE, ".off")),
    "obj": (".obj", b"mtllib a.mtl\nvt 0 0\n" + encoded(PLATE, ".obj") + b"f -1/1 -2/1/1 1//1\n"),
    "ply": (".ply", encoded(PLATE, ".ply")),
    "ascii ply": (".ply", ASCII_PLY),
    "stl": (".stl", encoded(PLATE, ".stl")),
    "ascii stl": (".stl", ASCII_STL),
    "glb": (".glb", encoded(PLATE, ".glb")),
}
NUMBERS = [b"-", b"9" * 12, b"1e999", b"nan", b"4294967295", b"2147483648", b"0x10", b"1,5", b"1_0"]
WORDS = [
    b"element vertex 9\n",
    b"OFF",
    b"[[[[",
    b"{}",
    b"null",
    b"list uchar int",
    b"f 1 2",
    b"v 1",
]
SIGNS = [b"", b"\0", b"\n", b"\r", b" ", b"\xff" * 4, b"#", b"\\\n", "\u0663".encode()]
PIECES = st.sampled_from([*NUMBERS, *WORDS, *SIGNS])


@st.composite
def mutations(draw):
    """Positions as fractions of the file, how much goes, and what comes instead."""
    position = draw(st.floats(0, 1))
    length = draw(st.sampled_from([0, 0, 1, 1, 2, 4, 8, 30, 10**6]))
    piece = draw(st.one_of(PIECES, st.binary(max_size=6)))
    return position, length, piece


def damaged(data, changes):
    for position, length, piece in changes:
        start = int(position * len(data))
        data = data[:start] + piece + data[start + length :]
    return data


def read_or_refuse(path, data):
    path.write_bytes(data)
    start = time.perf_counter()
    try:
        mesh, notices = read_mesh_with_notices(path)
    except InputError as error:
        message = str(error)
    else:
        message = f"{path}: "
        assert np.isfinite(mesh.vertices).all()
        assert all(isinstance(notice, str) for notice in notices)
        assert inspect(mesh).usable in ("usable", "after repair", "unusable")
    assert message.startswith(f"{path}: ")
    assert "\n" not in message
    assert time.perf_counter() - start < SECONDS


@pytest.mark.parametrize("kind", list(SEEDS))
def test_seeds_are_good(tmp_path, kind):
    suffix, data = SEEDS[kind]
    path = tmp_path / f"seed{suffix}"
    path.write_bytes(data)
    assert read_mesh_with_notices(path)[0].face_count >= 1


@pytest.mark.parametrize("kind", list(SEEDS))
@settings(
    max_examples=CASES,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(changes=st.lists(mutations(), min_size=1, max_size=4))
@example(changes=[(1.0, 0, b"")])
@example(changes=[(0.5, 10**6, b"")])
def test_damaged_bytes(tmp_path, kind, changes):
    suffix, data = SEEDS[kind]
    read_or_refuse(tmp_path / f"case{suffix}", damaged(data, changes))


@pytest.mark.parametrize("kind", list(SEEDS))
def test_truncated_at_every_byte(tmp_path, kind):
    suffix, data = SEEDS[kind]
    for end in range(0, len(data), max(1, len(data) // 40)):
        read_or_refuse(tmp_path / f"cut{suffix}", data[:end])


# Cases that once went wrong, reduced.
FOUND = {
    "sign behind.off": (".off", SEEDS["off"][1].replace(b"3 2 1 3", b"3 2 1- 3")),
    "sign behind.ply": (".ply", ASCII_PLY.replace(b"0 1 0 7", b"0 1- 0 7")),
    "strided.glb": (
        ".glb",
        SEEDS["glb"][1].replace(b'"byteOffset":', b'"byteStride":'),
    ),
    "negative count.ply": (
        ".ply",
        b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\n"
        b"property float y\nproperty float z\nelement face 1\nproperty list char int vertex_indices"
        b"\nend_header\n" + struct.pack("<9fb3i", *range(9), -1, 0, 1, 2),
    ),
}


@pytest.mark.parametrize("name", list(FOUND))
def test_found_cases(tmp_path, name):
    suffix, data = FOUND[name]
    read_or_refuse(tmp_path / f"found{suffix}", data)


def glb_parts():
    data = SEEDS["glb"][1]
    size = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + size]), data[20 + size :]


def places_in(value, path=()):
    """Every path to a value inside nested lists and dictionaries."""
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for key, inner in items:
        yield (*path, key)
        if isinstance(inner, dict | list):
            yield from places_in(inner, (*path, key))


PLACES = list(places_in(glb_parts()[0]))
ODD_NUMBERS = [-1, 0, 1, 2, 5, 36, 5120, 5125, 5126, 2**31, 10**12, 0.5, 1e308, np.nan, np.inf]
ODD_THINGS = [None, True, "", "x", "VEC4", "../../secret.bin", [], {}, [0], [[0]], [1e300] * 16]
ODD_VALUES = st.sampled_from([*ODD_NUMBERS, *ODD_THINGS, {"POSITION": 0}])


@settings(
    max_examples=2 * CASES,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(changes=st.lists(st.tuples(st.sampled_from(PLACES), ODD_VALUES), min_size=1, max_size=3))
def test_damaged_glb_headers(tmp_path, changes):
    header, rest = glb_parts()
    for path, odd in changes:
        holder = header
        for key in path[:-1]:
            if not isinstance(holder, dict | list):
                break
            try:
                holder = holder[key]
            except (KeyError, IndexError, TypeError):
                break
        else:
            if isinstance(holder, dict) or (
                isinstance(holder, list) and path[-1] in range(len(holder))
            ):
                holder[path[-1]] = copy.deepcopy(odd)
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text + rest
    read_or_refuse(tmp_path / "case.glb", struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body)
