"""The one door in: what is taken for a shape, what is refused, and that it says what it mended."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh

from sherd.errors import InputError, InvalidMeshError, MeshFileError
from sherd.files.mesh_files import write_mesh
from sherd.mesh.point_cloud import PointCloud
from sherd.mesh.surface_points import points_at_vertices
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.scan.intake import Intake, mesh_intake, scan_intake
from sherd.scan.numbering import (
    original_normals,
    original_points,
    repaired_vertices,
    turned_as_repaired,
)

BALL = trimesh.creation.icosphere(subdivisions=3)
DOORS = [mesh_intake, scan_intake]


@pytest.fixture(scope="module")
def mesh() -> TriangleMesh:
    return TriangleMesh(BALL.vertices * [1.0, 1.2, 1.5], BALL.faces, name="ball")


@pytest.fixture(scope="module")
def path(mesh: TriangleMesh, tmp_path_factory) -> Path:
    path: Path = tmp_path_factory.mktemp("intake") / "ball.ply"
    write_mesh(mesh, path)
    return path


@pytest.mark.parametrize("door", DOORS)
def test_every_kind_of_mesh_is_the_same_mesh(door, mesh: TriangleMesh, path: Path) -> None:
    kinds = {
        "mesh": mesh,
        "path": path,
        "words": str(path),
        "pair": (mesh.vertices, mesh.faces),
        "lists": (mesh.vertices.tolist(), mesh.faces.tolist()),
        "trimesh": trimesh.Trimesh(mesh.vertices, mesh.faces, process=False),
        "object": SimpleNamespace(vertices=mesh.vertices, faces=mesh.faces),
    }
    for kind, source in kinds.items():
        taken = door(source)
        np.testing.assert_array_equal(taken.original.faces, mesh.faces, err_msg=kind)
        np.testing.assert_allclose(taken.original.vertices, mesh.vertices, atol=1e-6, err_msg=kind)
        assert taken.notices == (), kind
        assert taken.side_known, kind
        assert taken.mesh is taken.original, kind
    assert door(mesh).original is mesh
    assert door(path).original.name == "ball.ply"


def test_what_was_taken_in_before_stays_itself(mesh: TriangleMesh) -> None:
    taken = mesh_intake(mesh)
    assert mesh_intake(taken) is taken
    assert scan_intake(taken) is taken


def test_points_are_taken_for_a_scan_and_not_for_a_mesh(mesh: TriangleMesh, tmp_path: Path) -> None:
    cloud = PointCloud(mesh.vertices, name="cloud")
    with pytest.raises(InputError, match=r"cloud: holds points and no faces.*surface_from_points"):
        mesh_intake(cloud)
    taken = scan_intake(cloud)
    np.testing.assert_array_equal(taken.original.vertices, mesh.vertices)
    assert not taken.side_known
    assert taken.notices[0] == (
        "holds 642 points and no faces; triangles were laid over the points, outward as far as "
        "their shape tells"
    )
    with_normals = scan_intake(PointCloud(mesh.vertices, mesh.vertex_normals))
    assert with_normals.side_known
    assert "outward by their normals" in with_normals.notices[0]
    file = tmp_path / "points.xyz"
    np.savetxt(file, mesh.vertices)
    from_file = scan_intake(file)
    assert from_file.original.vertex_count == 642
    assert not from_file.side_known
    with pytest.raises(MeshFileError, match=r"points\.xyz"):
        mesh_intake(file)


@pytest.mark.parametrize("door", DOORS)
@pytest.mark.parametrize(
    ("source", "kind"),
    [
        (None, "NoneType"),
        (7, "int"),
        (b"mesh.ply", "bytes"),
        (np.zeros((5, 3)), "ndarray"),
        ([np.zeros((5, 3)), np.zeros((2, 3), dtype=int)], "list"),
        ((np.zeros((5, 3)),) * 3, "tuple"),
        (trimesh.PointCloud(np.eye(3)), "PointCloud"),
        (SimpleNamespace(vertices=np.eye(3)), "SimpleNamespace"),
    ],
)
def test_what_is_no_mesh_is_refused(door, source: object, kind: str) -> None:
    message = rf"^{kind} is no mesh; give a TriangleMesh, a path, a tuple \(vertices, faces\)"
    with pytest.raises(InputError, match=message) as refused:
        door(source)
    # whoever has points only learns how to give them, where that helps
    assert ("sherd.PointCloud(points)" in str(refused.value)) == (door is scan_intake)


@pytest.mark.parametrize("door", DOORS)
@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        (np.eye(3), [[0, 1, 5]], r"faces\[0, 2\] = 5, but there are 3 vertices"),
        (np.eye(3) * np.nan, [[0, 1, 2]], r"vertices\[0, 0\] = nan"),
        (np.eye(2), [[0, 1, 1]], r"vertices has shape \(2, 2\)"),
        (np.eye(3), [[0, 1, 1]], "no face with an area is left"),
    ],
)
def test_broken_meshes_are_refused_by_element(door, vertices, faces, message: str) -> None:
    with pytest.raises(InvalidMeshError, match=message):
        door((vertices, faces))


@pytest.mark.parametrize("door", DOORS)
def test_files_that_cannot_be_read_are_refused_by_name(door, path: Path, tmp_path: Path) -> None:
    with pytest.raises(MeshFileError, match=r"missing\.ply"):
        door(tmp_path / "missing.ply")
    odd = tmp_path / "scan.docx"
    odd.write_bytes(b"nothing")
    with pytest.raises(MeshFileError, match=r"scan\.docx"):
        door(odd)
    short = tmp_path / "short.ply"
    short.write_bytes(path.read_bytes()[:3000])
    with pytest.raises(MeshFileError, match=r"short\.ply: .*export or copy it again"):
        door(short)


def upper(mesh: TriangleMesh) -> TriangleMesh:
    return mesh.submesh(mesh.vertices[mesh.faces, 2].mean(axis=1) > 0.2)[0]


@pytest.fixture(scope="module")
def dirty(mesh: TriangleMesh) -> Intake:
    """The upper part in a soup, its faces backward, one in ten turned, and a lonely vertex."""
    part = upper(mesh)
    faces = 1 + np.arange(3 * part.face_count).reshape(-1, 3)
    faces[::10] = faces[::10, ::-1]
    soup = part.vertices[part.faces].reshape(-1, 3)
    return scan_intake((np.concatenate([[[0.0, 0.0, 9.0]], soup]), faces))


def test_what_was_mended_is_said(mesh: TriangleMesh, dirty: Intake) -> None:
    part = upper(mesh)
    assert all(text.startswith("repaired for this run: ") for text in dirty.notices)
    said = "; ".join(dirty.notices)
    for word in ("joined 1381 vertices", "turned 57 faces", "1 vertex on no face"):
        assert word in said, said
    assert dirty.side_known
    assert dirty.mesh.vertex_count == part.vertex_count
    assert dirty.mesh.face_count == part.face_count
    assert (dirty.mesh.vertex_normals[:, 2] > 0).mean() > 0.9
    assert dirty.original.vertex_count == 1 + 3 * part.face_count


def test_the_side_is_unknown_where_faces_disagree_too_much(mesh: TriangleMesh) -> None:
    part = upper(mesh)
    some = np.random.default_rng(0).random(part.face_count) < 0.5
    torn = TriangleMesh(part.vertices, np.where(some[:, None], part.faces[:, ::-1], part.faces))
    assert not scan_intake(torn).side_known
    # a closed surface tells by its volume
    some = np.random.default_rng(0).random(mesh.face_count) < 0.5
    closed = TriangleMesh(mesh.vertices, np.where(some[:, None], mesh.faces[:, ::-1], mesh.faces))
    taken = scan_intake(closed)
    assert taken.side_known
    assert (taken.mesh.vertex_normals * mesh.vertices).sum(axis=1).min() > 0


def test_turned_over_both_meshes_are_and_the_numbering_stays(dirty: Intake) -> None:
    other = dirty.turned_over()
    np.testing.assert_array_equal(other.original.faces, dirty.original.faces[:, ::-1])
    np.testing.assert_array_equal(other.mesh.faces, dirty.mesh.faces[:, ::-1])
    assert other.report is dirty.report
    assert other.notices == dirty.notices
    back = other.turned_over()
    np.testing.assert_array_equal(back.mesh.faces, dirty.mesh.faces)


def test_given_vertices_in_repaired_numbering(dirty: Intake) -> None:
    given = np.array([1, 20, 301])
    found = repaired_vertices(dirty, given, what="pairs.csv:")
    np.testing.assert_array_equal(dirty.mesh.vertices[found], dirty.original.vertices[given])
    count = dirty.original.vertex_count
    with pytest.raises(InputError, match=rf"pairs.csv: names vertex {count} of mesh, which has 0"):
        repaired_vertices(dirty, np.array([1, count]), what="pairs.csv:")
    with pytest.raises(InputError, match="names vertex -1 of mesh"):
        repaired_vertices(dirty, np.array([-1]), what="pairs.csv:")
    with pytest.raises(InputError, match="names vertex 0 of mesh, which belongs to no face"):
        repaired_vertices(dirty, np.array([0]), what="pairs.csv:")


def test_points_faces_and_normals_in_given_numbering(dirty: Intake) -> None:
    everyone = points_at_vertices(dirty.mesh, np.arange(dirty.mesh.vertex_count))
    back = original_points(dirty, everyone)
    np.testing.assert_allclose(back.positions(dirty.original), dirty.mesh.vertices, atol=1e-12)
    turned = turned_as_repaired(dirty)
    given, kept = dirty.original.faces, turned.faces
    assert (given != kept).any(axis=1).sum() == len(given[::10])
    normals = original_normals(dirty)
    assert (normals[0] == 0).all()
    faced = dirty.report.new_vertices[1:]
    np.testing.assert_array_equal(normals[1:], dirty.mesh.vertex_normals[faced])
    # each face looks to where its neighbors do
    assert (turned.face_normals * normals[kept[:, 0]]).sum(axis=1).min() > 0.5
    clean = mesh_intake(dirty.mesh)
    assert turned_as_repaired(clean) is dirty.mesh
    assert original_points(clean, everyone) is everyone
