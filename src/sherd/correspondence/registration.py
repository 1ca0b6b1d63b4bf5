"""Elastic registration: the part, as rigid as possible, laid onto the full shape.

The first answer of every vertex is a place on the full shape with an error of a few vertex
spacings. Here the part becomes an elastic surface that is drawn to these places, then slides on
the full shape to where neighborhoods look alike. The elasticity knows what geodesics from
anchors do not: that small triangles keep their shape. Answers are points inside triangles.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.correspondence.elastic_kernel import fit_rotations, relax_positions, softened, strains
from sherd.correspondence.elastic_surface import ElasticSurface
from sherd.correspondence.part_data import PartData
from sherd.correspondence.similar_places import Look, similar_places
from sherd.mesh.geometry import vertex_normals
from sherd.mesh.surface_finder import SurfaceFinder
from sherd.mesh.surface_points import SurfacePoints
from sherd.template import Template

__all__ = [
    "Placement",
    "elastic_strain",
    "laid_on",
    "on_surface",
    "pulled_together",
]


# Data terms are areas over squared lengths: below such a length the elasticity decides, above
# it the data. Places from trilateration are noise of 0.02 to be averaged over a limb's width.
PLACE_LENGTH = 0.05
# Places farther off than this are wrong, not noisy.
PLACE_LIMIT = 0.04
# Similar neighborhoods are good to a vertex spacing or two.
SIMILAR_LENGTH = 0.04
# A similar place farther off than this after elastic averaging is another place, not a better one.
SIMILAR_LIMIT = 0.02
# The part lies on the full shape: hold it there below the size of a triangle.
SURFACE_LENGTH = 0.006
# A pin holds one vertex as firmly as the surface is held, against all its neighbors.
PIN_LENGTH = 0.002
# Skin stretches by some percent everywhere and by much more in the creases of joints.
STRAIN = 0.1
CG_TOLERANCE, CG_LIMIT = 1e-3, 200


@dataclass(frozen=True, eq=False)
class Placement:
    """The part laid on the full shape.

    Attributes
    ----------
    positions
        (n', 3) place of each vertex in the template's unit frame, near its surface.
    rotations
        (n', 3, 3) rotation from the part's frame.
    """

    positions: Floats
    rotations: Floats


def pulled_together(
    template: Template, part: PartData, places: Ints, *, rounds: int = 12
) -> Placement:
    """The elastic part drawn to a vertex of the full shape for each of its vertices.

    Places that remain far from the surface of their neighbors lose their weight.
    """
    elastic = part.elastic
    targets = template.unit.vertices[places]
    start = Placement(targets.copy(), np.tile(np.eye(3), (len(targets), 1, 1)))
    placement = _fitted(elastic, start)
    areas = part.mesh.vertex_areas / PLACE_LENGTH**2
    for step in range(rounds):
        off = ((placement.positions - targets) ** 2).sum(axis=1)
        limit = PLACE_LIMIT * max(1.0, 3.0 - 0.5 * step)  # graduated: first nobody is wrong
        trust = areas / (1 + off / limit**2) ** 2
        data = trust[:, None, None] * np.eye(3)
        pull = trust[:, None] * targets
        placement = _relaxed(elastic, placement, *_pinned(part, data, pull))
    return placement


def laid_on(
    template: Template,
    part: PartData,
    placement: Placement,
    look: Look,
    *,
    reaches: tuple[float, ...],
    slides: int = 3,
) -> Placement:
    """The elastic part laid on the full shape, drawn to similar places.

    One round per entry of `reaches`: look for similar places within that radius, then `slides`
    times find the closest points of the surface and relax.
    """
    queries = look.vertices
    elastic = part.elastic
    count = part.mesh.vertex_count
    areas = np.maximum(part.mesh.vertex_areas, 1e-9)
    density = count / len(queries)
    for reach in reaches:
        targets, confidence, _ = similar_places(template, placement.positions, look, reach=reach)
        confidence = confidence * look.trust
        for _ in range(slides):
            normals = vertex_normals(placement.positions, part.mesh.faces)
            points = template.finder.closest(placement.positions, normals)
            foot = points.positions(template.unit)
            up = points.interpolate(template.unit, template.unit.vertex_normals)
            up /= np.maximum(np.linalg.norm(up, axis=1, keepdims=True), 1e-12)
            hold = areas / SURFACE_LENGTH**2
            data = hold[:, None, None] * (up[:, :, None] * up[:, None, :] + 1e-4 * np.eye(3))
            pull = np.einsum("nij,nj->ni", data, foot)
            off = ((placement.positions[queries] - targets) ** 2).sum(axis=1)
            drawn = density * areas[queries] * confidence / SIMILAR_LENGTH**2
            drawn /= (1 + off / SIMILAR_LIMIT**2) ** 2
            data[queries] += drawn[:, None, None] * np.eye(3)
            pull[queries] += drawn[:, None] * targets
            placement = _relaxed(elastic, placement, *_pinned(part, data, pull))
    return placement


def on_surface(finder: SurfaceFinder, part: PartData, placement: Placement) -> SurfacePoints:
    """The point of the surface that `finder` knows under each vertex of the part itself."""
    positions = placement.positions
    normals = vertex_normals(positions, part.mesh.faces)
    if part.own_vertices is not None:
        positions = part.own_vertices.interpolate(part.mesh, positions)
        normals = part.own_vertices.interpolate(part.mesh, normals)
    return finder.closest(positions, normals)


def _pinned(part: PartData, data: Floats, pull: Floats) -> tuple[Floats, Floats]:
    """Add the user's pins to the data matrices (n', 3, 3) and their products with the targets."""
    if len(part.pin_vertices):
        weight = part.mesh.area / part.mesh.vertex_count / PIN_LENGTH**2
        data[part.pin_vertices] += weight * np.eye(3)
        pull[part.pin_vertices] += weight * part.pin_positions
    return data, pull


def _fitted(elastic: ElasticSurface, placement: Placement) -> Placement:
    rotations = np.empty_like(placement.rotations)
    fit_rotations(
        elastic.pointers, elastic.neighbors, elastic.weights, elastic.rest,
        placement.positions, rotations,
    )  # fmt: skip
    return replace(placement, rotations=rotations)


def _relaxed(
    elastic: ElasticSurface, placement: Placement, data: Floats, pull: Floats
) -> Placement:
    """One alternation: positions for the rotations, then rotations for the positions."""
    strain = strains(
        elastic.pointers, elastic.neighbors, elastic.weights, elastic.rest,
        placement.positions, placement.rotations,
    )  # fmt: skip
    weights = softened(elastic.pointers, elastic.neighbors, elastic.weights, strain / STRAIN)
    positions = relax_positions(
        elastic.pointers, elastic.neighbors, weights, elastic.rest,
        placement.rotations, data, pull, placement.positions, CG_TOLERANCE, CG_LIMIT,
    )  # fmt: skip
    return _fitted(elastic, Placement(positions, placement.rotations))


def elastic_strain(part: PartData, placement: Placement) -> Floats:
    """Relative strain (n',) at each vertex: 0 where the part moved rigidly, 0.1 is ten percent."""
    elastic = part.elastic
    return strains(
        elastic.pointers, elastic.neighbors, elastic.weights, elastic.rest,
        placement.positions, placement.rotations,
    )  # fmt: skip
