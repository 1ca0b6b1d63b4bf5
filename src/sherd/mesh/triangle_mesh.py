"""TriangleMesh: vertices, faces and vertex fields, frozen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from sherd.arrays import Floats, FrozenState, Ints, frozen
from sherd.errors import InvalidMeshError
from sherd.mesh import geometry, topology
from sherd.mesh.validate import checked_faces, checked_field, checked_vertices
from sherd.threads import cached_property

__all__ = ["TriangleMesh"]


@dataclass(frozen=True, eq=False, repr=False)
class TriangleMesh(FrozenState):
    """A triangle mesh with optional vertex fields; all arrays are read-only.

    Boundaries, several components, non-manifold edges and unreferenced vertices are legal;
    :mod:`sherd.repair.repair` names what is wrong with a mesh and mends it on request.

    Parameters
    ----------
    vertices
        (n, 3) float, mesh length l, finite.
    faces
        (m, 3) int, indices into `vertices`, m >= 1, counterclockwise seen from outside.
    fields
        Values per vertex by name, each (n,) or (n, c) float.
    name
        What messages and reports call the mesh.

    Raises
    ------
    InvalidMeshError
        If an array does not describe a mesh; the message names the first bad element.

    Examples
    --------
    >>> triangle = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> triangle.area
    0.5
    """

    vertices: Floats
    faces: Ints
    fields: Mapping[str, Floats] = field(default_factory=dict, kw_only=True)
    name: str = field(default="mesh", kw_only=True)

    def __init__(
        self,
        vertices: ArrayLike,
        faces: ArrayLike,
        *,
        fields: Mapping[str, ArrayLike] | None = None,
        name: str = "mesh",
    ) -> None:
        checked = checked_vertices(vertices)
        # a frozen dataclass sets its own fields this way
        object.__setattr__(self, "vertices", checked)
        object.__setattr__(self, "faces", checked_faces(faces, len(checked)))
        stored = {
            key: checked_field(key, value, len(checked)) for key, value in (fields or {}).items()
        }
        object.__setattr__(self, "fields", MappingProxyType(stored))
        object.__setattr__(self, "name", name)

    def __repr__(self) -> str:
        return f"TriangleMesh({self.name!r}, {self.vertex_count} vertices, {self.face_count} faces)"

    @property
    def vertex_count(self) -> int:
        """N."""
        return len(self.vertices)

    @property
    def face_count(self) -> int:
        """M."""
        return len(self.faces)

    @cached_property
    def face_areas(self) -> Floats:
        """(m,) l^2."""
        return frozen(geometry.face_areas(self.vertices, self.faces))

    @cached_property
    def face_normals(self) -> Floats:
        """(m, 3) unit, zero on faces without area."""
        return frozen(geometry.face_normals(self.vertices, self.faces))

    @cached_property
    def vertex_areas(self) -> Floats:
        """(n,) l^2, barycentric: a third of each face; sums to `area`."""
        return frozen(geometry.barycentric_vertex_areas(self.vertices, self.faces))

    @cached_property
    def vertex_normals(self) -> Floats:
        """(n, 3) unit, area-weighted."""
        return frozen(geometry.vertex_normals(self.vertices, self.faces))

    @cached_property
    def area(self) -> float:
        """Total area, l^2."""
        return float(self.face_areas.sum())

    @property
    def length(self) -> float:
        """sqrt(area): the unit in which sherd states every length of a full shape, l."""
        return float(np.sqrt(self.area))

    @cached_property
    def edges(self) -> Ints:
        """(e, 2) undirected edges, lower index first."""
        return frozen(topology.unique_edges(self.faces)[0])

    @cached_property
    def mean_edge_length(self) -> float:
        """Mean over `edges`, l."""
        ends = self.vertices[self.edges]
        return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).mean())

    @cached_property
    def winding(self) -> int:
        """Which way faces run seen from outside: 1 counterclockwise, -1 clockwise, 0 mixed.

        Judged by the volume they enclose, and by edges that two faces run along in one direction.
        """
        directed = topology.half_edges(self.faces)
        keys = directed[:, 0] * self.vertex_count + directed[:, 1]
        keys.sort()
        if (keys[1:] == keys[:-1]).any():
            return 0
        a, b, c = (self.vertices - self.vertices.mean(axis=0))[self.faces.T]
        return -1 if np.einsum("mx,mx->", a, geometry.cross(b, c)) < 0 else 1

    @cached_property
    def used_vertices(self) -> Ints:
        """Indices of the vertices of a face, ascending."""
        return frozen(topology.named_vertices(self.faces, self.vertex_count))

    @cached_property
    def boundary_edges(self) -> Ints:
        """(b, 2) edges with one face only, lower index first."""
        return frozen(topology.boundary_edges(self.faces))

    @cached_property
    def boundary_vertices(self) -> Ints:
        """Indices of the vertices on an edge with one face only, ascending."""
        return frozen(np.unique(self.boundary_edges))

    @cached_property
    def component_labels(self) -> Ints:
        """(n,) component of each vertex, 0 the one with most vertices."""
        return frozen(topology.component_labels(self.faces, self.vertex_count))

    @property
    def component_count(self) -> int:
        """Number of components; an unreferenced vertex is one of its own."""
        return int(self.component_labels.max()) + 1

    def with_vertices(self, vertices: ArrayLike) -> TriangleMesh:
        """The same faces, fields and name on other positions (n, 3)."""
        return TriangleMesh(vertices, self.faces, fields=self.fields, name=self.name)

    def with_fields(self, **fields: ArrayLike) -> TriangleMesh:
        """A copy with these vertex fields added or replaced."""
        return TriangleMesh(
            self.vertices, self.faces, fields={**self.fields, **fields}, name=self.name
        )

    def submesh(self, face_mask: ArrayLike) -> tuple[TriangleMesh, Ints]:
        """The faces where `face_mask` (m,) bool holds, and the old index of each kept vertex.

        Raises
        ------
        InvalidMeshError
            If the mask has another length or keeps no face.
        """
        mask = np.asarray(face_mask, dtype=bool)
        if mask.shape != (self.face_count,):
            raise InvalidMeshError(
                f"face_mask has shape {mask.shape}, but {(self.face_count,)} is needed"
            )
        kept, faces = topology.renumbered(self.faces[mask])
        fields = {key: values[kept] for key, values in self.fields.items()}
        return TriangleMesh(self.vertices[kept], faces, fields=fields, name=self.name), kept
