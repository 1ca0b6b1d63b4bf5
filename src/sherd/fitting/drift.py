"""What the map drifted by along the skin, taken from the targets of a fit.

Where long stretches of skin look alike a map may be off by half an edge or two all along, and
neither neighborhoods nor elasticity say so: the first are as alike there, the second is at rest.
Bumps and hollows of the skin are finer than that. The pieces show them, and the full shape has
them, so the seen part of it moves along the pieces as one picture of a film onto the next.

Mean curvature tells more than what bending keeps, Gaussian curvature. It changes where a joint is
bent, but that is wider than the bumps, and what is around them is subtracted.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from sherd.arrays import Floats
from sherd.descriptors.relief import relief_and_bulge
from sherd.fitting.targets import Targets
from sherd.mesh.geometry import vertex_normals
from sherd.mesh.surface_finder import SurfaceFinder
from sherd.mesh.surface_points import closest_points
from sherd.mesh.topology import renumbered
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.optical_flow import Sight, flow_field, ranks, slopes
from sherd.spectral.sampling import decimate

__all__ = ["without_drift"]

# Bumps of these widths, in sqrt(area), wide ones first: a slope says how far off its bump is up to
# about its width, and places of a map are off by 0.005 to 0.02. Finer ones than the last are edges.
WIDTHS = (0.04, 0.025, 0.015)
# A picture wider than this decides for itself, a finer one only with what is around it. Of 15
# halves of animals the mean error of maps times 0.94 for 0.05, 0.95 for 0.1; 0.97 for 0.025, with
# which those of coarse meshes, whose bumps are noise, become up to a half worse.
SMOOTH = 0.05
# Steps at each width, as slopes are straight only so far.
STEPS = 3
# Of the distance to where the pieces end, in widths: nearer than so many what is around is missing.
CLEAR = 2
# Bumps of the finest width are several edges wide on a mesh of so many vertices.
FINE = 10000


def without_drift(shape: TriangleMesh, targets: Targets, surface: TriangleMesh) -> Targets:
    """The same targets, moved along the pieces to where their relief is that of the full shape.

    What lies too near to where the pieces end to see its surroundings would rather stay.

    Parameters
    ----------
    shape
        n vertices, in units of sqrt(area of the full shape).
    targets
        For its vertices.
    surface
        The matched faces of the pieces, in the same unit.
    """
    pieces = _thinner(surface)
    if shape.vertex_count <= 1.5 * FINE:
        field = _field(shape, targets, pieces)
    else:
        small, points = decimate(shape, max(FINE, len(shape.boundary_vertices) + 1))
        moved = _field(small, targets.between(shape, points), pieces)
        field = closest_points(small, shape.vertices).interpolate(small, moved)
    return Targets(targets.positions + field, targets.confidence)


def _thinner(surface: TriangleMesh) -> TriangleMesh:
    """The pieces with no more vertices than a full shape of `FINE` would have there."""
    most = max(int(FINE * surface.area), len(surface.boundary_vertices) + 1, 4)
    return surface if surface.vertex_count <= 1.5 * most else decimate(surface, most)[0]


def _field(shape: TriangleMesh, targets: Targets, surface: TriangleMesh) -> Floats:
    """By how much (n, 3) each vertex that is seen moves; the others do not."""
    field = np.zeros_like(targets.positions)
    whole = targets.seen[shape.faces].all(axis=1)
    if not whole.any():
        return field
    used, corners = renumbered(shape.faces[whole])
    # cut as the pieces are, so that what is around is missing to both
    seen = TriangleMesh(shape.vertices[used], corners)
    start: Floats = targets.positions[used]
    slide = np.zeros_like(start)
    finder, depth = SurfaceFinder(surface).follower(), _depth(surface)
    all_here = np.ones(len(used), dtype=bool)
    all_there = np.ones(surface.vertex_count, dtype=bool)
    # an average over less than an edge is the noise of each vertex
    edge = max(shape.mean_edge_length, surface.mean_edge_length)
    for width in (width for width in WIDTHS if width >= edge):
        pictures = []
        here, there = relief_and_bulge(seen, width), relief_and_bulge(surface, width)
        for own, other in zip(here, there, strict=True):
            other_ranks = ranks(other, all_there)
            pictures.append((ranks(own, all_here), other_ranks, slopes(surface, other_ranks)))
        for _ in range(STEPS):
            facing = vertex_normals(start + slide, corners)
            points = finder.closest(start + slide, facing)
            clear = points.interpolate(surface, depth) / (CLEAR * width)
            trust = seen.vertex_areas * np.clip(clear, 0.0, 1.0)
            sights = [
                Sight(own - points.interpolate(surface, other), points.interpolate(surface, steep))
                for own, other, steep in pictures
            ]
            up = points.interpolate(surface, surface.vertex_normals)
            laid = seen.vertex_areas
            slide = flow_field(seen, laid, trust, laid - trust, sights, up, slide, SMOOTH)
            feet: Floats = finder.closest(start + slide, facing).positions(surface)
            slide = feet - start
    field[used] = slide
    return field


def _depth(surface: TriangleMesh) -> Floats:
    """How far (m,) each vertex is from where the surface ends, in a straight line."""
    ends = surface.boundary_vertices
    if not len(ends):
        return np.full(surface.vertex_count, CLEAR * max(WIDTHS))
    depth: Floats = np.asarray(cKDTree(surface.vertices[ends]).query(surface.vertices)[0])
    return depth
