"""The full shapes of a batch: described once, kept in files, loaded once by each worker."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from sherd.batching.ledger.fingerprint import Fingerprint
from sherd.errors import InputError, MeshFileError
from sherd.library.folder import Library, mesh_hash
from sherd.scan.intake import MeshSource, mesh_intake
from sherd.surface.template import Template

__all__ = ["FullShape", "full_shapes", "loaded_template", "prepare_templates"]

TEMPLATES = "templates"
# One template of 10,000 vertices holds 82 MB; a worker that needs more of them loads again, .6 s.
KEPT_TEMPLATES = 4


@dataclass(frozen=True)
class FullShape:
    """A full shape, by what it was given as and where its template is kept.

    Attributes
    ----------
    name
        Of its file.
    source
        What was given: a path as it was typed, or the name of a mesh.
    content
        SHA-256 of its file, or of its arrays.
    template
        File of its template.
    file
        Its own file, for what the template does not keep: values at its vertices, and what reading
        it had to say. Of a mesh in memory and of a library there is none, and its values are not
        written.
    library
        Folder of the library that it stands in, if in one.
    """

    name: str
    source: str
    content: str
    template: Path
    file: Path | None = None
    library: Path | None = None


def full_shapes(
    sources: Sequence[MeshSource | Template], folder: Path, *, template: Path | None = None
) -> tuple[tuple[FullShape, ...], dict[Path, MeshSource | Template]]:
    """The full shapes, and what those templates are made of that are not there yet.

    A source that is a folder is a library, and stands for all its shapes.

    Nothing is computed: a batch that has nothing left to do needs no template.

    Raises
    ------
    InputError
        If there are none, two have one name, or a file cannot be read.
    """
    if not sources:
        raise InputError("no full shape was given; name at least one file")
    given: list[tuple[FullShape, MeshSource | Template]] = []
    for source in sources:
        if isinstance(source, str | os.PathLike) and Path(source).is_dir():
            given += [(shape, source) for shape in _shapes_of_library(Path(source))]
        else:
            given.append((_full_shape(source, folder, template), source))
    shapes = [shape for shape, _ in given]
    if template is not None and (len(shapes) > 1 or shapes[0].library):
        raise InputError(
            f"{template}: a template is of one full shape; several keep theirs in the batch's "
            "folder, and a library has them"
        )
    names = [shape.name for shape in shapes]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"two full shapes are called {name}; rename one of the files")
    missing = {
        shape.template: source
        for shape, source in given
        if shape.library is None and not shape.template.exists()
    }
    return tuple(shapes), missing


def prepare_templates(missing: dict[Path, MeshSource | Template]) -> None:
    """Make the template files that are not there yet.

    Raises
    ------
    MeshFileError, InvalidMeshError, InputError
        If a full shape is no mesh.
    OutputError
        If a file cannot be written.
    """
    for path, source in missing.items():
        template = source if isinstance(source, Template) else Template(mesh_intake(source))
        template.save(path)


def loaded_template(shape: FullShape) -> Template:
    """The template of a full shape, read once by each process.

    Raises
    ------
    MeshFileError
        If its file is missing or damaged.
    """
    return _loaded(shape)


@lru_cache(maxsize=KEPT_TEMPLATES)
def _loaded(shape: FullShape) -> Template:
    for path in (shape.template, shape.file):
        if path is not None and not path.exists():
            raise MeshFileError(
                f"{path}: is not there; workers on other machines need the full shapes and the "
                "folder of the batch on a file system that all of them share"
            )
    full = None if shape.file is None else mesh_intake(shape.file)
    return Template.load(shape.template, full=full)


def _shapes_of_library(folder: Path) -> list[FullShape]:
    library = Library.open(folder)
    if not library.shelves:
        raise InputError(f"{folder}: the library is empty; add shapes (sherd template)")
    home = folder.absolute()
    return [
        FullShape(shelf.name, shelf.name, shelf.mesh, home / shelf.template, library=home)
        for shelf in library.shelves
    ]


def _full_shape(source: MeshSource | Template, folder: Path, template: Path | None) -> FullShape:
    file: Path | None
    if isinstance(source, str | os.PathLike):
        path = Path(source)
        try:
            content = Fingerprint.of(path).sha256
        except OSError as error:
            reason = error.strerror or str(error)
            raise MeshFileError(f"{path}: cannot be read ({reason}); check the path") from error
        name, typed, file = path.name, os.fspath(source), path.absolute()
    else:
        mesh = source.full if isinstance(source, Template) else mesh_intake(source).original
        content, name = mesh_hash(mesh), mesh.name
        typed, file = name, None
    kept = template or folder / TEMPLATES / f"{Path(name).stem}-{content[:16]}.npz"
    return FullShape(name, typed, content, kept.absolute(), file)
