from __future__ import annotations

import base64
import csv
import io
import json
import xml.etree.ElementTree as ET

import numpy as np
import pytest
import trimesh

from sherd.drawing.exhibit import Layer, Partner
from sherd.errors import OptionError
from sherd.mesh.surface_points import SurfacePoints
from sherd.npz import arrays_npz
from sherd.report.files import (
    corr_text,
    painted_ply,
    table_csv,
    vertex_map_text,
)
from sherd.report.stored.folder import folder_problems
from sherd.report.vtp import vtp_text
from sherd.result_folder import ResultFolder


def test_trimesh_reads_colors_and_properties_of_the_ply(exhibit):
    data = painted_ply(exhibit.full, exhibit.full_layers, painted=exhibit.full_layers[2])
    mesh = trimesh.load(io.BytesIO(data), file_type="ply", process=False)
    np.testing.assert_array_equal(mesh.vertices, exhibit.full.vertices)
    np.testing.assert_array_equal(mesh.faces, exhibit.full.faces)
    inside = exhibit.full_layers[2].values
    assert (mesh.visual.vertex_colors[inside, 0] > mesh.visual.vertex_colors[inside, 2] + 100).all()
    stored = mesh.metadata["_ply_raw"]["vertex"]["data"]
    np.testing.assert_array_equal(stored["membership"].ravel(), exhibit.full_layers[0].values)
    np.testing.assert_array_equal(stored["mask"].ravel(), inside)


def test_meshlab_finds_the_painted_scalar_as_quality(exhibit):
    data = painted_ply(exhibit.full, exhibit.full_layers)
    mesh = trimesh.load(io.BytesIO(data), file_type="ply", process=False)
    stored = mesh.metadata["_ply_raw"]["vertex"]["data"]
    np.testing.assert_array_equal(stored["quality"].ravel(), exhibit.full_layers[0].values)


def test_vtp_holds_every_array(exhibit):
    layers = (
        *exhibit.full_layers,
        Layer('odd <name> & "quote"', np.zeros(exhibit.full.vertex_count)),
    )
    root = ET.fromstring(vtp_text(exhibit.full, layers))  # noqa: S314  our own text
    found = {}
    for array in root.iter("DataArray"):
        raw = base64.b64decode(array.text)
        size = int.from_bytes(raw[:8], "little")
        assert size == len(raw) - 8
        kind = {"Float64": "<f8", "Int64": "<i8", "UInt8": "u1"}[array.get("type")]
        width = int(array.get("NumberOfComponents"))
        found[array.get("Name")] = np.frombuffer(raw[8:], dtype=kind).reshape(-1, width)
    full = exhibit.full
    np.testing.assert_array_equal(found["Points"], full.vertices)
    np.testing.assert_array_equal(found["connectivity"].reshape(-1, 3), full.faces)
    np.testing.assert_array_equal(found["offsets"].ravel(), 3 + 3 * np.arange(full.face_count))
    np.testing.assert_array_equal(found["membership"].ravel(), exhibit.full_layers[0].values)
    np.testing.assert_array_equal(found["correspondence"], exhibit.full_layers[1].values)
    assert "odd_name_quote" in found


def test_csv_is_stable_and_read_by_the_csv_module():
    text = table_csv(
        {
            "vertex": np.arange(3),
            "value": np.array([1 / 3, -0.0, np.nan]),
            "inside": np.array([True, False, True]),
        }
    )
    assert text == "vertex,value,inside\n0,0.333333333,1\n1,0,0\n2,nan,1\n"
    rows = list(csv.DictReader(io.StringIO(text)))
    assert [row["inside"] for row in rows] == ["1", "0", "1"]
    with pytest.raises(OptionError, match="one length"):
        table_csv({"a": [1, 2], "b": [1]})
    with pytest.raises(OptionError, match="quoting"):
        table_csv({"a,b": [1]})
    with pytest.raises(OptionError, match="only numbers"):
        table_csv({"a": ["x"]})


def test_npz_needs_no_pickle_and_repeats_to_the_bit():
    arrays = {"mask": np.array([True, False]), "values": np.arange(6.0).reshape(2, 3)}
    data = arrays_npz(arrays)
    assert data == arrays_npz(arrays)
    with np.load(io.BytesIO(data), allow_pickle=False) as archive:
        assert sorted(archive.files) == ["mask", "values"]
        np.testing.assert_array_equal(archive["values"], arrays["values"])
    with pytest.raises(OptionError, match="objects"):
        arrays_npz({"bad": np.array([None])})


def test_corr_and_vertex_maps(exhibit):
    points = SurfacePoints([4, 0, 2], [[0.25, 0.5, 0.25], [1, 0, 0], [0, 0, 1]])
    partner = Partner(points, np.array([True, False, True]))
    assert corr_text(partner) == "5 0.25 0.5 0.25\n-1 0 0 0\n3 0 0 1\n"
    full = exhibit.full
    corners = [full.faces[4, 1], full.faces[2, 2]]
    assert vertex_map_text(partner, full) == f"{corners[0]}\n-1\n{corners[1]}\n"
    assert vertex_map_text(partner, full, first=1) == f"{corners[0] + 1}\n-1\n{corners[1] + 1}\n"
    with pytest.raises(OptionError, match="from 0 or from 1"):
        vertex_map_text(partner, full, first=2)
    table = np.loadtxt(io.StringIO(corr_text(exhibit.partner)))
    known = exhibit.partner.known
    np.testing.assert_array_equal(table[known, 0] - 1, exhibit.partner.points.faces[known])


def test_a_mixed_folder_is_recognized(tmp_path):
    with ResultFolder(tmp_path) as folder:
        folder.add("a.csv", "x\n1\n")
        folder.add("b.csv", "x\n2\n")
        folder.finish({"status": "converged"})
    assert folder_problems(tmp_path) == ()
    (tmp_path / "a.csv").write_text("x\n3\n")
    (tmp_path / "b.csv").unlink()
    problems = folder_problems(tmp_path)
    assert "a.csv does not belong" in problems[0]
    assert "b.csv is missing" in problems[1]
    (tmp_path / "result.json").write_text("[1]")
    assert "cannot be read" in folder_problems(tmp_path)[0]
    (tmp_path / "result.json").write_text(json.dumps({"files": {"../secret": "0"}}))
    assert "missing" in folder_problems(tmp_path)[0]
    assert "nothing was finished" in folder_problems(tmp_path / "absent")[0]
