"""Both shapes laid on each other as elastic surfaces, each where the other is, as one answer."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sherd.arrays import Bools, Floats
from sherd.correspondence.elastic_kernel import fit_rotations
from sherd.correspondence.labels.labeling import Labeling
from sherd.correspondence.labels.two_way import Both, TwoLabelings
from sherd.correspondence.question import Question
from sherd.correspondence.registration import (
    Deformation,
    elastic_strain,
    registered_to_positions,
    registered_to_surface,
)
from sherd.correspondence.shared.region_cut import WIDTH, shared_region
from sherd.correspondence.shared.round_trip import RoundTrip, round_trip
from sherd.correspondence.similar_places import Look, similar_places
from sherd.correspondence.trilateration import trilaterated_vertices
from sherd.correspondence.working_placement import (
    ANSWER_REACH,
    CUT_LEAST,
    CUT_LENGTH,
    FIRST_REACHES,
    SECOND_REACHES,
    Queries,
)
from sherd.descriptors.rotation_shot import trusted_equally
from sherd.surface.described import RADII

__all__ = ["SharedPlacement", "other_goes_on", "placed_together", "sharing_cost"]

# Where there and back end up farther apart than this, the two directions do not mean the same
# place: two spacings of labels.
CLOSES = 0.06
# Once both directions were drawn together, a vertex is shared if they close within the spacing of
# vertices on 10,000: a wrong place is no nearer, and the border is as sharp as the mesh.
CLOSED = 0.015
PLACE_ROUNDS, TOGETHER_ROUNDS = 12, 4
# As far above the price as a perfect vertex is below it.
MOST_COST = 2.0
# Strain is averaged over so many rings of neighbors, the width of a crease.
RINGS = 3


@dataclass(frozen=True, eq=False)
class SharedPlacement:
    """The placement of one shape's working mesh on the other.

    Attributes
    ----------
    deformation
        Of the working mesh, in the frame of the other shape.
    trip
        There and back from each vertex.
    shared
        (n,) bool, vertices that the other shape has too.
    strain
        (n,) relative strain of the elastic surface around each vertex.
    apart
        (n,) how far both directions were apart before they were drawn together.
    similarity
        (q,) similarity at the answers of the queries, inside what is shared.
    """

    deformation: Deformation
    trip: RoundTrip
    shared: Bools
    strain: Floats
    apart: Floats
    similarity: Floats


def placed_together(
    questions: Both[Question],
    labelings: TwoLabelings,
    queries: Both[Queries],
    *,
    strain: float,
) -> Both[SharedPlacement]:
    """Carry both labelings through to points and draw them together.

    Each direction starts from the nodes that the other brings back. Then, twice: lay both shapes
    on each other by similar neighborhoods, and draw each to the middle between its own place and
    the inverse of the other's, where these are near. The second time both see only what is shared.

    Parameters
    ----------
    questions
        The second shape on the first, and the first on the second.
    labelings
        Of both.
    queries
        Vertices of the second and of the first shape that look for similar places.
    strain
        What is accepted, see :func:`sharing_cost`.
    """
    found = (
        (labelings.forward, labelings.forward_agrees),
        (labelings.backward, labelings.backward_agrees),
    )
    laid, looks = [], []
    for question, (labeling, agrees), each in zip(questions, found, queries, strict=True):
        present = agrees[question.part.sparse.cells].astype(np.float64)
        start = _from_labeling(question, labeling, agrees, present)
        look = _look_by_cut(question, each)
        laid.append(
            registered_to_surface(question, start, look, reaches=FIRST_REACHES, present=present)
        )
    together = _drawn_together(questions, (laid[0], laid[1]), strain)
    laid = []
    for side, (question, each) in enumerate(zip(questions, queries, strict=True)):
        own, other = together[side], together[1 - side]
        look = _look_inside(question, each, own.shared, other.shared)
        present = own.shared.astype(np.float64)
        looks.append(look)
        laid.append(
            registered_to_surface(
                question, own.deformation, look, reaches=SECOND_REACHES, present=present
            )
        )
    together = _drawn_together(questions, (laid[0], laid[1]), strain)
    judged = [
        replace(
            own,
            similarity=similar_places(
                question.full, own.deformation.positions, look, reach=ANSWER_REACH
            )[2],
        )
        for question, own, look in zip(questions, together, looks, strict=True)
    ]
    return (judged[0], judged[1])


def sharing_cost(trip: RoundTrip, strain: Floats, accepted: float) -> Floats:
    """Cost (n,) of sharing each vertex; 1 is its price, and none costs more than 2.

    `max(gap / CLOSED, strain / accepted)`, and 2 over the border of the other shape: what comes
    back elsewhere is as little shared as what only fits when it is torn.
    """
    cost = np.maximum(trip.gap / CLOSED, strain / accepted)
    return np.where(trip.beyond, MOST_COST, np.minimum(cost, MOST_COST))


def other_goes_on(question: Question, trip: RoundTrip) -> Bools:
    """Vertices (n,) whose places lie farther inside the other shape than a border is blurred."""
    full = question.full
    depth = trip.points.interpolate(full.mesh, full.cut_distance)
    inside: Bools = depth > 2 * WIDTH
    return inside


def _from_labeling(
    question: Question, labeling: Labeling, agrees: Bools, present: Floats
) -> Deformation:
    trusted = replace(
        labeling, placed=agrees, local_cost=np.where(agrees, labeling.local_cost, np.inf)
    )
    targets = question.full.mesh.vertices[trilaterated_vertices(question, trusted)]
    start = Deformation(targets, fit_rotations(question.part.elastic, targets))
    return registered_to_positions(question, start, targets, rounds=PLACE_ROUNDS, present=present)


def _look_by_cut(question: Question, queries: Queries) -> Look:
    depth = question.part.cut_distance[queries.vertices]
    trust = np.clip(depth / CUT_LENGTH, CUT_LEAST, 1.0)
    return Look(queries.vertices, question.full.spectra, queries.cut_aware, trust)


def _look_inside(question: Question, queries: Queries, own: Bools, other: Bools) -> Look:
    """Both shapes see only what is shared, so all neighborhoods have the same cut."""
    full, part = question.full, question.part
    trust = own[queries.vertices].astype(np.float64)
    spectra = trusted_equally(part.spectra_at_within(queries.vertices, own), RADII)
    return Look(queries.vertices, full.spectra_within(other), full.axes.project(spectra), trust)


def _drawn_together(
    questions: Both[Question], laid: Both[Deformation], strain: float
) -> Both[SharedPlacement]:
    """Each drawn to the middle between its own places and the inverse of the other's."""
    drawn, gaps = [], []
    for question, own, trip in zip(questions, laid, _trips(questions, laid), strict=True):
        apart = np.maximum(np.linalg.norm(trip.there - trip.inverse, axis=1), trip.gap)
        closes = (apart < CLOSES) & ~trip.beyond & (trip.missed < CLOSES / 2)
        middle = 0.5 * (trip.there + trip.inverse)
        gaps.append(apart)
        drawn.append(
            registered_to_positions(
                question, own, middle, rounds=TOGETHER_ROUNDS, present=closes.astype(np.float64)
            )
        )
    together = (drawn[0], drawn[1])
    trips = _trips(questions, together)
    strained = [
        _around(question, elastic_strain(question.part, own))
        for question, own in zip(questions, together, strict=True)
    ]
    placements = []
    for side, (question, trip) in enumerate(zip(questions, trips, strict=True)):
        # the other surface is strained where this one is as well; either may tell
        there = trip.points.interpolate(question.full.mesh, strained[1 - side])
        worse = np.maximum(strained[side], there)
        cost = sharing_cost(trip, worse, strain)
        shared = shared_region(question.part.mesh, cost, other_goes_on(question, trip))
        nothing = np.empty(0)
        placements.append(SharedPlacement(together[side], trip, shared, worse, gaps[side], nothing))
    return (placements[0], placements[1])


def _around(question: Question, strain: Floats) -> Floats:
    """Strain (n,) averaged over some rings of neighbors: creases are narrow, tears are not."""
    mesh = question.part.mesh
    first, second = mesh.edges.T
    count = mesh.vertex_count
    capped = np.minimum(strain, 1.0)
    for _ in range(RINGS):
        total = capped + np.bincount(first, capped[second], count)
        total += np.bincount(second, capped[first], count)
        number = 1 + np.bincount(first, minlength=count) + np.bincount(second, minlength=count)
        capped = total / number
    return capped


def _trips(questions: Both[Question], laid: Both[Deformation]) -> Both[RoundTrip]:
    return (
        round_trip(questions[0], laid[0], laid[1]),
        round_trip(questions[1], laid[1], laid[0]),
    )
