"""Template: what depends on the full shape alone, saved and loaded without loss."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from sherd.template import LONGEST_EDGE, Template, canonical, working_mesh

from sherd.errors import MeshFileError
from sherd.mesh.triangle_mesh import TriangleMesh


@pytest.fixture(scope="module")
def shape() -> TriangleMesh:
    ball = trimesh.creation.icosphere(subdivisions=3)
    x, y, z = ball.vertices.T
    stretched = ball.vertices * [1.0, 1.3, 1.9]
    return TriangleMesh(
        stretched * (1 + 0.2 * x + 0.1 * y + 0.15 * z + 0.1 * y * z)[:, None],
        ball.faces,
        name="egg",
    )


@pytest.fixture(scope="module")
def template(shape: TriangleMesh) -> Template:
    made = Template(shape)
    made.prepare()
    return made


def test_the_working_shape_has_area_one_and_short_edges(template: Template) -> None:
    unit = template.unit
    ends = unit.vertices[unit.edges]
    assert np.isclose(unit.area, 1.0, atol=1e-9)
    assert np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).max() <= LONGEST_EDGE
    assert np.allclose(unit.vertices[: template.full.vertex_count], template.placed.vertices)


def test_motions_of_the_file_disappear(shape: TriangleMesh) -> None:
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    turn[:, 0] *= np.sign(np.linalg.det(turn))
    moved = shape.with_vertices(7.0 * shape.vertices @ turn.T + 5.0)
    one, other = canonical(shape, shape.length), canonical(moved, moved.length)
    assert np.abs(one.vertices - other.vertices).max() < 1e-9
    mirror = TriangleMesh(shape.vertices * [-1, 1, 1], shape.faces[:, ::-1])
    assert np.abs(canonical(mirror, shape.length).vertices - one.vertices).max() > 0.01


def test_large_meshes_are_reduced(shape: TriangleMesh) -> None:
    fine = trimesh.Trimesh(shape.vertices, shape.faces, process=False).subdivide_loop(3)
    mesh = canonical(TriangleMesh(fine.vertices, fine.faces), float(np.sqrt(fine.area)))
    assert mesh.vertex_count > 40_000
    assert working_mesh(mesh).vertex_count < 22_000


def test_labels_cover_the_shape_evenly(template: Template) -> None:
    gap = template.label_distances.min(axis=0)
    assert gap.max() < 0.06
    assert (
        template.cells[template.label_vertices] == np.arange(len(template.label_vertices))
    ).all()
    assert np.array_equal(template.label_to_label, template.label_to_label.T)


def test_saved_and_loaded_it_is_the_same(template: Template, tmp_path: Path) -> None:
    template.save(tmp_path / "egg.npz")
    loaded = Template.load(tmp_path / "egg.npz")
    assert loaded.full.name == "egg"
    for name in ("label_vertices", "label_distances", "label_directions", "spectra", "x_axes"):
        assert np.array_equal(getattr(loaded, name), getattr(template, name)), name


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 damaged", b"nonsense"])
def test_damaged_files_are_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "damaged.npz"
    path.write_bytes(content)
    with pytest.raises(MeshFileError, match="cannot be read as a template"):
        Template.load(path)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("format", np.zeros(3)),
        ("label_vertices", np.array([0, 10**6])),
        ("label_vertices", np.zeros(0, dtype=int)),
        ("label_distances", np.zeros((2, 2))),
        ("spectra", np.zeros((5, 3, 2), dtype=int)),
        ("normals", np.array(["x"])),
    ],
)
def test_arrays_that_do_not_belong_together_are_refused(
    template: Template, tmp_path: Path, name: str, value: np.ndarray
) -> None:
    path = tmp_path / "egg.npz"
    template.save(path)
    with np.load(path) as stored:
        content = dict(stored)
    np.savez(path, **{**content, name: value})
    with pytest.raises(MeshFileError, match="no template of this version"):
        Template.load(path)


def test_other_archives_and_missing_files_are_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "other.npz", vertices=np.zeros(3))
    with pytest.raises(MeshFileError, match="no template of this version"):
        Template.load(tmp_path / "other.npz")
    with pytest.raises(MeshFileError, match=r"missing\.npz"):
        Template.load(tmp_path / "missing.npz")
