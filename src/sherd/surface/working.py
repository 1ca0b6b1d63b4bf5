"""WorkingSurface: a shape at unit scale, the mesh that work is done on, and the way back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.mesh.sides import check_sides
from sherd.mesh.surface_points import SurfacePoints, closest_points
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.sampling import decimate
from sherd.spectral.subdivision import split_long_edges

__all__ = ["WorkingSurface", "canonical", "joined", "working_surface"]

# All lengths are in units of sqrt(area of the full shape). The smallest neighborhood that is
# described, 0.04, then holds ten vertices and more.
LONGEST_EDGE = 0.025
# Twice the usual 10,000 vertices are more than answers between vertices need.
MOST_VERTICES = 20_000
# A piece of a hundredth of the area is still sampled as a tenth would be.
LEAST_AREA = 0.1
# Right triangles with edges of at least half the longest length have at most 20,000 vertices
# on area 1; a quarter more is for those that are not even.
ROOM = 1.25
# A disk that needs n vertices has 3.5 sqrt(n) at its border, a tenth of a thousand. A denser
# border, as large scans have, would leave the inside without vertices, so it is thinned as well.
LARGEST_BORDER = 0.2


@dataclass(frozen=True, eq=False)
class WorkingSurface:
    """One shape, twice: as it was given and as it is worked on.

    Attributes
    ----------
    placed
        The shape itself at unit scale: its vertices are those that answers are counted by.
    mesh
        The same surface as a mesh of moderate size and even edges; `placed` itself where that is
        such a mesh.
    own_vertices
        Where the vertices of `placed` lie on `mesh`; None if they are its vertices.
    """

    placed: TriangleMesh
    mesh: TriangleMesh
    own_vertices: SurfacePoints | None

    def at_own_vertices(self, values: Floats) -> Floats:
        """Values (m,) or (m, c) at the vertices of `mesh`, interpolated at those of `placed`."""
        own = self.own_vertices
        return values if own is None else own.interpolate(self.mesh, values)

    def working_vertices(self, vertices: Ints) -> Ints:
        """The vertices (p,) of `mesh` nearest to the given ones of `placed`."""
        own = self.own_vertices
        return vertices if own is None else own[vertices].nearest_vertices(self.mesh)


def working_surface(placed: TriangleMesh) -> WorkingSurface:
    """The surface with a vertex wherever one is needed, and not many more.

    Neighborhoods are compared by their vertices, so both shapes need some in every ball: long
    edges are split, which leaves the surface and the given vertices as they are; only hair-thin
    faces, which would take vertices without end, keep longer edges. A mesh with many more vertices
    than answers need is decimated before.

    Parameters
    ----------
    placed
        In units of sqrt(area of the full shape), see :func:`canonical`.

    Raises
    ------
    InvalidMeshError
        If the faces do not agree on which side is outside.
    """
    mesh = placed
    most = int(MOST_VERTICES * max(mesh.area, LEAST_AREA))
    if mesh.vertex_count > most:
        keep = len(mesh.boundary_vertices) <= LARGEST_BORDER * most
        mesh = decimate(mesh, most, keep_border=keep)[0]
    check_sides(mesh)
    room = int(ROOM * most)
    vertices, faces = split_long_edges(mesh.vertices, mesh.faces, LONGEST_EDGE, most=room)
    if len(vertices) > mesh.vertex_count:
        mesh = TriangleMesh(vertices, faces, name=mesh.name)
    return joined(placed, mesh)


def joined(placed: TriangleMesh, mesh: TriangleMesh) -> WorkingSurface:
    """The surface whose working mesh is known."""
    if mesh is placed or np.array_equal(mesh.faces, placed.faces):
        return WorkingSurface(placed, mesh, None)
    return WorkingSurface(placed, mesh, closest_points(mesh, placed.vertices))


def canonical(mesh: TriangleMesh, length: float) -> TriangleMesh:
    """`mesh` divided by `length`, its center at the origin, its principal axes the coordinates.

    The signs of the axes make the third moments positive, up to the last, which keeps the shape's
    handedness. So a motion of the file changes what follows by rounding errors only.
    """
    areas = mesh.vertex_areas / mesh.area
    centered = (mesh.vertices - areas @ mesh.vertices) / length
    _, axes = np.linalg.eigh(centered.T @ (areas[:, None] * centered))
    axes *= np.where(areas @ (centered @ axes) ** 3 < 0, -1.0, 1.0)
    axes[:, 0] *= np.sign(np.linalg.det(axes))
    return TriangleMesh(centered @ axes, mesh.faces, name=mesh.name)
