"""inspect: counts, areas, topology and verdicts on shapes whose truth is known."""

from __future__ import annotations

import json

import numpy as np
import pytest

from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.repair.inspection import inspect


def torus(rings=8, sides=6):
    """A closed surface with one handle."""
    u, v = np.meshgrid(np.arange(rings), np.arange(sides), indexing="ij")
    big, small = 2 * np.pi * u.ravel() / rings, 2 * np.pi * v.ravel() / sides
    radius = 2 + 0.5 * np.cos(small)
    vertices = np.stack([radius * np.cos(big), radius * np.sin(big), 0.5 * np.sin(small)], axis=1)

    def at(i, j):
        return (i % rings) * sides + j % sides

    faces = []
    for i in range(rings):
        for j in range(sides):
            a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
            faces += [[a, b, c], [a, c, d]]
    return vertices, np.array(faces)


def findings(report):
    return {finding.name: finding.count for finding in report.findings}


def test_a_torus_has_one_handle_and_no_rim():
    report = inspect(TriangleMesh(*torus(), name="ring.ply"))
    assert report.usable == "usable"
    assert report.closed
    assert (report.genus, report.boundary_loop_count, report.component_count) == (1, 0, 1)
    assert report.findings == ()
    assert str(report).endswith("closed, genus 1\n  usable as it is")


def test_holes_are_rims_and_never_a_defect():
    vertices, faces = torus()
    report = inspect(TriangleMesh(vertices, np.delete(faces, [0, 50], axis=0)))
    assert report.usable == "usable"
    assert (report.genus, report.boundary_loop_count, report.boundary_edge_count) == (1, 2, 6)
    assert not report.closed


def test_components_and_their_shares():
    vertices, faces = torus()
    report = inspect(
        TriangleMesh(np.vstack([vertices, 3 * vertices + 9]), np.vstack([faces, faces + 48]))
    )
    assert report.component_count == 2
    assert report.genus == 2
    assert report.notes == ("the largest of 2 components holds 90 % of the area",)
    assert report.usable == "usable"


def test_defects_are_counted_with_their_area():
    vertices, faces = torus()
    turned = faces.copy()
    turned[10] = turned[10][::-1]
    bad = np.vstack([turned, [faces[3], [7, 7, 8]]])
    mesh = TriangleMesh(np.vstack([vertices, [[99, 99, 99]]]), bad)
    report = inspect(mesh)
    assert report.usable == "after repair"
    assert findings(report) == {
        "drop degenerate faces": 1,
        "drop duplicate faces": 1,
        "orient faces": 1,
        "drop unreferenced vertices": 1,
    }
    share = {finding.name: finding.area_fraction for finding in report.findings}
    assert share["drop duplicate faces"] == pytest.approx(mesh.face_areas[3] / mesh.area)
    assert share["drop degenerate faces"] == 0
    assert max(report.extent) == pytest.approx(5)  # the far vertex is on no face
    text = str(report)
    assert "wrong: 1 face on top of another" in text
    assert "repair: left out 1 vertex on no face" in text
    assert text.endswith("usable after repair")


def test_soup_is_usable_after_repair_and_its_topology_is_seen():
    vertices, faces = torus()
    soup = TriangleMesh(vertices[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3))
    report = inspect(soup)
    assert report.usable == "after repair"
    assert (report.component_count, report.boundary_loop_count, report.genus) == (96, 0, 1)
    assert "after repair there are 1 components" not in report.notes


def test_a_one_sided_band_is_said_to_be_one():
    angle = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    rims = [
        np.stack(
            [
                np.cos(angle) * (1 + s * np.cos(angle / 2)),
                np.sin(angle) * (1 + s * np.cos(angle / 2)),
                s * np.sin(angle / 2),
            ],
            axis=1,
        )
        for s in (-0.3, 0.3)
    ]
    faces = []
    for i in range(12):
        low, high = (i + 1, i + 13) if i < 11 else (12, 0)
        faces += [[i, low, i + 12], [low, high, i + 12]]
    report = inspect(TriangleMesh(np.vstack(rims), faces))
    assert report.genus is None
    assert report.boundary_loop_count == 1
    assert any("one side only" in note for note in report.notes)
    assert report.usable == "usable"


def test_without_area_a_mesh_is_unusable():
    report = inspect(TriangleMesh([[0, 0, 0], [1, 1, 1], [2, 2, 2]], [[0, 1, 2]]))
    assert report.usable == "unusable"
    assert "all faces have no area" in str(report)
    assert report.repairs == ()


def test_uneven_edges_are_noted():
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1e-5, 0, 0]]
    report = inspect(TriangleMesh(vertices, [[0, 1, 2], [0, 2, 3]]))
    assert any("times the shortest" in note for note in report.notes)


def test_the_report_is_plain_json():
    report = inspect(TriangleMesh(*torus()))
    again = json.loads(json.dumps(report.as_dict()))
    assert again["genus"] == 1
    assert again["usable"] == "usable"
    assert [step["count"] for step in again["repairs"]] == [0] * 7


@pytest.mark.parametrize("scale", [1e-12, 1e30])
def test_nothing_depends_on_the_unit(scale):
    vertices, faces = torus()
    small, plain = (
        inspect(TriangleMesh(vertices * scale, faces)),
        inspect(TriangleMesh(vertices, faces)),
    )
    assert small.median_edge == pytest.approx(plain.median_edge)
    assert small.usable == plain.usable == "usable"
