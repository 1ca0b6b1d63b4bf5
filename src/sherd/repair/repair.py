"""repair: explicit repairs in a fixed order, each named in a report that keeps the old numbering.

Holes are never filled: a part *is* a shape with a hole.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sherd.arrays import Bools, Floats, FrozenState, Ints, frozen
from sherd.errors import InvalidMeshError, OptionError
from sherd.mesh import geometry
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.mesh.words import spelled
from sherd.repair.changes import STEPS

__all__ = ["DEFAULT_STEPS", "RepairReport", "RepairStep", "repair"]

# Faces without area hide which faces are neighbors, so they go first; copies of faces would make
# every edge non-manifold; seams are closed before sheets are told apart; only then is
# orientation defined; leaving vertices out last catches those that the other steps set free.
DEFAULT_STEPS: tuple[str, ...] = tuple(STEPS)


@dataclass(frozen=True)
class RepairStep:
    """What one repair did.

    Parameters
    ----------
    name
        One of DEFAULT_STEPS.
    count
        Elements concerned; 0 if there was nothing to do.
    area_fraction
        Area of the faces concerned over the area of the mesh before the step, in [0, 1].
    sentence
        The same in words.
    """

    name: str
    count: int
    area_fraction: float
    sentence: str


@dataclass(frozen=True, eq=False, repr=False)
class RepairReport(FrozenState):
    """What was repaired, and how old and new vertices correspond.

    Parameters
    ----------
    steps
        Every step that ran, in order.
    original_vertices
        (n_new,) int, the old index of each new vertex.
    new_vertices
        (n_old,) int, the new index of each old vertex, -1 if it belongs to no face any more.

    Examples
    --------
    >>> _, report = repair(TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [9, 9, 9]], [[0, 1, 2]]))
    >>> report.changed, report.new_vertices.tolist()
    (True, [0, 1, 2, -1])
    """

    steps: tuple[RepairStep, ...]
    original_vertices: Ints
    new_vertices: Ints

    def __repr__(self) -> str:
        done = ", ".join(f"{step.name} ({step.count})" for step in self.steps if step.count)
        before, after = len(self.new_vertices), len(self.original_vertices)
        return f"RepairReport({done or 'nothing to do'}; vertices {before} -> {after})"

    @property
    def changed(self) -> bool:
        """Whether any step found something to do."""
        return any(step.count for step in self.steps)

    @property
    def notices(self) -> tuple[str, ...]:
        """One sentence for each step that did something."""
        return tuple(step.sentence for step in self.steps if step.count)

    def to_original(self, values: ArrayLike, *, fill: float = np.nan) -> NDArray[np.generic]:
        """Values (n_new, ...) of the repaired mesh in the numbering of the original (n_old, ...).

        Vertices that are gone get `fill`; boolean and whole-number values need a `fill` of their
        own kind, such as False or -1. A doubled vertex gets the value of its largest sheet.

        Raises
        ------
        InvalidMeshError
            If there are not n_new values, or `fill` cannot be stored among them.
        """
        array = np.asarray(values)
        if len(array) != len(self.original_vertices):
            raise InvalidMeshError(
                f"values has length {len(array)}, but the repaired mesh has "
                f"{len(self.original_vertices)} vertices"
            )
        gone = self.new_vertices < 0
        result: NDArray[np.generic] = array[np.where(gone, 0, self.new_vertices)]
        if gone.any():
            if array.dtype.kind in "iub" and not np.isfinite(fill):
                raise InvalidMeshError(
                    f"{int(gone.sum())} vertices are gone, and values of type {array.dtype} have "
                    f"no {fill}; pass fill=-1 or fill=False"
                )
            result[gone] = fill
        return result

    def to_repaired(self, values: ArrayLike) -> NDArray[np.generic]:
        """Values (n_old, ...) of the original mesh in the numbering of the repaired (n_new, ...).

        Raises
        ------
        InvalidMeshError
            If there are not n_old values.
        """
        array = np.asarray(values)
        if len(array) != len(self.new_vertices):
            raise InvalidMeshError(
                f"values has length {len(array)}, but the original mesh has "
                f"{len(self.new_vertices)} vertices"
            )
        result: NDArray[np.generic] = array[self.original_vertices]
        return result


def repair(
    mesh: TriangleMesh, *, steps: Sequence[str] = DEFAULT_STEPS
) -> tuple[TriangleMesh, RepairReport]:
    """Repair a mesh step by step; no vertex is moved and no hole is filled.

    Parameters
    ----------
    mesh
        Any mesh; its fields follow the vertices.
    steps
        Names from DEFAULT_STEPS, carried out in the order given.

    Returns
    -------
    repaired : TriangleMesh
        With all default steps, a mesh whose edges have one or two faces, whose vertices have one
        fan of faces, and whose faces agree with their neighbors. Repairing it again changes
        nothing, save that sheets tangled at an edge may be joined in one more place, or be
        joined there and separated in another. The same object if there was nothing to do.
    report : RepairReport
        What was done, and the old numbering.

    Raises
    ------
    OptionError
        If a step is unknown.
    InvalidMeshError
        If no face with an area is left.

    Notes
    -----
    O(m log m) for m faces.

    Examples
    --------
    >>> soup = TriangleMesh(
    ...     [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]],
    ...     [[0, 1, 2], [3, 4, 5]],
    ... )
    >>> square, report = repair(soup)
    >>> square.vertex_count, report.new_vertices.tolist()
    (4, [0, 1, 2, 1, 3, 2])
    """
    unknown = [name for name in steps if name not in STEPS]
    if unknown:
        raise OptionError(f"step {unknown[0]!r} is unknown; known are {', '.join(STEPS)}")
    faces = mesh.faces
    original = np.arange(mesh.vertex_count)
    renumber = original
    done = []
    for name in steps:
        vertices = mesh.vertices[original]
        change = STEPS[name](vertices, faces)
        fraction = _share_of_area(vertices, faces, change.concerned)
        sentence = spelled(change.sentence, change.count)
        done.append(RepairStep(name, change.count, fraction, sentence))
        if not len(change.faces):
            raise InvalidMeshError(
                f"{mesh.name}: no face with an area is left after '{name}'; export the mesh again"
            )
        faces = change.faces
        original = original[change.origin]
        gone = renumber < 0
        renumber = np.where(gone, -1, change.renumber[np.where(gone, 0, renumber)])
    report = RepairReport(tuple(done), frozen(original), frozen(renumber))
    if not report.changed:
        return mesh, report
    fields = {key: values[original] for key, values in mesh.fields.items()}
    return TriangleMesh(mesh.vertices[original], faces, fields=fields, name=mesh.name), report


def _share_of_area(vertices: Floats, faces: Ints, concerned: Bools) -> float:
    if not concerned.any():
        return 0.0
    areas = geometry.face_areas(vertices, faces)
    share = float(areas[concerned].sum() / max(areas.sum(), np.finfo(float).tiny))
    return min(share, 1.0)
