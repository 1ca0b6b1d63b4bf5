"""Template: what depends on the full shape alone, saved and loaded without loss."""

from __future__ import annotations

import copy
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from sherd.errors import InputError, MeshFileError
from sherd.match import match
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.match_options import MatchOptions
from sherd.scan.intake import mesh_intake
from sherd.shapes.fragment import cut_by_ball, whole
from sherd.surface import described
from sherd.surface.prepared import as_template
from sherd.surface.template import ArrivingTemplate, Content, Template, file_content
from sherd.surface.working import LONGEST_EDGE


@pytest.fixture(scope="module")
def stored(template: Template, tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("template") / "egg.npz"
    template.save(path)
    return path


def test_the_working_mesh_has_area_one_and_short_edges(egg, template: Template) -> None:
    mesh = template.mesh
    ends = mesh.vertices[mesh.edges]
    assert mesh.area == pytest.approx(1.0, abs=1e-9)
    assert np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).max() <= LONGEST_EDGE
    assert np.allclose(mesh.vertices[: egg.vertex_count], template.placed.vertices)
    assert template.full is egg
    assert template.length == pytest.approx(np.sqrt(egg.area))


def test_labels_cover_the_shape_evenly(template: Template) -> None:
    assert template.dense.distances.min(axis=0).max() < 0.06


def test_a_basis_is_made_once_for_each_size(template: Template) -> None:
    basis = template.basis(6)
    assert template.basis(6) is basis
    assert template.basis(7) is not basis
    areas = template.mesh.vertex_areas
    product = basis.eigenvectors.T @ (areas[:, None] * basis.eigenvectors)
    np.testing.assert_allclose(product, np.eye(6), atol=1e-6)


def test_saved_and_loaded_it_is_the_same(template: Template, stored: Path) -> None:
    loaded = Template.load(stored)
    assert loaded.full.name == "egg"
    assert loaded.length == template.length
    for name in ("vertices", "distances", "between", "directions", "cells", "farthest_first"):
        one, other = getattr(loaded.dense, name), getattr(template.dense, name)
        np.testing.assert_array_equal(one, other, err_msg=name)
        assert one.dtype == other.dtype
    for name in ("normals", "spectra", "cell_axes", "cut_distance"):
        np.testing.assert_array_equal(getattr(loaded, name), getattr(template, name), err_msg=name)
    for name in ("full", "placed", "mesh"):
        one, other = getattr(loaded, name), getattr(template, name)
        np.testing.assert_array_equal(one.vertices, other.vertices, err_msg=name)
        np.testing.assert_array_equal(one.faces, other.faces, err_msg=name)
    np.testing.assert_array_equal(loaded.own_vertices.faces, template.own_vertices.faces)
    np.testing.assert_array_equal(
        loaded.own_vertices.barycentric, template.own_vertices.barycentric
    )


