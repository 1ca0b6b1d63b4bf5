"""Repairs: known defects with known remedies, and properties of every repaired mesh."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sherd.errors import InvalidMeshError, OptionError
from sherd.mesh import gluing, topology
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.repair.repair import DEFAULT_STEPS, repair


def grid(rows=4, columns=5):
    """A flat sheet of rows x columns squares, two triangles each."""
    y, x = np.mgrid[: rows + 1, : columns + 1]
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1).astype(float)
    corner = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    low = np.stack([corner, corner + 1, corner + columns + 2], axis=1)
    high = np.stack([corner, corner + columns + 2, corner + columns + 1], axis=1)
    return vertices, np.vstack([low, high])


def cube():
    """The unit cube, twelve faces, outward."""
    vertices = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return vertices, np.array([[q[0], q[i], q[i + 1]] for q in quads for i in (1, 2)])


def volume(vertices, faces):
    a, b, c = vertices[faces].transpose(1, 0, 2)
    return np.einsum("mc,mc->", a, np.cross(b, c)) / 6


def moebius(count=12):
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    rims = []
    for side in (-0.3, 0.3):
        radius = 1 + side * np.cos(angle / 2)
        rims.append(
            np.stack([radius * np.cos(angle), radius * np.sin(angle), side * np.sin(angle / 2)], 1)
        )
    faces = []
    for i in range(count):
        low, high = i, i + count
        low_next, high_next = (i + 1, i + 1 + count) if i + 1 < count else (count, 0)
        faces += [[low, low_next, high], [low_next, high_next, high]]
    return np.vstack(rims), np.array(faces)


def counts(report):
    return {step.name: step.count for step in report.steps if step.count}


def fields_of(vertices):
    return {"number": np.arange(len(vertices), dtype=float)}


def test_clean_meshes_come_back_as_they_are():
    for vertices, faces in (grid(), cube(), moebius()):
        mesh = TriangleMesh(vertices, faces)
        repaired, report = repair(mesh)
        assert repaired is mesh
        assert not report.changed
        assert report.notices == ()
        assert np.array_equal(report.new_vertices, np.arange(len(vertices)))


@pytest.mark.parametrize("shape", [grid, cube, moebius])
def test_soup_is_welded_back(shape):
    vertices, faces = shape()
    soup = TriangleMesh(vertices[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3))
    repaired, report = repair(soup)
    assert counts(report) == {"weld seams": faces.size - len(vertices)}
    assert report.steps[2].area_fraction == pytest.approx(1)
    assert np.array_equal(repaired.vertices[repaired.faces], vertices[faces])
    # every old vertex lies where its new number lies
    assert np.array_equal(repaired.vertices[report.new_vertices], soup.vertices)


def test_rounding_apart_is_welded_and_a_gap_is_not():
    vertices, faces = grid(1, 1)
    left, right = faces
    for gap, joined in ((1e-7, True), (1e-4, False)):
        both = np.vstack([vertices[left], vertices[right] + [0, 0, gap]])
        repaired, _ = repair(TriangleMesh(both, [[0, 1, 2], [3, 4, 5]]))
        assert (repaired.vertex_count == 4) is joined


def test_a_slit_end_and_touching_corners_are_not_welded():
    # two triangles that share one point by position only
    mesh = TriangleMesh(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0], [-1, 0, 0], [0, -1, 0]],
        [[0, 1, 2], [3, 4, 5]],
    )
    assert repair(mesh)[0] is mesh


def test_degenerate_faces_leave_and_the_mesh_stays_whole():
    vertices, faces = grid()
    bad = [[3, 3, 4], [5, 5, 5], [0, 1, 2]]  # repeated twice and thrice, and on one line
    mesh = TriangleMesh(vertices, np.vstack([faces, bad]))
    repaired, report = repair(mesh)
    assert counts(report) == {"drop degenerate faces": 3}
    assert np.array_equal(repaired.faces, faces)
    assert report.notices == ("left out 3 faces without area",)


@pytest.mark.parametrize("offset", [0.0, 1e6])
@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
def test_thin_but_honest_faces_stay_at_any_scale(offset, scale):
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0.5, 1e-6, 0], [0.5, -1, 0]]) + offset
    mesh = TriangleMesh(vertices * scale, [[0, 1, 2], [0, 3, 1]])
    assert repair(mesh)[0] is mesh


def test_duplicate_faces_leave_whatever_their_turn_and_numbering():
    vertices, faces = grid()
    copies = np.vstack([vertices, vertices[faces[7]]])  # the same places under other numbers
    extra = [faces[3][[1, 2, 0]], faces[4][[0, 2, 1]], np.arange(3) + len(vertices)]
    repaired, report = repair(TriangleMesh(copies, np.vstack([faces, extra])))
    assert counts(report) == {"drop duplicate faces": 3, "drop unreferenced vertices": 3}
    assert np.array_equal(repaired.faces, faces)
    assert report.steps[1].area_fraction == pytest.approx(3 / (len(faces) + 3))


def test_unreferenced_vertices_leave_and_numbers_follow():
    vertices, faces = grid()
    shifted = np.vstack([[[9, 9, 9]], vertices, [[1e6, 0, 0]]])
    mesh = TriangleMesh(shifted, faces + 1, fields=fields_of(shifted))
    repaired, report = repair(mesh)
    assert counts(report) == {"drop unreferenced vertices": 2}
    assert np.array_equal(repaired.vertices, vertices)
    assert np.array_equal(repaired.fields["number"], np.arange(len(vertices)) + 1)
    assert report.new_vertices[0] == report.new_vertices[-1] == -1
    back = report.to_original(np.arange(len(vertices)), fill=-1)
    assert back.tolist() == [-1, *range(len(vertices)), -1]
    assert np.isnan(report.to_original(np.zeros(len(vertices)))[0])
    assert np.array_equal(report.to_repaired(mesh.vertices), repaired.vertices)


def test_lifting_refuses_what_it_cannot_do():
    vertices, faces = grid()
    _, report = repair(TriangleMesh(np.vstack([vertices, [[9, 9, 9]]]), faces))
    with pytest.raises(InvalidMeshError, match="values has length 3"):
        report.to_original(np.zeros(3))
    with pytest.raises(InvalidMeshError, match="values has length 3"):
        report.to_repaired(np.zeros(3))
    with pytest.raises(InvalidMeshError, match=r"1 vertices are gone.*pass fill=-1 or fill=False"):
        report.to_original(np.zeros(len(vertices), dtype=bool))
    assert report.to_original(np.ones(len(vertices), dtype=bool), fill=False).sum() == len(vertices)


def test_a_fin_comes_off_and_the_surface_stays():
    vertices, faces = grid()
    edge = [8, 9]  # inside the sheet
    fin = np.vstack([vertices, [[2.5, 1, 1]]])
    repaired, report = repair(TriangleMesh(fin, np.vstack([faces, [[*edge, len(vertices)]]])))
    assert counts(report)["split non-manifold edges"] == 1
    assert np.array_equal(repaired.faces[:-1], faces)
    assert repaired.component_count == 2
    assert np.array_equal(report.original_vertices[-2:], edge)


def test_crossing_sheets_become_two_flat_sheets():
    # two strips of two triangles each through the edge (0, 1): four faces at it
    vertices = [[0, 0, 0], [1, 0, 0], [0.5, 1, 0], [0.5, -1, 0], [0.5, 0, 1], [0.5, 0, -1]]
    faces = [[0, 1, 2], [1, 0, 3], [0, 1, 4], [1, 0, 5]]
    repaired, report = repair(TriangleMesh(vertices, faces))
    assert counts(report) == {"split non-manifold edges": 1}
    assert repaired.component_count == 2
    for label in (0, 1):
        sheet = repaired.vertices[repaired.component_labels == label]
        assert np.ptp(sheet, axis=0).min() == 0


def test_a_bow_tie_is_doubled():
    mesh = TriangleMesh(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], [[0, 1, 2], [0, 3, 4]]
    )
    repaired, report = repair(mesh)
    assert counts(report) == {"split non-manifold vertices": 1}
    assert repaired.faces.tolist() == [[0, 1, 2], [5, 3, 4]]
    assert report.original_vertices.tolist() == [0, 1, 2, 3, 4, 0]
    assert report.new_vertices.tolist() == [0, 1, 2, 3, 4]


def test_a_sliver_that_joining_flattens_goes():
    vertices = [[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 0], [2, -1e-7, 0], [4, 0, 0]]
    repaired, report = repair(TriangleMesh(vertices, [[0, 1, 2], [3, 5, 4]]))
    assert repaired.faces.tolist() == [[0, 1, 2]]
    assert report.new_vertices.tolist() == [0, 1, 2, 0, 1, -1]


def test_closed_pieces_far_from_each_other_are_seen_from_near():
    corners, outward = cube()
    vertices = np.vstack([corners, 0.7 * corners + 1e7])
    mesh = TriangleMesh(vertices, np.vstack([outward, outward + 8]))
    assert repair(mesh)[0] is mesh
    inward = TriangleMesh(vertices, np.vstack([outward, outward[:, ::-1] + 8]))
    turned = repair(inward)[0]
    assert np.array_equal(turned.face_normals, mesh.face_normals)


def test_orientation_follows_the_larger_area_of_a_sheet():
    vertices, faces = grid(10, 10)
    turned = faces.copy()
    turned[::3] = turned[::3][:, [0, 2, 1]]
    repaired, report = repair(TriangleMesh(vertices, turned))
    assert counts(report) == {"orient faces": len(faces[::3])}
    assert np.array_equal(repaired.faces, faces)


def test_closed_sheets_turn_outward_but_cavities_stay():
    vertices, faces = cube()
    repaired, report = repair(TriangleMesh(vertices, faces[:, ::-1]))
    assert volume(repaired.vertices, repaired.faces) == pytest.approx(1)
    assert counts(report) == {"orient faces": 12}
    hollow = TriangleMesh(
        np.vstack([vertices, 0.25 + vertices / 2]), np.vstack([faces, faces[:, ::-1] + 8])
    )
    assert repair(hollow)[0] is hollow
    open_box = TriangleMesh(vertices, faces[1:, ::-1])
    assert repair(open_box)[0] is open_box


def test_steps_can_be_chosen_and_unknown_ones_are_refused():
    vertices, faces = grid()
    mesh = TriangleMesh(np.vstack([vertices, [[9, 9, 9]]]), np.vstack([faces, [[0, 0, 1]]]))
    repaired, report = repair(mesh, steps=["drop degenerate faces"])
    assert [step.name for step in report.steps] == ["drop degenerate faces"]
    assert repaired.vertex_count == mesh.vertex_count
    with pytest.raises(OptionError, match="step 'fill holes' is unknown; known are drop deg"):
        repair(mesh, steps=["fill holes"])


def test_nothing_left_is_an_error():
    flat = TriangleMesh([[0, 0, 0], [1, 1, 1], [2, 2, 2]], [[0, 1, 2]], name="line.off")
    with pytest.raises(InvalidMeshError, match=r"line\.off: no face with an area is left"):
        repair(flat)


def assert_manifold(mesh):
    _, uses = topology.unique_edges(mesh.faces)
    assert uses.max() <= 2
    pairs = gluing.face_pairs(mesh.vertices, mesh.faces)
    fans = gluing.fans(mesh.faces, pairs)
    assert fans.max() + 1 == mesh.vertex_count  # one fan a vertex, no vertex without
    flips, _, one_sided = gluing.orientation_flips(mesh.vertices, mesh.faces, pairs)
    assert not (flips & ~one_sided).any()


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_any_damage_ends_in_a_manifold_mesh_or_a_plain_refusal(data):
    seed = data.draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    vertices, faces = (grid(3, 3), cube(), moebius(7))[data.draw(st.integers(0, 2))]
    for damage in data.draw(st.lists(st.integers(0, 6), max_size=6)):
        faces = faces.copy()
        some = rng.integers(len(faces), size=3)
        if damage == 0:
            faces[some[0], 0] = rng.integers(len(vertices))
        elif damage == 1:
            faces[some] = faces[some][:, ::-1]
        elif damage == 2:
            faces = np.vstack([faces, faces[some][:, [1, 2, 0]]])
        elif damage == 3:
            faces = np.vstack([faces, rng.integers(len(vertices), size=(2, 3))])
        elif damage == 4:
            vertices = np.vstack([vertices, vertices[faces[some]].reshape(-1, 3)])
            faces[some] = len(vertices) - 9 + np.arange(9).reshape(3, 3)
        elif damage == 5:
            vertices = vertices.copy()
            vertices[rng.integers(len(vertices))] = vertices[rng.integers(len(vertices))]
        else:
            faces = np.delete(faces, some[0], axis=0) if len(faces) > 2 else faces
    order = rng.permutation(len(faces))
    mesh = TriangleMesh(vertices, faces[order], fields=fields_of(vertices))
    try:
        repaired, report = repair(mesh)
    except InvalidMeshError:
        assert not mesh.face_areas.any()  # refused only for that
        return
    assert_manifold(repaired)
    again, more = repair(repaired)
    # tangled sheets, see repair(): what is welded there may meet along an edge and is split again
    assert set(counts(more)) <= {"weld seams", "orient faces", "split non-manifold edges"}
    assert_manifold(again)
    assert repaired.area <= mesh.area * (1 + 1e-12)
    original = report.original_vertices
    assert np.array_equal(repaired.vertices, mesh.vertices[original])
    assert np.array_equal(repaired.fields["number"], original)
    kept = report.new_vertices >= 0
    assert repaired.vertices[report.new_vertices[kept]] == pytest.approx(
        mesh.vertices[kept], abs=1e-5
    )


def test_steps_run_in_the_documented_order():
    assert DEFAULT_STEPS == (
        "drop degenerate faces",
        "drop duplicate faces",
        "weld seams",
        "split non-manifold edges",
        "split non-manifold vertices",
        "orient faces",
        "drop unreferenced vertices",
    )
