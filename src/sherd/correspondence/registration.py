"""Elastic registration: the part, as rigid as possible, laid onto the full shape.

The first answer of every vertex is a place on the full shape with an error of a few vertex
spacings. Here the part becomes an elastic surface that is drawn to these places, then slides on
the full shape to where neighborhoods look alike. The elasticity knows what geodesics from
anchors do not: that small triangles keep their shape. Answers are points inside triangles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.correspondence.elastic_kernel import fit_rotations, relax_positions, softened, strains
from sherd.correspondence.question import Question
from sherd.correspondence.similar_places import Look, similar_places
from sherd.mesh.geometry import lengths, vertex_normals
from sherd.mesh.surface_finder import SurfaceFinder
from sherd.mesh.surface_points import SurfacePoints
from sherd.surface.described import DescribedSurface

__all__ = [
    "Deformation",
    "elastic_strain",
    "registered_to_places",
    "registered_to_positions",
    "registered_to_surface",
    "surface_points",
    "working_points",
]

# Data terms are areas over squared lengths: below such a length the elasticity decides, above
# it the data. Places from trilateration are noise of 0.02 to be averaged over a limb's width.
PLACE_LENGTH = 0.05
# A round that moves vertices by so little, in the mean, is the last one: the next would move them
# by three quarters of it, and the slides that follow by five to fifteen times as much.
STILL = 2e-4
# Places farther off than this are wrong, not noisy.
PLACE_LIMIT = 0.04
# The limit is three times that at first and falls by half of it in each round (graduated
# non-convexity): first nobody is wrong.
FIRST_LIMIT, LIMIT_STEP = 3.0, 0.5
# Similar neighborhoods are good to a vertex spacing or two.
SIMILAR_LENGTH = 0.04
# A similar place farther off than this after elastic averaging is another place, not a better one.
SIMILAR_LIMIT = 0.02
# The part lies on the full shape: hold it there below the size of a triangle.
SURFACE_LENGTH = 0.006
# Along the surface it slides; so little of the hold keeps the system definite.
ALONG = 1e-4
# Skin stretches by some percent everywhere and by much more in the creases of joints.
STRAIN = 0.1
CG_TOLERANCE, CG_LIMIT = 1e-3, 200


@dataclass(frozen=True, eq=False)
class Deformation:
    """The part's working mesh laid on the full shape.

    Attributes
    ----------
    positions
        (n', 3) place of each vertex in the frame of the full shape, near its surface.
    rotations
        (n', 3, 3) rotation from the part's frame.
    """

    positions: Floats
    rotations: Floats


def registered_to_places(question: Question, places: Ints, *, rounds: int = 12) -> Deformation:
    """The elastic part drawn to a vertex (n',) of the full shape for each of its vertices.

    Places that remain far from the surface of their neighbors lose their weight.
    """
    targets = question.full.mesh.vertices[places]
    start = Deformation(targets, fit_rotations(question.part.elastic, targets))
    return registered_to_positions(question, start, targets, rounds=rounds)


def registered_to_positions(
    question: Question,
    start: Deformation,
    targets: Floats,
    *,
    rounds: int,
    present: Floats | None = None,
) -> Deformation:
    """The elastic part drawn from `start` to a position (n', 3) for each of its vertices.

    `present` (n',) in [0, 1] is how far each vertex has a place at all; elasticity alone carries
    those that have none. All have one if None. There are fewer than `rounds` where nothing moves
    any more.
    """
    part, deformation = question.part, start
    areas = part.mesh.vertex_areas / PLACE_LENGTH**2
    if present is not None:
        areas = areas * present
    for step in range(rounds):
        off = ((deformation.positions - targets) ** 2).sum(axis=1)
        limit = PLACE_LIMIT * max(1.0, FIRST_LIMIT - LIMIT_STEP * step)  # first nobody is wrong
        trust = areas / (1 + off / limit**2) ** 2
        data = trust[:, None, None] * np.eye(3)
        pull = trust[:, None] * targets
        before, deformation = deformation, _relaxed(question, deformation, data, pull)
        moved = ((deformation.positions - before.positions) ** 2).sum(axis=1).mean()
        if limit == PLACE_LIMIT and moved < STILL**2:
            break
    return deformation


def registered_to_surface(
    question: Question,
    deformation: Deformation,
    look: Look,
    *,
    reaches: tuple[float, ...],
    slides: int = 3,
    present: Floats | None = None,
) -> Deformation:
    """The elastic part laid on the full shape, drawn to similar places.

    One round per entry of `reaches`: look for similar places within that radius, then `slides`
    times find the closest points of the surface and relax. `present` (n',) in [0, 1] is how far
    each vertex has a place at all; all have one if None.
    """
    full, part, queries = question.full, question.part, look.vertices
    areas = np.maximum(part.mesh.vertex_areas, 1e-9)
    density = part.mesh.vertex_count / len(queries)
    surface = full.finder.follower()
    for reach in reaches:
        targets, confidence, _ = similar_places(full, deformation.positions, look, reach=reach)
        confidence = confidence * look.trust
        if present is not None:
            confidence = confidence * present[queries]
        for _ in range(slides):
            points = surface.closest(deformation.positions, _facing(question, deformation))
            foot = points.positions(full.mesh)
            up = points.interpolate(full.mesh, full.mesh.vertex_normals)
            up /= np.maximum(lengths(up), 1e-12)[:, None]
            hold = (areas if present is None else areas * present) / SURFACE_LENGTH**2
            data = hold[:, None, None] * (up[:, :, None] * up[:, None, :] + ALONG * np.eye(3))
            pull = np.einsum("nij,nj->ni", data, foot)
            off = ((deformation.positions[queries] - targets) ** 2).sum(axis=1)
            drawn = density * areas[queries] * confidence / SIMILAR_LENGTH**2
            drawn /= (1 + off / SIMILAR_LIMIT**2) ** 2
            data[queries] += drawn[:, None, None] * np.eye(3)
            pull[queries] += drawn[:, None] * targets
            deformation = _relaxed(question, deformation, data, pull)
    return deformation


def surface_points(
    question: Question, finder: SurfaceFinder, deformation: Deformation
) -> SurfacePoints:
    """The point of the surface that `finder` knows under each vertex of the part itself."""
    at_own = question.part.working.at_own_vertices
    return finder.closest(at_own(deformation.positions), at_own(_facing(question, deformation)))


def working_points(question: Question, deformation: Deformation) -> SurfacePoints:
    """The point of the full shape's working mesh under each vertex of that of the part."""
    normals = vertex_normals(deformation.positions, question.part.mesh.faces)
    return question.full.finder.closest(deformation.positions, normals)


def elastic_strain(part: DescribedSurface, deformation: Deformation) -> Floats:
    """Relative strain (n',) at each vertex: 0 where the part moved rigidly, 0.1 is ten percent."""
    return strains(part.elastic, deformation.positions, deformation.rotations)


def _facing(question: Question, deformation: Deformation) -> Floats:
    """Normals (n', 3) of the deformed part; at a pin that of the place it is pinned on.

    A pin that its neighbors do not follow stands out as a spike, whose normal says nothing: the
    closest point that faces the same way could be anywhere around.
    """
    full, pins = question.full, question.pins
    normals = vertex_normals(deformation.positions, question.part.mesh.faces)
    if len(pins.vertices):
        normals[pins.vertices] = full.mesh.vertex_normals[full.vertex_tree.query(pins.positions)[1]]
    return normals


def _relaxed(
    question: Question, deformation: Deformation, data: Floats, pull: Floats
) -> Deformation:
    """One alternation: positions for the rotations, then rotations for the positions.

    `data` (n', 3, 3) draw the vertices, `pull` (n', 3) is `data` times the targets; the pins are
    added to both.
    """
    part, pins = question.part, question.pins
    if len(pins.vertices):
        weight = part.mesh.area / part.mesh.vertex_count / pins.length**2
        data[pins.vertices] += weight * np.eye(3)
        pull[pins.vertices] += weight * pins.positions
    strain = elastic_strain(part, deformation)
    positions = relax_positions(
        softened(part.elastic, strain / STRAIN), deformation.rotations, data, pull,
        deformation.positions, CG_TOLERANCE, CG_LIMIT,
    )  # fmt: skip
    return Deformation(positions, fit_rotations(part.elastic, positions))
