"""There and back: what two placements, of each shape on the other, say of each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sherd.arrays import Bools, Floats
from sherd.correspondence.question import Question
from sherd.correspondence.registration import Deformation, working_points
from sherd.mesh.surface_finder import SurfaceFinder
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["RoundTrip", "round_trip"]

# A point whose foot on the other shape is on its border belongs beyond it if it is farther off than
# half an edge: nearer, the border itself may have been cut at another edge.
BEYOND = 0.5
# Weight of a corner below which a point lies on the opposite edge.
ON_EDGE = 1e-6


@dataclass(frozen=True, eq=False)
class RoundTrip:
    """For each vertex of a working mesh: its place on the other shape, and what comes back.

    Attributes
    ----------
    points
        (n,) points of the other shape's working mesh under the placed vertex.
    there
        (n, 3) their positions.
    gap
        (n,) distance between the vertex and where the other direction brings its place back to.
    inverse
        (n, 3) where on the other shape lies what the other direction brings to the vertex.
    missed
        (n,) how far from the vertex the other shape's image passes.
    beyond
        (n,) bool, whether the vertex lies over the border of the other shape.
    """

    points: SurfacePoints
    there: Floats
    gap: Floats
    inverse: Floats
    missed: Floats
    beyond: Bools


def round_trip(question: Question, own: Deformation, other: Deformation) -> RoundTrip:
    """From the part onto the full shape by `own` and back by `other`, which lays the full shape."""
    full, part = question.full, question.part
    points = working_points(question, own)
    there = points.positions(full.mesh)
    back = points.interpolate(full.mesh, other.positions)
    gap = np.linalg.norm(back - part.mesh.vertices, axis=1)
    image = TriangleMesh(other.positions, full.mesh.faces, name=full.mesh.name)
    met = SurfaceFinder(image).closest(part.mesh.vertices, part.mesh.vertex_normals)
    missed = np.linalg.norm(met.positions(image) - part.mesh.vertices, axis=1)
    off = np.linalg.norm(there - own.positions, axis=1)
    over = on_border(full.mesh, points) & (off > BEYOND * full.mesh.mean_edge_length)
    over |= on_border(image, met) & (missed > BEYOND * full.mesh.mean_edge_length)
    return RoundTrip(points, there, gap, met.positions(full.mesh), missed, over)


def on_border(mesh: TriangleMesh, points: SurfacePoints) -> Bools:
    """Whether each point (p,) lies on the border: all corners that count are border vertices."""
    border = np.zeros(mesh.vertex_count, dtype=bool)
    border[mesh.boundary_vertices] = True
    count = points.barycentric > ON_EDGE
    along: Bools = np.all(border[mesh.faces[points.faces]] | ~count, axis=1)
    inside: Bools = np.all(count, axis=1)
    return along & ~inside
