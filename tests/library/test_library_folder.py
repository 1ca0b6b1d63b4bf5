"""A library is what its index says, and nothing else is believed."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from sherd.errors import InputError, MeshFileError, OutputError
from sherd.library.candidate import candidates_of
from sherd.library.folder import INDEX, Library
from sherd.library.identify import candidates
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.surface.template import Template


def test_it_is_read_as_it_was_written(library: Library, templates) -> None:
    opened = Library.open(library.folder)
    assert opened == library
    assert [shelf.name for shelf in opened.shelves] == ["smooth", "bent"]
    for stored, made in zip(opened.candidates(), candidates_of(templates), strict=True):
        assert stored.name == made.name
        assert stored.area == pytest.approx(made.area, rel=1e-15)
        np.testing.assert_array_equal(stored.coarse.spectra, made.coarse.spectra)
        for name in ("vertices", "distances", "between", "directions"):
            one, other = getattr(stored.coarse.dense, name), getattr(made.coarse.dense, name)
            np.testing.assert_array_equal(one, other)
    full = opened.candidates()[1].template().full
    np.testing.assert_array_equal(full.vertices, templates[1].full.vertices)


def test_shapes_are_added_once_and_names_are_kept_apart(library: Library, templates, eggs) -> None:
    assert library.with_shape(templates[0]) is library
    other = TriangleMesh(eggs[0].vertices * 2, eggs[0].faces, name="smooth")
    with pytest.raises(OutputError, match="another shape named smooth"):
        library.require_free(other)
    replaced = library.with_shape(Template(other), overwrite=True)
    assert [shelf.name for shelf in replaced.shelves] == ["bent", "smooth"]
    assert replaced.shelves[1].area == pytest.approx(4 * eggs[0].area)


def test_what_is_broken_is_refused_by_name(library: Library) -> None:
    shelf = library.shelves[0]
    path = library.folder / shelf.template
    path.write_bytes(path.read_bytes()[:-9])
    with pytest.raises(MeshFileError, match=r"smooth-.*\.template\.npz: is not the file"):
        library.template(shelf)
    coarse = library.folder / shelf.coarse
    coarse.write_bytes(b"no arrays")
    with pytest.raises(MeshFileError, match="is not the file"):
        library.candidates()
    hashed = json.loads((library.folder / INDEX).read_text())
    hashed["shapes"][0]["coarse_hash"] = (
        "57d4a7b5a5a3a4d9ab1b5a9bbd9ed1dfb6c1cd8ee7be8fd2b6a7d8f2ba34b7ad"
    )
    (library.folder / INDEX).write_text(json.dumps(hashed))
    with pytest.raises(MeshFileError, match="coarse"):
        Library.open(library.folder).candidates()
    coarse.unlink()
    with pytest.raises(MeshFileError, match="cannot be read"):
        library.candidates()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"format": "sherd library 99"}, "is of the format 'sherd library 99'"),
        ({"shapes": [{"name": "x"}]}, "cannot be read as a library's index"),
        ({"shapes": 3}, "cannot be read as a library's index"),
    ],
)
def test_a_foreign_index_is_refused(tmp_path, change, said) -> None:
    document = {"format": "sherd library 1", "shapes": []} | change
    (tmp_path / INDEX).write_text(json.dumps(document))
    with pytest.raises(MeshFileError, match=said):
        Library.open(tmp_path)
    with pytest.raises(MeshFileError, match=said):
        Library.open_or_new(tmp_path)
    assert Library.open_or_new(tmp_path, overwrite=True).shelves == ()


def test_folders_of_others_are_left_alone(tmp_path) -> None:
    with pytest.raises(MeshFileError, match="is no library"):
        Library.open(tmp_path)
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(OutputError, match=r"holds notes\.txt"):
        Library.open_or_new(tmp_path)
    with pytest.raises(InputError, match="is no library folder"):
        candidates(tmp_path / "notes.txt")
    (tmp_path / "notes.txt").unlink()
    with pytest.raises(InputError, match="the library is empty"):
        candidates(Library.open_or_new(tmp_path))


def test_files_that_an_index_names_lie_in_the_folder(library: Library) -> None:
    path = library.folder / INDEX
    document = json.loads(path.read_text())
    document["shapes"][0]["template"] = "../../elsewhere.npz"
    path.write_text(json.dumps(document))
    assert Library.open(library.folder).shelves[0].template == "elsewhere.npz"


def test_shapes_of_one_name_are_numbered(templates) -> None:
    names = [each.name for each in candidates_of([templates[0], templates[1], templates[0]])]
    assert names == ["smooth (0)", "bent", "smooth (2)"]
    with pytest.raises(InputError, match="no full shape"):
        candidates_of([])


def test_a_shelf_is_what_it_says(library: Library) -> None:
    wrong = replace(library.shelves[0], template="nothing.npz")
    with pytest.raises(MeshFileError, match=r"nothing\.npz: cannot be read"):
        library.template(wrong)
