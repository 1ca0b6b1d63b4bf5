"""Landmarks of 3D Slicer: read as it writes them, written so that it reads them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from sherd.errors import InputError
from sherd.landmarks.landmark_files import read_landmarks, write_landmarks
from sherd.landmarks.landmark_list import Landmarks

POINTS = Landmarks(
    ["nose", "ear, left", "tail"],
    [[1.5, -2.25, 1e-7], [np.nan] * 3, [0.1, 0.2, 0.3]],
    space="RAS",
)


@pytest.mark.parametrize(("end", "space"), [(".mrk.json", "RAS"), (".fcsv", "RAS"), (".csv", None)])
def test_what_is_written_is_read(tmp_path, end, space) -> None:
    path = tmp_path / f"points{end}"
    write_landmarks(POINTS, path, notes=["good", "missing", "doubtful"])
    read = read_landmarks(path)
    kept = [0, 2] if end == ".fcsv" else [0, 1, 2]  # it cannot say that a position is unknown
    assert read.names == tuple(POINTS.names[k] for k in kept)
    np.testing.assert_array_equal(read.positions, POINTS.positions[kept])
    assert read.space == space
    assert "0,0,0" not in path.read_text().replace(" ", "").replace("0,0,0,1,1,1", "")


def slicer_document(**changes: object) -> dict:
    """As Slicer 5 writes it, shortened."""
    point = {
        "id": "1",
        "label": "F-1",
        "description": "",
        "associatedNodeID": "vtkMRMLModelNode4",
        "position": [-1.5, 2.0, 3.25],
        "orientation": [-1.0, -0.0, -0.0, -0.0, -1.0, -0.0, 0.0, 0.0, 1.0],
        "selected": True,
        "locked": False,
        "visibility": True,
        "positionStatus": "defined",
    }
    markup = {
        "type": "Fiducial",
        "coordinateSystem": "LPS",
        "coordinateUnits": "mm",
        "controlPoints": [point, point | {"label": "", "id": "7", "positionStatus": "undefined"}],
        "measurements": [],
        "display": {"visibility": True},
    }
    return {"@schema": "https://...markups-schema-v1.0.3.json#", "markups": [markup | changes]}


def test_a_file_of_slicer_is_read(tmp_path) -> None:
    path = tmp_path / "F.mrk.json"
    path.write_text(json.dumps(slicer_document()))
    found = read_landmarks(path)
    assert found.names == ("F-1", "7")
    assert found.space == "LPS"
    assert found.known.tolist() == [True, False]
    assert found.in_space("RAS").positions[0].tolist() == [1.5, -2.0, 3.25]
    for said, space in ((0, "RAS"), ("1", "LPS"), ("RAS", "RAS")):
        path.write_text(json.dumps(slicer_document(coordinateSystem=said)))
        assert read_landmarks(path).space == space


FCSV = """# Markups fiducial file version = 4.10
# CoordinateSystem = 0
# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID
vtkMRMLMarkupsFiducialNode_0,-10.5,4,2.25,0,0,0,1,1,1,0,"a, b",,vtkMRMLModelNode4
vtkMRMLMarkupsFiducialNode_1,1,2,3,0,0,0,1,1,1,0,,,
"""


def test_a_table_of_an_older_slicer_is_read(tmp_path) -> None:
    path = tmp_path / "F.fcsv"
    path.write_text(FCSV)
    found = read_landmarks(path)
    assert found.names == ("a, b", "vtkMRMLMarkupsFiducialNode_1")
    assert found.space == "RAS"
    assert found.positions.tolist() == [[-10.5, 4, 2.25], [1, 2, 3]]
    path.write_text("\n".join(FCSV.splitlines()[3:]))  # without a header
    assert read_landmarks(path).space == "RAS"
    path.write_text(FCSV.replace("= 0", "= LPS"))
    assert read_landmarks(path).space == "LPS"


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.txt", "", "no file of landmarks by its name"),
        ("a.mrk.json", "{", "is no JSON"),
        ("a.mrk.json", "[]", "has no list of markups"),
        ("a.mrk.json", json.dumps(slicer_document(type="Curve")), "holds Curve, but a point list"),
        ("a.mrk.json", json.dumps(slicer_document(coordinateSystem="IJK")), "LPS or RAS is read"),
        ("a.mrk.json", json.dumps(slicer_document(controlPoints=[])), "holds no landmark"),
        ("a.mrk.json", json.dumps(slicer_document(controlPoints=[3])), "point 1 is no object"),
        (
            "a.mrk.json",
            json.dumps(slicer_document(controlPoints=[{"label": "x", "position": [1, 2]}])),
            "'x' is not three finite numbers",
        ),
        ("a.fcsv", FCSV.replace("2.25", "?"), "line 4 has no numbers"),
        ("a.fcsv", FCSV.replace("= 0", "= 2"), "CoordinateSystem is '2'"),
        ("a.fcsv", FCSV.replace("id,x", "id,r"), "without x, y and z"),
        ("a.csv", "name,x,y\n", "needs the columns"),
        ("a.csv", "name,x,y,z\na,1,2\n", "row 2 has no name and three"),
        ("a.csv", "name,x,y,z\na,1,2,3\na,1,2,3\n", "'a' is there twice"),
        ("a.csv", "name,x,y,z\na,1,,3\n", "'a' has a coordinate"),
        ("a.csv", "name,x,y,z\n,1,2,3\n", "landmark 1 has no name"),
    ],
)
def test_what_cannot_be_read_is_refused_by_name(tmp_path, name, text, said) -> None:
    path: Path = tmp_path / name
    path.write_text(text)
    with pytest.raises(InputError, match=said) as refusal:
        read_landmarks(path)
    assert name in str(refusal.value)


def test_a_file_that_is_missing_or_no_text(tmp_path) -> None:
    for end in (".mrk.json", ".fcsv", ".csv"):
        with pytest.raises(InputError, match="cannot be read"):
            read_landmarks(tmp_path / f"nowhere{end}")
        (tmp_path / f"bytes{end}").write_bytes(b"\xff\xfe\x00\x00")
        with pytest.raises(InputError, match=f"bytes{end}"):
            read_landmarks(tmp_path / f"bytes{end}")


def test_axes_are_turned_only_where_they_are_known() -> None:
    assert POINTS.in_space("RAS") is POINTS
    assert POINTS.in_space("LPS").space == "LPS"
    with pytest.raises(InputError, match="does not say whether"):
        Landmarks(["a"], [[0, 0, 0]]).in_space("LPS")
    assert repr(POINTS) == "Landmarks('landmarks', 3 points, 1 without position)"