def test_what_was_stored_is_not_computed_again(stored: Path, monkeypatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("computed again")

    for name in ("smoothed_normals", "rotation_spectra", "dense_samples"):
        monkeypatch.setattr(described, name, refuse)
    loaded = Template.load(stored)
    loaded.prepare()
    assert loaded.normals.shape == (loaded.mesh.vertex_count, 3)


def test_matching_with_a_loaded_template_gives_the_same_bits(
    egg: TriangleMesh, template: Template, stored: Path
) -> None:
    upper = egg.vertices[egg.faces, 1].mean(axis=1) > 0
    part, _ = egg.submesh(upper)
    options = MatchOptions(side="given")
    made, loaded = match(template, part, options), match(Template.load(stored), part, options)
    assert made.best.score > 0.8
    for name in ("matched", "confidence", "mask", "membership"):
        np.testing.assert_array_equal(getattr(made.best, name), getattr(loaded.best, name))
    np.testing.assert_array_equal(made.points.faces, loaded.points.faces)
    np.testing.assert_array_equal(made.points.barycentric, loaded.points.barycentric)
    assert made.best.score == loaded.best.score


def test_a_template_of_another_mesh_is_refused(egg: TriangleMesh, stored: Path) -> None:
    same = Template.load(stored, full=mesh_intake(egg))
    assert same.full is egg
    moved = TriangleMesh(egg.vertices + 1e-9, egg.faces, name="moved")
    with pytest.raises(InputError, match="was made for another mesh than moved"):
        Template.load(stored, full=mesh_intake(moved))
    turned = TriangleMesh(egg.vertices, egg.faces[::-1], name="turned")
    with pytest.raises(InputError, match="was made for another mesh than turned"):
        Template.load(stored, full=mesh_intake(turned))


def test_an_arriving_template_is_what_is_loaded(
    egg: TriangleMesh, template: Template, stored: Path
) -> None:
    arriving = ArrivingTemplate(partial(file_content, stored), stored, mesh_intake(egg))
    assert arriving.prepared
    assert arriving.length == template.length
    np.testing.assert_array_equal(arriving.spectra, template.spectra)
    again = copy.deepcopy(arriving)
    np.testing.assert_array_equal(again.dense.distances, template.dense.distances)


def test_the_file_of_an_arriving_template_is_not_waited_for(egg: TriangleMesh) -> None:
    """Until something of it is needed: then what is wrong with it is told."""

    def content() -> Content:
        raise MeshFileError("cannot be read")

    arriving = ArrivingTemplate(content, Path("egg.npz"), mesh_intake(egg))
    assert arriving.placed.area == pytest.approx(1.0)
    arriving_part = cut_by_ball(whole(egg, egg), 0, 0.5).mesh
    with pytest.raises(MeshFileError, match="cannot be read"):
        match(arriving, arriving_part)


def test_an_arriving_template_of_another_mesh_is_refused(egg: TriangleMesh, stored: Path) -> None:
    moved = TriangleMesh(egg.vertices + 1e-9, egg.faces, name="moved")
    arriving = ArrivingTemplate(partial(file_content, stored), stored, mesh_intake(moved))
    with pytest.raises(InputError, match="was made for another mesh than moved"):
        arriving.prepare()


def test_a_template_is_not_prepared_by_asking(egg: TriangleMesh) -> None:
    fresh = Template(egg)
    assert not fresh.prepared
    assert "_given" not in vars(fresh)


def test_a_template_of_a_dirty_mesh_keeps_its_numbering(egg: TriangleMesh, tmp_path: Path) -> None:
    """A lonely vertex in front and a doubled face: repair runs again when it is loaded."""
    dirty = TriangleMesh(
        np.concatenate([[[9.0, 9.0, 9.0]], egg.vertices]),
        np.concatenate([egg.faces[:1], egg.faces]) + 1,
    )
    made = Template(dirty)
    made.save(tmp_path / "dirty.npz")
    loaded = Template.load(tmp_path / "dirty.npz")
    np.testing.assert_array_equal(loaded.full.vertices, dirty.vertices)
    assert loaded.intake.notices == made.intake.notices
    assert len(loaded.intake.notices) == 2
    assert loaded.placed.vertex_count == egg.vertex_count


def test_a_template_stays_itself(egg: TriangleMesh, template: Template) -> None:
    assert as_template(template) is template
    assert as_template(egg).full is egg


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 damaged", b"nonsense"])
def test_damaged_files_are_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "damaged.npz"
    path.write_bytes(content)
    with pytest.raises(MeshFileError, match="cannot be read as a template"):
        Template.load(path)


def test_cut_short_files_are_refused(stored: Path, tmp_path: Path) -> None:
    content = stored.read_bytes()
    path = tmp_path / "short.npz"
    path.write_bytes(content[: len(content) // 2])
    with pytest.raises(MeshFileError, match="cannot be read as a template"):
        Template.load(path)
    spoiled = bytearray(content)
    spoiled[len(content) // 2] ^= 0xFF
    path.write_bytes(spoiled)
    with pytest.raises(MeshFileError, match="cannot be read as a template"):
        Template.load(path)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("format", np.zeros(3)),
        ("format", np.int64(1)),
        ("dense_vertices", np.array([0, 10**6])),
        ("dense_vertices", np.zeros(0, dtype=int)),
        ("dense_distances", np.zeros((2, 2))),
        ("dense_directions", np.zeros((2, 2))),
        ("mesh_vertices", np.zeros((5, 3))),
        ("spectra", np.zeros((5, 3, 2), dtype=int)),
        ("normals", np.array(["x"])),
    ],
)
def test_arrays_that_do_not_belong_together_are_refused(
    stored: Path, tmp_path: Path, name: str, value: np.ndarray
) -> None:
    with np.load(stored) as archive:
        content = dict(archive)
    np.savez(tmp_path / "spoiled.npz", **{**content, name: value})
    with pytest.raises(MeshFileError, match="no template of this version"):
        Template.load(tmp_path / "spoiled.npz")


@pytest.mark.parametrize("vertex", [-1, 10**6])
def test_labels_at_vertices_that_do_not_exist_are_refused(
    stored: Path, tmp_path: Path, vertex: int
) -> None:
    with np.load(stored) as archive:
        content = dict(archive)
    content["dense_vertices"][7] = vertex
    np.savez(tmp_path / "spoiled.npz", **content)
    with pytest.raises(MeshFileError, match="no template of this version"):
        Template.load(tmp_path / "spoiled.npz")


def test_other_archives_and_missing_files_are_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "other.npz", vertices=np.zeros(3))
    with pytest.raises(MeshFileError, match="no template of this version"):
        Template.load(tmp_path / "other.npz")
    with pytest.raises(MeshFileError, match=r"missing\.npz: .*No such file"):
        Template.load(tmp_path / "missing.npz")
