"""Library: a folder of full shapes prepared once, which a part is identified among.

``index.json`` names each shape with two files and their SHA-256: the template, and its labels
alone, which is all that is read of most shapes.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import zipfile
import zlib
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from sherd.errors import MeshFileError, OutputError
from sherd.library.candidate import Candidate
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.npz import arrays_npz
from sherd.output import require_writable, write_bytes, write_text
from sherd.surface.coarse import coarse_arrays, coarse_from_arrays, coarse_surface
from sherd.surface.described import DescribedSurface
from sherd.surface.template import Template

__all__ = ["INDEX", "LIBRARY_FORMAT", "Library", "Shelf", "mesh_hash"]

INDEX = "index.json"
# Raise the number when a field or a stored array changes its meaning.
LIBRARY_FORMAT = "sherd library 1"
REMEDY = "make the library again (sherd template FULL... -o FOLDER --overwrite)"


@dataclass(frozen=True)
class Shelf:
    """What the index says of one shape.

    Attributes
    ----------
    name
        Of the shape, unlike all others of the library.
    mesh
        SHA-256 of its vertices and faces.
    vertices, area
        Of the shape as given; the area of the repaired one.
    template, coarse
        Names of its files.
    template_hash, coarse_hash
        SHA-256 of these files.
    """

    name: str
    mesh: str
    vertices: int
    area: float
    template: str
    coarse: str
    template_hash: str
    coarse_hash: str


@dataclass(frozen=True)
class Library:
    """A folder of prepared full shapes.

    Attributes
    ----------
    folder
        Where it lies.
    shelves
        The shapes, in the order in which they were added.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     Library.open_or_new(folder).shelves
    ()
    """

    folder: Path
    shelves: tuple[Shelf, ...] = ()

    def __repr__(self) -> str:
        return f"Library({str(self.folder)!r}, {len(self.shelves)} shapes)"

    @classmethod
    def open(cls, folder: str | os.PathLike[str]) -> Library:
        """The library in a folder.

        Raises
        ------
        MeshFileError
            If the folder holds none, or its index is damaged or of another version.
        """
        path = Path(folder) / INDEX
        try:
            document = json.loads(path.read_text(encoding="utf-8"))
            known = document["format"] == LIBRARY_FORMAT
            shelves = tuple(_shelf(entry) for entry in document["shapes"]) if known else ()
        except FileNotFoundError as error:
            raise MeshFileError(
                f"{folder}: holds no {INDEX}, so it is no library; make one "
                "(sherd template FULL... -o FOLDER)"
            ) from error
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise MeshFileError(f"{path}: cannot be read as a library's index; {REMEDY}") from error
        if not known:
            raise MeshFileError(
                f"{path}: is of the format {document['format']!r}, but {LIBRARY_FORMAT!r} is read; "
                f"{REMEDY}"
            )
        return cls(Path(folder), shelves)

    @classmethod
    def open_or_new(cls, folder: str | os.PathLike[str], *, overwrite: bool = False) -> Library:
        """The library in a folder, or an empty one in a free folder.

        Raises
        ------
        MeshFileError
            As :meth:`open`, unless `overwrite` is set: then what cannot be read is begun anew.
        OutputError
            If the folder holds other files, unless `overwrite` is set, or cannot be written.
        """
        target = Path(folder)
        require_writable(target, folder=True)
        if (target / INDEX).exists():
            try:
                return cls.open(target)
            except MeshFileError:
                if not overwrite:
                    raise
                return cls(target)
        others = sorted(p.name for p in target.iterdir()) if target.exists() else []
        others = [name for name in others if not _is_own(name)]  # an interrupted run left these
        if others and not overwrite:
            raise OutputError(
                f"{target}: holds {', '.join(others[:3])}, which no library names; choose another "
                "folder or allow to use it (--overwrite)"
            )
        return cls(target)

    def shelf_of(self, mesh: TriangleMesh) -> Shelf | None:
        """Where exactly this mesh already stands; None if it does not."""
        content = mesh_hash(mesh)
        return next((shelf for shelf in self.shelves if shelf.mesh == content), None)

    def require_free(self, mesh: TriangleMesh, *, overwrite: bool = False) -> None:
        """Refuse a name that another mesh has.

        Raises
        ------
        OutputError
            If a shape of the same name stands here, and shall not be replaced.
        """
        if any(shelf.name == mesh.name for shelf in self.shelves) and not overwrite:
            raise OutputError(
                f"{self.folder}: holds another shape named {mesh.name}; rename the file, or allow "
                "to replace it (--overwrite)"
            )

    def with_shape(self, template: Template, *, overwrite: bool = False) -> Library:
        """The library with one more shape, written: its two files first, then the index.

        A mesh that already stands here stays as it is.

        Raises
        ------
        OutputError
            If another shape has its name, unless `overwrite` is set, or the disk refuses.
        """
        full = template.full
        if self.shelf_of(full) is not None:
            return self
        self.require_free(full, overwrite=overwrite)
        content = mesh_hash(full)
        stem = f"{_plain_name(full.name)}-{content[:8]}"
        template_file, coarse_file = f"{stem}.template.npz", f"{stem}.coarse.npz"
        template.save(self.folder / template_file)
        coarse = arrays_npz(coarse_arrays(coarse_surface(template)))
        write_bytes(self.folder / coarse_file, coarse)
        shelf = Shelf(
            name=full.name,
            mesh=content,
            vertices=full.vertex_count,
            area=template.length**2,
            template=template_file,
            coarse=coarse_file,
            template_hash=_hash_of(self.folder / template_file),
            coarse_hash=hashlib.sha256(coarse).hexdigest(),
        )
        others = tuple(each for each in self.shelves if each.name != full.name)
        added = replace(self, shelves=(*others, shelf))
        document = {"format": LIBRARY_FORMAT, "shapes": [asdict(each) for each in added.shelves]}
        write_text(self.folder / INDEX, json.dumps(document, indent=2) + "\n")
        return added

    def candidates(self) -> tuple[Candidate, ...]:
        """All shapes, with what is cheap to ask read.

        Raises
        ------
        MeshFileError
            If a file is missing, damaged, or not the one that the index names.
        """
        return tuple(self.candidate(shelf) for shelf in self.shelves)

    def candidate(self, shelf: Shelf) -> Candidate:
        """One shape, with what is cheap to ask read; errors as of :meth:`candidates`."""
        return Candidate(shelf.name, shelf.area, self._coarse(shelf), partial(self.template, shelf))

    def template(self, shelf: Shelf) -> Template:
        """One shape with all that matching needs.

        Raises
        ------
        MeshFileError
            As :meth:`candidates`, or if the file is of an older version of sherd.
        """
        path = self.folder / shelf.template
        _require_hash(path, shelf.template_hash)
        return Template.load(path)

    def _coarse(self, shelf: Shelf) -> DescribedSurface:
        path = self.folder / shelf.coarse
        _require_hash(path, shelf.coarse_hash)
        try:
            with np.load(path, allow_pickle=False) as stored:
                return coarse_from_arrays(dict(stored), shelf.name)
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error) as error:
            raise MeshFileError(f"{path}: cannot be read ({error}); {REMEDY}") from error


def mesh_hash(mesh: TriangleMesh) -> str:
    """SHA-256 of vertices and faces."""
    digest = hashlib.sha256(mesh.vertices.astype("<f8").tobytes())
    digest.update(mesh.faces.astype("<i8").tobytes())
    return digest.hexdigest()


def _shelf(entry: object) -> Shelf:
    """An entry of the index; whatever it says, files lie in the folder itself."""
    if not isinstance(entry, dict):
        raise TypeError("an entry is no object")
    shelf = Shelf(**entry)
    if not (np.isfinite(shelf.area) and shelf.area > 0):
        raise ValueError("an area is not positive")
    return replace(shelf, template=Path(shelf.template).name, coarse=Path(shelf.coarse).name)


def _require_hash(path: Path, expected: str) -> None:
    try:
        found = _hash_of(path)
    except OSError as error:
        raise MeshFileError(f"{path}: cannot be read ({error.strerror}); {REMEDY}") from error
    if found != expected:
        raise MeshFileError(f"{path}: is not the file that {INDEX} names; {REMEDY}")


def _hash_of(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _plain_name(name: str) -> str:
    """What every file system takes of a name."""
    return re.sub(r"[^A-Za-z0-9._-]", "_", Path(name).stem)[:40] or "shape"


def _is_own(name: str) -> bool:
    return name.startswith(".") or name.endswith((".template.npz", ".coarse.npz"))
