"""Cut a mesh along a level of a vertex function, through its faces."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.errors import InfeasibleError
from sherd.mesh.surface_points import SurfacePoints, points_at_vertices
from sherd.mesh.topology import renumbered
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["clip", "largest_component"]


# A cut that passes a vertex within this share of an edge goes through the vertex instead:
# otherwise it would leave triangles a hundred times longer than wide.
SNAP = 0.02


def clip(mesh: TriangleMesh, values: Floats) -> tuple[TriangleMesh, SurfacePoints]:
    """The part of `mesh` where `values` (n,), linear on each face, is positive, and where it lies.

    The vertices of the part are exactly `points.positions(mesh)`; fields are interpolated. The
    parts by `values` and by `-values` together make up the mesh, without gap or overlap.

    Raises
    ------
    InfeasibleError
        If nothing is positive.
    """
    level = _snapped(mesh, values)
    sign = np.sign(level).astype(np.int64)
    corner_signs = sign[mesh.faces]
    positive, negative = (corner_signs > 0).sum(axis=1), (corner_signs < 0).sum(axis=1)
    flat = (positive == 0) & (negative == 0) & (values[mesh.faces].sum(axis=1) > 0)
    whole = (negative == 0) & ((positive > 0) | flat)
    cutter = _Cutter(mesh.faces, mesh.vertex_count)
    pieces = [mesh.faces[whole]]
    # one corner stays: it leads
    face, (lead, after, before) = _led(
        mesh.faces, (positive == 1) & (negative == 2), corner_signs > 0
    )
    pieces.append(
        np.stack([lead, cutter.cut(face, lead, after), cutter.cut(face, lead, before)], 1)
    )
    # one corner goes: it leads
    face, (lead, after, before) = _led(
        mesh.faces, (positive == 2) & (negative == 1), corner_signs < 0
    )
    first, second = cutter.cut(face, after, lead), cutter.cut(face, before, lead)
    pieces += [np.stack([after, before, second], 1), np.stack([after, second, first], 1)]
    # the cut goes through a corner: it leads
    face, (lead, after, before) = _led(
        mesh.faces, (positive == 1) & (negative == 1), corner_signs == 0
    )
    stays = sign[after] > 0
    middle = cutter.cut(face, np.where(stays, after, before), np.where(stays, before, after))
    pieces.append(
        np.stack([lead, np.where(stays, after, middle), np.where(stays, middle, before)], 1)
    )
    faces = np.concatenate(pieces)
    if len(faces) == 0:
        raise InfeasibleError(f"the cut leaves nothing of {mesh.name}; move it")
    return _assembled(mesh, faces, cutter, level)


class _Cutter:
    """Collects the edges that are cut; a cut edge is a vertex numbered from n on."""

    def __init__(self, faces: Ints, count: int) -> None:
        self._faces, self._count = faces, count
        self.inner: list[Ints] = []
        self.outer: list[Ints] = []
        self.face: list[Ints] = []

    def cut(self, face: Ints, inner: Ints, outer: Ints) -> Ints:
        """Provisional vertex numbers of the cuts of edges from `inner` (stays) to `outer`."""
        begin = self._count + sum(map(len, self.inner))
        self.inner.append(inner)
        self.outer.append(outer)
        self.face.append(face)
        return np.arange(begin, begin + len(inner))


def largest_component(mesh: TriangleMesh) -> tuple[TriangleMesh, Ints]:
    """The component with the largest area, and the vertices (k,) of the mesh that it has."""
    labels = mesh.component_labels[mesh.faces[:, 0]]
    largest = int(np.bincount(labels, mesh.face_areas).argmax())
    return mesh.submesh(labels == largest)


def _assembled(
    mesh: TriangleMesh, faces: Ints, cutter: _Cutter, level: Floats
) -> tuple[TriangleMesh, SurfacePoints]:
    count = mesh.vertex_count
    inner, outer, face = (np.concatenate(x) for x in (cutter.inner, cutter.outer, cutter.face))
    # the two faces at an edge cut it once
    _, first, place = np.unique(inner * count + outer, return_index=True, return_inverse=True)
    renumber = np.concatenate([np.arange(count), count + place])
    kept, faces = renumbered(renumber[faces])
    old, new = kept[kept < count], first[kept[kept >= count] - count]
    inner, outer, face = inner[new], outer[new], face[new]
    t = (level[inner] / (level[inner] - level[outer]))[:, None]
    corners = mesh.faces[face]
    weights = (1 - t) * (corners == inner[:, None]) + t * (corners == outer[:, None])
    at_vertices = points_at_vertices(mesh, old)
    points = SurfacePoints(
        np.concatenate([at_vertices.faces, face]),
        np.concatenate([at_vertices.barycentric, weights]),
    )
    fields = {key: points.interpolate(mesh, field) for key, field in mesh.fields.items()}
    return TriangleMesh(points.positions(mesh), faces, fields=fields, name=mesh.name), points


def _snapped(mesh: TriangleMesh, values: Floats) -> Floats:
    """`values` with 0 where the level passes a vertex too closely."""
    level = np.array(values, dtype=np.float64)
    start, end = mesh.edges.T
    crossing = (level[start] < 0) != (level[end] < 0)
    start, end = start[crossing], end[crossing]
    span = np.abs(level[start]) + np.abs(level[end])
    close = np.concatenate(
        [
            start[np.abs(level[start]) <= SNAP * span],
            end[np.abs(level[end]) <= SNAP * span],
        ]
    )
    level[close] = 0.0
    return level


def _led(faces: Ints, rows: Bools, lead: Bools) -> tuple[Ints, Ints]:
    """Numbers of the faces in `rows`, and their corners (3, r) turned to have `lead` first."""
    number = np.flatnonzero(rows)
    turn = (lead[number].argmax(axis=1)[:, None] + np.arange(3)) % 3
    return number, np.take_along_axis(faces[number], turn, axis=1).T
