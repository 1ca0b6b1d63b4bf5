"""Template: a shape described in its own unit, made once, asked many times, saved and loaded."""

from __future__ import annotations

import os
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from sherd.descriptors.principal_spectra import PrincipalAxes
from sherd.errors import InputError, MeshFileError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.npz import arrays_npz
from sherd.output import write_bytes
from sherd.scan.intake import Intake, MeshSource, mesh_intake
from sherd.surface.counted import counts_of, numbers_of
from sherd.surface.described import DescribedSurface, Known
from sherd.surface.samples import Samples
from sherd.surface.working import WorkingSurface, canonical, joined, working_surface
from sherd.threads import begun, cached_property

__all__ = ["ArrivingTemplate", "Content", "Template", "file_content"]

# Arrays of a file, by name.
Content: TypeAlias = dict[str, Any]
# Raise when what is saved changes its meaning.
FORMAT = 5


class Template(DescribedSurface):
    """What :func:`sherd.match` and :func:`sherd.locate` need to know about the full shape.

    All is computed on first use and kept, so that many parts pay for it once.

    Parameters
    ----------
    full
        The full shape: a mesh, or whatever :func:`sherd.match` takes for one.

    Attributes
    ----------
    intake
        The full shape as it was given and as it was repaired.

    Examples
    --------
    >>> from sherd.shapes.creature import creature
    >>> template = Template(creature(5000))
    >>> round(template.mesh.area, 6)
    1.0
    """

    def __init__(self, full: MeshSource | Intake) -> None:
        self._begin()
        self.intake = full if isinstance(full, Intake) else mesh_intake(full)

    @cached_property
    def placed(self) -> TriangleMesh:
        """The full shape at unit scale, whose vertices and faces answers are counted by."""
        return canonical(self.intake.mesh, self.intake.mesh.length)

    @cached_property
    def _given(self) -> tuple[WorkingSurface, Known]:
        # of a million vertices this takes seconds, in which the part can be made ready as well
        return working_surface(self.placed), Known()

    def __repr__(self) -> str:
        return f"Template({self.full.name!r}, {self.full.vertex_count} vertices)"

    def __getstate__(self) -> dict[str, Any]:
        return {**super().__getstate__(), "intake": self.intake}

    def __setstate__(self, state: dict[str, Any]) -> None:
        super().__setstate__({name: value for name, value in state.items() if name != "intake"})
        self.intake = state["intake"]

    @property
    def full(self) -> TriangleMesh:
        """The full shape as it was given."""
        return self.intake.original

    @property
    def length(self) -> float:
        """sqrt(area) of the repaired full shape, in its own unit."""
        return self.intake.mesh.length

    @property
    def prepared(self) -> bool:
        """Whether all that matching needs is known."""
        known = self._known if "_given" in vars(self) else Known()  # else it would be made now
        return all(
            name in vars(self) or getattr(known, name) is not None for name in ("spectra", "dense")
        )

    def prepare(self) -> None:
        """Compute now all that matching needs, instead of on first use."""
        _ = (self.spectra, self.dense)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the mesh and all that matching needs to one ``.npz`` file, atomically.

        For 10,000 vertices the file has 55 MB. It is not compressed: that would save a tenth and
        cost 0.3 s in reading.

        Raises
        ------
        OutputError
            If the file cannot be written.
        """
        self.prepare()
        distances, distance_step = counts_of(self.dense.distances)
        directions, direction_step = counts_of(self.dense.directions)
        arrays: dict[str, ArrayLike] = {
            "format": FORMAT, "name": self.full.name,
            "vertices": self.full.vertices, "faces": self.full.faces,
            "mesh_vertices": self.mesh.vertices, "mesh_faces": self.mesh.faces,
            "dense_vertices": self.dense.vertices,
            "dense_distances": distances, "dense_distance_step": distance_step,
            "dense_directions": directions, "dense_direction_step": direction_step,
            "normals": self.normals, "axes": self.axes.axes, "spectra": self.spectra,
        }  # fmt: skip
        write_bytes(path, arrays_npz(arrays, compressed=False))

    @classmethod
    def load(cls, path: str | os.PathLike[str], *, full: Intake | None = None) -> Template:
        """Read what :meth:`save` wrote; matching with it gives the same bits.

        Parameters
        ----------
        path
            The file.
        full
            The full shape, where it is at hand: it must be the one that the file was made for.

        Raises
        ------
        MeshFileError
            If the file is missing, damaged, or of another version of sherd.
        InputError
            If it was made for another mesh than `full`.
        """
        content = file_content(path)
        template = cls(_intake(content, path, full))
        template._given = _described(content, template.placed)
        return template


class ArrivingTemplate(Template):
    """A template whose file is still being read; what needs its content waits for it.

    Meanwhile other shapes are described, for which the length of the full shape is enough.

    Parameters
    ----------
    content
        Reads the content of the file; raises what keeps it from being read.
    path
        The file, for errors.
    full
        The full shape, which must be the one that the file was made for.
    """

    def __init__(self, content: Callable[[], Content], path: Path, full: Intake) -> None:
        super().__init__(full)
        self._content, self._path = content, path
        self._arrived = begun(self._made_of_content)

    @property
    def prepared(self) -> bool:
        """Such files hold all that matching needs."""
        return True

    @cached_property
    def _given(self) -> tuple[WorkingSurface, Known]:
        return self._arrived()

    def _made_of_content(self) -> tuple[WorkingSurface, Known]:
        content = self._content()
        _intake(content, self._path, self.intake)
        working, known = _described(content, self.placed)
        if known.dense is not None:  # what all that is asked begins with
            _ = (known.dense.cells, known.dense.leaving, known.dense.arriving)
        return working, known


def file_content(path: str | os.PathLike[str]) -> Content:
    """The arrays of a template file.

    Raises
    ------
    MeshFileError
        If the file is missing, damaged, or of another version of sherd.
    """
    try:
        with Path(path).open("rb") as stream, np.load(stream, allow_pickle=False) as stored:
            content: Content = dict(stored)
    except (OSError, ValueError, TypeError, EOFError, zipfile.BadZipFile, zlib.error) as error:
        reason = getattr(error, "strerror", None) or "damaged, or no template"
        raise MeshFileError(
            f"{path}: cannot be read as a template ({reason}); make it again"
        ) from error
    if _NAMES - set(content) or content["format"].tolist() != FORMAT or not _fit(content):
        raise MeshFileError(f"{path}: is no template of this version of sherd; make it again")
    return content


def _intake(content: Content, path: str | os.PathLike[str], full: Intake | None) -> Intake:
    """The full shape, from the file unless it is at hand; then it must be the same."""
    mesh = TriangleMesh(content["vertices"], content["faces"], name=str(content["name"]))
    if full is None:
        return mesh_intake(mesh)
    if not _same(mesh, full.original):
        raise InputError(
            f"{path}: was made for another mesh than {full.original.name}; name another file"
        )
    return full


def _described(content: Content, placed: TriangleMesh) -> tuple[WorkingSurface, Known]:
    """What the file knows of the shape `placed`."""
    mesh = TriangleMesh(content["mesh_vertices"], content["mesh_faces"], name=placed.name)
    known = Known(
        normals=content["normals"],
        axes=PrincipalAxes(content["axes"]),
        spectra=content["spectra"],
        dense=Samples.of(
            content["dense_vertices"],
            numbers_of(content["dense_distances"], float(content["dense_distance_step"])),
            numbers_of(content["dense_directions"], float(content["dense_direction_step"])),
        ),
    )
    return joined(placed, mesh), known


_NAMES = {
    "format", "name", "vertices", "faces", "mesh_vertices", "mesh_faces", "dense_vertices",
    "dense_distances", "dense_distance_step", "dense_directions", "dense_direction_step",
    "normals", "axes", "spectra",
}  # fmt: skip


def _same(mesh: TriangleMesh, other: TriangleMesh) -> bool:
    return np.array_equal(mesh.faces, other.faces) and np.array_equal(mesh.vertices, other.vertices)


def _fit(content: Content) -> bool:
    """Whether stored arrays have the shapes and kinds that belong together."""
    labels, vertices = content["dense_vertices"], len(np.atleast_1d(content["mesh_vertices"]))
    count = len(np.atleast_1d(labels))
    shapes = {
        "dense_vertices": (count,),
        "dense_distances": (count, vertices),
        "dense_distance_step": (),
        "dense_direction_step": (),
        "dense_directions": (count, count),
        "normals": (vertices, 3),
    }
    if any(content[name].shape != shape for name, shape in shapes.items()):
        return False
    spectra = content["spectra"]
    if spectra.ndim != 3 or spectra.shape[1] != vertices or count == 0:
        return False
    if content["axes"].ndim != 3 or 2 * content["axes"].shape[2] != spectra.shape[2]:
        return False
    if any(content[name].dtype != np.int16 for name in ("dense_distances", "dense_directions")):
        return False
    numbers = ("dense_distance_step", "dense_direction_step", "normals", "axes", "spectra")
    if any(content[name].dtype.kind != "f" for name in numbers):
        return False
    return bool(labels.dtype.kind == "i" and 0 <= labels.min() <= labels.max() < vertices)
