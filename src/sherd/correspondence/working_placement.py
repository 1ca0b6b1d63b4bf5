"""WorkingPlacement: one complete placement on the working meshes, with what speaks for it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sherd.arrays import Bools, Floats, Ints, Singles
from sherd.correspondence.labels.labeling import Labeling
from sherd.correspondence.question import Question
from sherd.correspondence.registration import (
    Deformation,
    elastic_strain,
    registered_to_places,
    registered_to_surface,
    surface_points,
)
from sherd.correspondence.similar_places import Look, similar_places
from sherd.correspondence.trilateration import trilaterated_vertices
from sherd.descriptors.rotation_shot import mirrored_spectra, trusted_by_cut, trusted_equally
from sherd.mesh.surface_points import SurfacePoints
from sherd.surface.described import LEAST_TRUST, RADII
from sherd.threads import cached_property

__all__ = [
    "Queries",
    "WorkingPlacement",
    "described_queries",
    "facing_viewer",
    "judged_placement",
    "look_from",
    "look_inside",
    "mirrored_queries",
    "part_queries",
    "placement_from_labeling",
    "placement_from_look",
    "query_vertices",
    "rough_placement_from_labeling",
    "seen_by_labeling",
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
# A vertex is covered if half of its surroundings are.
COVERED = 0.5


@dataclass(frozen=True, eq=False)
class Queries:
    """Vertices (q,) of the part that look for similar places, and their spectra (5, q, 2 k).

    They are projected to the axes of the full shape. `cut_aware` weighs radii by the distance to
    the cut, `plain` does not.
    """

    vertices: Ints
    cut_aware: Singles
    plain: Singles


@dataclass(frozen=True, eq=False)
class WorkingPlacement:
    """One placement of the part.

    Attributes
    ----------
    question
        The two shapes.
    deformation
        The elastic part on the full shape.
    similarity
        (q,) similarity at the answers, neighborhoods seen inside the region only.
    strain
        (n',) relative strain of the elastic surface.
    score
        Area-weighted mean similarity minus mean strain, at most 1.
    known_points
        `points`, where they are known better than by the deformation; None if not.
    """

    question: Question
    deformation: Deformation
    similarity: Floats
    strain: Floats
    score: float
    known_points: SurfacePoints | None = None

    @cached_property
    def points(self) -> SurfacePoints:
        """A point of the full shape itself for every vertex of the part itself.

        Found when they are asked for, as `mask` is.
        """
        if self.known_points is not None:
            return self.known_points
        return surface_points(self.question, self.question.full.own_finder, self.deformation)

    def distances_to(self, other: WorkingPlacement) -> Floats:
        """How far (n',) each vertex of the part's working mesh lies from where another lays it."""
        apart: Floats = np.linalg.norm(
            self.deformation.positions - other.deformation.positions, axis=1
        )
        return apart

    @cached_property
    def mask(self) -> Bools:
        """(n,) bool, the vertices of the full shape itself that the part covers.

        Found when it is asked for: of a placement that is not the answer nobody does.
        """
        return _covered(self.question, self.deformation)


def query_vertices(question: Question, rng: np.random.Generator) -> Ints:
    """Choose the vertices (q,) of the part that look for similar places."""
    used = question.part.mesh.used_vertices
    if len(used) > QUERY_COUNT:
        used = np.sort(rng.choice(used, QUERY_COUNT, replace=False))
    return used


def part_queries(question: Question, rng: np.random.Generator) -> Queries:
    """Choose the query vertices and describe them once."""
    return described_queries(question, query_vertices(question, rng))


def described_queries(question: Question, vertices: Ints) -> Queries:
    """Describe the query vertices (q,), as :func:`query_vertices` chooses them, once."""
    part, project = question.part, question.full.axes.project
    spectra = part.spectra_at(vertices)
    cut_aware = trusted_by_cut(spectra, part.cut_distance[vertices], RADII, LEAST_TRUST)
    return Queries(vertices, project(cut_aware), project(trusted_equally(spectra, RADII)))


def mirrored_queries(queries: Queries) -> Queries:
    """The same vertices on the part's mirror image."""
    return Queries(
        queries.vertices, mirrored_spectra(queries.cut_aware), mirrored_spectra(queries.plain)
    )


def placement_from_labeling(
    question: Question, labeling: Labeling, queries: Queries
) -> WorkingPlacement:
    """Carry a labeling through to points.

    Every vertex is trilaterated, the elastic part laid onto the full shape by neighborhoods; then
    the region is known, and the part slides once more, by neighborhoods inside it.
    """
    return placement_from_look(question, *seen_by_labeling(question, labeling, queries))


def seen_by_labeling(
    question: Question, labeling: Labeling, queries: Queries
) -> tuple[Deformation, Look]:
    """The first half of :func:`placement_from_labeling`: what is seen where the part lies."""
    deformation = _by_neighborhoods(question, labeling, queries, FIRST_REACHES)
    return deformation, look_inside(question, deformation, queries)


def placement_from_look(
    question: Question, deformation: Deformation, look: Look
) -> WorkingPlacement:
    """The second half of :func:`placement_from_labeling`: the part slides by what it sees."""
    deformation = registered_to_surface(question, deformation, look, reaches=SECOND_REACHES)
    return judged_placement(question, deformation, look)


def rough_placement_from_labeling(
    question: Question, labeling: Labeling, queries: Queries
) -> WorkingPlacement:
    """As :func:`placement_from_labeling`, with one look only: enough to see and to judge it."""
    deformation = _by_neighborhoods(question, labeling, queries, FIRST_REACHES[:1])
    return judged_placement(question, deformation, look_inside(question, deformation, queries))


def _by_neighborhoods(
    question: Question, labeling: Labeling, queries: Queries, reaches: tuple[float, ...]
) -> Deformation:
    """Before the region is known: neighborhoods count less where they reach over the cut."""
    deformation = registered_to_places(question, trilaterated_vertices(question, labeling))
    depth = question.part.cut_distance[queries.vertices]
    trust = np.clip(depth / CUT_LENGTH, CUT_LEAST, 1.0)
    look = Look(queries.vertices, question.full.spectra, queries.cut_aware, trust)
    return registered_to_surface(question, deformation, look, reaches=reaches)


def look_inside(question: Question, deformation: Deformation, queries: Queries) -> Look:
    """Of the full shape only what the part covers is seen, so all neighborhoods are complete."""
    full = question.full
    seen = full.finder.covered_vertices(deformation.positions, question.part.mesh.faces)
    trust = np.ones(len(queries.vertices))
    return Look(queries.vertices, full.spectra_within(seen), queries.plain, trust)


def look_from(
    question: Question, viewer: Floats, deformation: Deformation, queries: Queries
) -> Look:
    """Of the full shape only what faces the part's viewer (3,) is seen."""
    areas = question.part.mesh.vertex_areas
    seen = facing_viewer(question, viewer, deformation, areas)
    trust = np.ones(len(queries.vertices))
    return Look(queries.vertices, question.full.spectra_within(seen), queries.plain, trust)


def facing_viewer(
    question: Question,
    viewer: Floats,
    deformation: Deformation,
    weights: Floats,
    *,
    least: float = 0.0,
) -> Bools:
    """The vertices (n,) of the full shape that face the part's viewer by a cosine above `least`.

    `viewer` (3,) is carried along by the rotations of the part, on average by `weights` (n',).
    """
    toward = weights @ (deformation.rotations @ viewer)
    facing: Bools = question.full.normals @ toward > least * np.linalg.norm(toward)
    return facing


def judged_placement(question: Question, deformation: Deformation, look: Look) -> WorkingPlacement:
    """The finished placement with its points and its score."""
    full, part = question.full, question.part
    _, _, similarity = similar_places(full, deformation.positions, look, reach=ANSWER_REACH)
    strain = elastic_strain(part, deformation)
    areas = part.mesh.vertex_areas
    score = np.average(similarity, weights=areas[look.vertices]) - np.average(
        np.minimum(strain, 1.0), weights=areas
    )
    return WorkingPlacement(
        question=question,
        deformation=deformation,
        similarity=similarity,
        strain=strain,
        score=float(score),
    )


def _covered(question: Question, deformation: Deformation) -> Bools:
    """The vertices (n,) of the full shape itself that the part covers."""
    full = question.full
    positions, faces = deformation.positions, question.part.mesh.faces
    if full.own_vertices is None or full.placed.vertex_count <= full.mesh.vertex_count:
        return full.own_finder.covered_vertices(positions, faces)
    # sampling the part for a million vertices would cost more than all the rest
    seen = full.finder.covered_vertices(positions, faces)
    share = full.working.at_own_vertices(seen.astype(np.float64))
    inside: Bools = (share >= COVERED) & (full.placed.vertex_areas > 0)
    return inside
