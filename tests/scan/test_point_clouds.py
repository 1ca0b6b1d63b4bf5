"""Scans without faces: reading, refusing, and a surface over the same points."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from sherd.errors import InputError, InvalidMeshError, MeshFileError
from sherd.files.cloud_files import read_scan
from sherd.files.encode import encoded
from sherd.files.mesh_files import read_mesh
from sherd.mesh.point_cloud import PointCloud
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.scan.surface_from_points import surface_from_points

POINTS = np.random.default_rng(0).normal(size=(7, 3)).round(3)


def ply(points, names="xyz"):
    lines = ["ply", "format ascii 1.0", f"element vertex {len(points)}"]
    lines += [f"property double {name}" for name in names] + ["end_header"]
    return "\n".join([*lines, *(" ".join(map(str, row)) for row in points)]) + "\n"


FILES = {
    "a.ply": ply(POINTS),
    "a.obj": "".join(f"v {x} {y} {z}\n" for x, y, z in POINTS),
    "a.off": "OFF\n7 0 0\n" + "".join(f"{x} {y} {z}\n" for x, y, z in POINTS),
    "a.xyz": "# a scan\n" + "".join(f"{x} {y} {z} 255 0 7\n" for x, y, z in POINTS),
}


@pytest.mark.parametrize("name", list(FILES))
def test_points_are_read_in_order_and_read_mesh_refuses_them(tmp_path, name):
    path = tmp_path / name
    path.write_text(FILES[name])
    cloud = read_scan(path)
    assert isinstance(cloud, PointCloud)
    assert cloud.name == name
    assert cloud.normals is None
    np.testing.assert_allclose(cloud.points, POINTS)
    advice = r"7 points and no faces.* sherd\.surface_from_points\(sherd\.read_scan\(path\)\)"
    with pytest.raises(InputError, match=rf"{advice}|unknown suffix '\.xyz'"):
        read_mesh(path)


def test_normals_of_length_one_in_a_table_are_normals(tmp_path):
    path = tmp_path / "n.xyz"
    normals = POINTS / np.linalg.norm(POINTS, axis=1, keepdims=True)
    np.savetxt(path, np.hstack([POINTS, normals]))
    np.testing.assert_allclose(read_scan(path).normals, normals)
    for content in ("1 2 3\n4 5\n", "x y z\n", "1 2\n3 4\n5 6\n7 8\n"):
        path.write_text(content)
        with pytest.raises(InputError, match=r"n\.xyz: "):
            read_scan(path)


def test_noise_makes_no_holes_and_crumbs_stay_without_faces():
    """Noise of a seventh of the spacing: neighbors see different diagonals."""
    ball = trimesh.creation.icosphere(4).vertices
    rng = np.random.default_rng(0)
    noisy = ball + rng.normal(size=ball.shape) * 0.0105
    crumb = [3.0, 0.0, 0.0] + 0.05 * rng.random((6, 3)) * [1.0, 1.0, 0.0]
    points = np.concatenate([noisy, crumb])
    normals = np.concatenate([ball, np.tile([0.0, 0.0, 1.0], (6, 1))])
    mesh = surface_from_points(PointCloud(points, normals))
    assert len(mesh.boundary_vertices) == 0
    assert mesh.faces.max() < len(ball)


def test_normals_of_a_ply_file_are_kept_unless_they_are_zeros(tmp_path):
    normals = np.roll(POINTS, 1, axis=0)
    names = ["x", "y", "z", "nx", "ny", "nz"]
    (tmp_path / "n.ply").write_text(ply(np.hstack([POINTS, 2 * normals]), names))
    wanted = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    np.testing.assert_allclose(read_scan(tmp_path / "n.ply").normals, wanted)
    (tmp_path / "z.ply").write_text(ply(np.hstack([POINTS, 0 * POINTS]), names))
    assert read_scan(tmp_path / "z.ply").normals is None


def test_meshes_stay_meshes_and_bad_points_are_refused(tmp_path):
    plate = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    (tmp_path / "mesh.off").write_bytes(encoded(plate, ".off"))
    assert isinstance(read_scan(tmp_path / "mesh.off"), TriangleMesh)
    (tmp_path / "nan.ply").write_text(ply([[0, 0, 0], [1, "nan", 0], [0, 1, 0], [1, 1, 1]]))
    with pytest.raises(InvalidMeshError, match=r"nan\.ply: vertices\[1, 1\]"):
        read_scan(tmp_path / "nan.ply")
    (tmp_path / "few.off").write_text("OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n")
    with pytest.raises(InvalidMeshError, match="3 points"):
        read_scan(tmp_path / "few.off")
    (tmp_path / "huge.ply").write_text(ply(POINTS).replace("vertex 7", "vertex 999999999999"))
    with pytest.raises((MeshFileError, InvalidMeshError)):
        read_scan(tmp_path / "huge.ply")
    with pytest.raises(MeshFileError, match="no such file"):
        read_scan(tmp_path / "absent.ply")


@pytest.mark.parametrize("with_normals", [True, False])
def test_a_bumpy_ball_with_a_hole_is_found_again(with_normals):
    """Area, one component, one rim and the orientation; the points are the vertices."""
    ball = trimesh.creation.icosphere(4)
    vertices = ball.vertices * (1 + 0.1 * np.sin(4 * ball.vertices[:, :1])) + 1e-4
    kept = vertices[:, 2] < 0.8
    whole = TriangleMesh(vertices, ball.faces)
    part, old = whole.submesh(kept[whole.faces].all(axis=1))
    normals = whole.vertex_normals[old]
    mesh = surface_from_points(PointCloud(part.vertices, normals if with_normals else None))
    np.testing.assert_array_equal(mesh.vertices, part.vertices)
    assert mesh.area == pytest.approx(part.area, rel=0.02)  # notches of the rim are filled
    assert len(np.unique(mesh.faces)) == part.vertex_count
    agreement = (mesh.vertex_normals * normals).sum(axis=1)
    assert np.abs(agreement).min() > 0.9
    assert len({*np.sign(agreement)}) == 1
    assert agreement.min() > 0.9 or not with_normals
    assert len(mesh.boundary_vertices) < 1.3 * len(part.boundary_vertices)


def test_points_without_a_surface_are_refused():
    line = np.outer(np.arange(9.0), [1.0, 2, 3])
    for points in (line, np.ones((9, 3))):
        with pytest.raises(InvalidMeshError, match="no surface runs through"):
            surface_from_points(PointCloud(points))
    with pytest.raises(InvalidMeshError, match=r"normals\[2\]"):
        PointCloud(POINTS, np.where(np.arange(7)[:, None] == 2, 0.0, POINTS))


def test_a_perfect_grid_becomes_a_whole_sheet():
    """Both diagonals of each square are Delaunay; all corners must take the same."""
    rows, columns = np.divmod(np.arange(30 * 20), 20)
    mesh = surface_from_points(PointCloud(np.stack([rows, columns, np.zeros(600)], axis=1)))
    assert mesh.face_count == 2 * 29 * 19
    assert mesh.area == pytest.approx(29 * 19)
