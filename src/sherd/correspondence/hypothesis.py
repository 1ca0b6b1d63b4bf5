"""Hypothesis: one complete placement of the part, from a labeling to points and a score."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sherd.arrays import Bools, Floats, Ints, Singles
from sherd.correspondence.covered_vertices import covered_vertices
from sherd.correspondence.labeling import Labeling
from sherd.correspondence.part_data import (
    PartData,
    part_spectra,
    trusted_by_cut,
    trusted_equally,
)
from sherd.correspondence.registration import (
    Placement,
    elastic_strain,
    laid_on,
    on_surface,
    pulled_together,
)
from sherd.correspondence.similar_places import Look, similar_places
from sherd.correspondence.trilateration import trilaterated
from sherd.descriptors.rotation_shot import mirrored_spectra
from sherd.mesh.surface_points import SurfacePoints
from sherd.template import Template

__all__ = [
    "Hypothesis",
    "Queries",
    "mirrored_queries",
    "part_queries",
    "roughly_settled",
    "settled",
]


# Vertices that look for similar neighborhoods; the elasticity carries the others along.
QUERY_COUNT = 3000
# The first look must survive slides of a node spacing; each later one is nearer.
FIRST_REACHES = (0.05, 0.04)
SECOND_REACHES = (0.04, 0.03)
# A vertex spacing: the similarity of an answer is that of the vertices around it.
ANSWER_REACH = 0.012
# Before the region is known, neighborhoods over the cut are not trusted.
CUT_LENGTH, CUT_LEAST = 0.05, 0.1


@dataclass(frozen=True, eq=False)
class Queries:
    """Vertices (q,) of the part that look for similar places, and their spectra (5, q, 2 c).

    `cut_aware` weighs radii by the distance to the cut, `plain` does not.
    """

    vertices: Ints
    cut_aware: Singles
    plain: Singles


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """One placement of the part.

    Attributes
    ----------
    labeling
        What it started from.
    placement, points, mask
        The elastic part on the full shape, a point for every vertex, the region covered (n,).
    inside_spectra
        Spectra of the full shape when only the first region is seen.
    similarity
        (q,) similarity at the answers, neighborhoods seen inside the region only.
    strain
        (n',) relative strain of the elastic surface.
    score
        Area-weighted mean similarity minus mean strain, at most 1.
    """

    labeling: Labeling
    placement: Placement
    points: SurfacePoints
    mask: Bools
    inside_spectra: Singles
    similarity: Floats
    strain: Floats
    score: float


def part_queries(part: PartData, rng: np.random.Generator) -> Queries:
    """Choose the query vertices and describe them once."""
    used = np.unique(part.mesh.faces)
    if len(used) > QUERY_COUNT:
        used = np.sort(rng.choice(used, QUERY_COUNT, replace=False))
    spectra = part_spectra(part, used)
    return Queries(used, trusted_by_cut(part, used, spectra), trusted_equally(spectra))


def mirrored_queries(queries: Queries) -> Queries:
    """The same vertices on the part's mirror image."""
    return Queries(
        queries.vertices, mirrored_spectra(queries.cut_aware), mirrored_spectra(queries.plain)
    )


def settled(template: Template, part: PartData, labeling: Labeling, queries: Queries) -> Hypothesis:
    """Carry a labeling through to points: trilaterate, lay on, find the region, look again."""
    placement = _laid_by_neighborhoods(template, part, labeling, queries, FIRST_REACHES)
    look = _look_inside(template, part, placement, queries)
    placement = laid_on(template, part, placement, look, reaches=SECOND_REACHES)
    return _judged(template, part, labeling, placement, look)


def roughly_settled(
    template: Template, part: PartData, labeling: Labeling, queries: Queries
) -> Hypothesis:
    """As :func:`settled`, with one look only: enough to see and to judge a placement."""
    placement = _laid_by_neighborhoods(template, part, labeling, queries, FIRST_REACHES[:1])
    look = _look_inside(template, part, placement, queries)
    return _judged(template, part, labeling, placement, look)


def _laid_by_neighborhoods(
    template: Template,
    part: PartData,
    labeling: Labeling,
    queries: Queries,
    reaches: tuple[float, ...],
) -> Placement:
    """Before the region is known: neighborhoods count less where they reach over the cut."""
    placement = pulled_together(template, part, trilaterated(template, part, labeling))
    trust = np.clip(part.cut_distance[queries.vertices] / CUT_LENGTH, CUT_LEAST, 1.0)
    look = Look(queries.vertices, template.spectra, queries.cut_aware, trust)
    return laid_on(template, part, placement, look, reaches=reaches)


def _look_inside(
    template: Template, part: PartData, placement: Placement, queries: Queries
) -> Look:
    """Of the full shape only what the part covers is seen, so all neighborhoods are complete."""
    seen = covered_vertices(template.finder, placement.positions, part.mesh.faces)
    trust = np.ones(len(queries.vertices))
    return Look(queries.vertices, template.spectra_within(seen), queries.plain, trust)


def _judged(
    template: Template, part: PartData, labeling: Labeling, placement: Placement, look: Look
) -> Hypothesis:
    """The finished placement with its points, its region and its score."""
    _, _, similarity = similar_places(template, placement.positions, look, reach=ANSWER_REACH)
    strain = elastic_strain(part, placement)
    areas = part.mesh.vertex_areas
    score = np.average(similarity, weights=areas[look.vertices]) - np.average(
        np.minimum(strain, 1.0), weights=areas
    )
    mask = _covered(template, placement, part)
    points = on_surface(template.own_finder, part, placement)
    return Hypothesis(
        labeling, placement, points, mask, look.full_spectra, similarity, strain, float(score)
    )


def _covered(template: Template, placement: Placement, part: PartData) -> Bools:
    """The vertices (n,) of the full shape that the part covers."""
    positions, faces = placement.positions, part.mesh.faces
    known = template.own_vertices
    if known is None or template.placed.vertex_count <= template.unit.vertex_count:
        return covered_vertices(template.own_finder, positions, faces)
    # sampling the part for a million vertices would cost more than all the rest
    seen = covered_vertices(template.finder, positions, faces)
    share = known.interpolate(template.unit, seen.astype(np.float64))
    inside: Bools = (share >= 0.5) & (template.placed.vertex_areas > 0)
    return inside
