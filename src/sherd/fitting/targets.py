"""Targets: where the pieces say that the vertices of the full shape lie."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.errors import InfeasibleError
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.topology import renumbered
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.match_result import MatchResult
from sherd.results.transfer import nearest_part_points

__all__ = ["Targets", "matched_surface", "targets_of"]

# A vertex whose nearest image is on the border of the piece lies beyond it, unless it is nearer
# than this share of an edge: what the border says of it would hold for the border only.
BESIDE_BORDER = 0.1
# Of sqrt(area): fewer seen vertices than a rigid motion and a bend need are no fit.
FEWEST = 12


@dataclass(frozen=True, eq=False)
class Targets:
    """Positions for some vertices of the full shape, in units of sqrt(its area).

    Attributes
    ----------
    positions
        (n, 3) in the frame of the pieces; means nothing where the confidence is 0.
    confidence
        (n,) in [0, 1]: chance that the map is right there; 0 where no piece reaches.
    """

    positions: Floats
    confidence: Floats

    @property
    def seen(self) -> Bools:
        """(n,) where a piece reaches."""
        return self.confidence > 0

    def at(self, vertices: Ints) -> Targets:
        """Those of the given vertices (p,), in this order."""
        return Targets(self.positions[vertices], self.confidence[vertices])

    def between(self, shape: TriangleMesh, points: SurfacePoints) -> Targets:
        """Those of points of the shape; a point is seen if all corners around it are."""
        corners = self.seen[shape.faces[points.faces]] | (points.barycentric == 0)
        return Targets(
            points.interpolate(shape, self.positions),
            points.interpolate(shape, self.confidence) * corners.all(axis=1),
        )


def targets_of(matches: Sequence[MatchResult]) -> Targets:
    """Where the surest piece says that each vertex of the full shape lies.

    Raises
    ------
    InfeasibleError
        If hardly any vertex of the full shape is matched.
    """
    full = matches[0].full
    positions = np.zeros((full.vertex_count, 3))
    confidence = np.zeros(full.vertex_count)
    for match in matches:
        found = _targets_of_one(match)
        better = found.confidence > confidence
        positions[better] = found.positions[better]
        confidence[better] = found.confidence[better]
    seen = int((confidence > 0).sum())
    if seen < FEWEST:
        raise InfeasibleError(
            f"{full.name}: {seen} of its {full.vertex_count} vertices lie on matched vertices of "
            f"{', '.join(match.part.name for match in matches)}, but a fit needs {FEWEST}; look at "
            "the report of the match"
        )
    return Targets(positions, confidence)


def matched_surface(matches: Sequence[MatchResult]) -> TriangleMesh:
    """The matched faces of all pieces as one mesh, in units of sqrt(area of the full shape).

    Raises
    ------
    InfeasibleError
        If no face has three matched corners.
    """
    unit = matches[0].full.length
    vertices, faces, count = [], [], 0
    for match in matches:
        part = match.part
        vertices.append(part.vertices * match.scale / unit)
        faces.append(part.faces[match.matched[part.faces].all(axis=1)] + count)
        count += part.vertex_count
    kept = np.concatenate(faces)
    if not len(kept):
        names = ", ".join(match.part.name for match in matches)
        raise InfeasibleError(f"{names}: no face is matched, so there is nothing to fit to")
    used, faces_of_used = renumbered(kept)
    return TriangleMesh(np.concatenate(vertices)[used], faces_of_used, name="pieces")


def _targets_of_one(match: MatchResult) -> Targets:
    full, part = match.full, match.part
    points, found = nearest_part_points(match)
    border = np.zeros(part.vertex_count, dtype=bool)
    border[part.boundary_vertices] = True
    on_border = (border[part.faces[points.faces]] | (points.barycentric < 1e-6)).all(axis=1)
    off = np.linalg.norm(points.interpolate(part, match.positions) - full.vertices, axis=1)
    beyond = on_border & (off > BESIDE_BORDER * full.mean_edge_length)
    confidence = points.interpolate(part, match.confidence) * (found & ~beyond)
    return Targets(points.positions(part) * match.scale / full.length, confidence)
