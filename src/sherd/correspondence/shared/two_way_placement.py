"""Both shapes laid on each other as elastic surfaces, each where the other is, as one answer."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sherd.arrays import Bools, Floats, Singles
from sherd.correspondence.elastic_kernel import fit_rotations
from sherd.correspondence.labels.labeling import Labeling
from sherd.correspondence.labels.two_way import TwoLabelings
from sherd.correspondence.question import Question
from sherd.correspondence.registration import (
    Deformation,
    elastic_strain,
    registered_to_positions,
    registered_to_surface,
)
from sherd.correspondence.shared.region_cut import shared_region
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

__all__ = ["TwoPlacements", "placed_together"]

# Where there and back end up farther apart than this, the two directions do not mean the same
# place: two spacings of labels.
CLOSES = 0.06
# Once both directions were drawn together, a vertex is shared if they close within the spacing of
# vertices on 10,000: a wrong place is no nearer, and the border is as sharp as the mesh.
CLOSED = 0.015
PLACE_ROUNDS, TOGETHER_ROUNDS = 12, 4


@dataclass(frozen=True, eq=False)
class TwoPlacements:
    """The placement of each shape's working mesh on the other, first that of the second shape.

    Attributes
    ----------
    deformations
        Of the second shape on the first, and of the first on the second.
    trips
        There and back from each.
    shared
        (n,) bool, vertices of each that are shared.
    similarity
        (q,) similarity at the answers of the queries, inside what is shared.
    """

    deformations: tuple[Deformation, Deformation]
    trips: tuple[RoundTrip, RoundTrip]
    shared: tuple[Bools, Bools]
    similarity: tuple[Floats, Floats]


def placed_together(
    questions: tuple[Question, Question],
    labelings: TwoLabelings,
    queries: tuple[Queries, Queries],
) -> TwoPlacements:
    """Carry both labelings through to points and draw them together.

    Each direction starts from the nodes that the other brings back. Then, twice: lay both shapes
    on each other by similar neighborhoods, and draw each to the middle between its own place and
    the inverse of the other's, where these are near. The second time both see only what is shared.
    """
    found = (
        (labelings.forward, labelings.forward_agrees),
        (labelings.backward, labelings.backward_agrees),
    )
    present = tuple(
        agrees[question.part.sparse.cells].astype(np.float64)
        for question, (_, agrees) in zip(questions, found, strict=True)
    )
    laid = tuple(
        _from_labeling(question, labeling, agrees, here)
        for question, (labeling, agrees), here in zip(questions, found, present, strict=True)
    )
    looks = tuple(_look_by_cut(question, each) for question, each in zip(questions, queries, strict=True))
    laid = tuple(
        registered_to_surface(question, own, look, reaches=FIRST_REACHES, present=here)
        for question, own, look, here in zip(questions, laid, looks, present, strict=True)
    )
    laid, trips, shared = _drawn_together(questions, laid)
    looks = tuple(
        _look_inside(question, each, shared[k], shared[1 - k])
        for k, (question, each) in enumerate(zip(questions, queries, strict=True))
    )
    laid = tuple(
        registered_to_surface(
            question, own, look, reaches=SECOND_REACHES, present=here.astype(np.float64)
        )
        for question, own, look, here in zip(questions, laid, looks, shared, strict=True)
    )
    laid, trips, shared = _drawn_together(questions, laid)
    similarity = tuple(
        similar_places(question.full, own.positions, look, reach=ANSWER_REACH)[2]
        for question, own, look in zip(questions, laid, looks, strict=True)
    )
    return TwoPlacements(laid, trips, shared, similarity)


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
    return Look(queries.vertices, full.spectra_within(other), spectra, trust)


def _drawn_together(
    questions: tuple[Question, Question], laid: tuple[Deformation, Deformation]
) -> tuple[tuple[Deformation, Deformation], tuple[RoundTrip, RoundTrip], tuple[Bools, Bools]]:
    """Each drawn to the middle between its own places and the inverse of the other's."""
    trips = _trips(questions, laid)
    drawn = []
    for question, own, trip in zip(questions, laid, trips, strict=True):
        apart = np.linalg.norm(trip.there - trip.inverse, axis=1)
        closes = (np.maximum(apart, trip.gap) < CLOSES) & ~trip.beyond & (trip.missed < CLOSES / 2)
        middle = 0.5 * (trip.there + trip.inverse)
        drawn.append(
            registered_to_positions(
                question, own, middle, rounds=TOGETHER_ROUNDS, present=closes.astype(np.float64)
            )
        )
    together = (drawn[0], drawn[1])
    trips = _trips(questions, together)
    shared = tuple(
        shared_region(question.part.mesh, sharing_cost(trip))
        for question, trip in zip(questions, trips, strict=True)
    )
    return together, trips, (shared[0], shared[1])


def sharing_cost(trip: RoundTrip) -> Floats:
    """Cost (n,) of sharing a vertex, 1 is its price: how far there and back are apart."""
    cost = np.minimum(trip.gap / CLOSED, 2.0)
    return np.where(trip.beyond, 2.0, cost)


def _trips(
    questions: tuple[Question, Question], laid: tuple[Deformation, Deformation]
) -> tuple[RoundTrip, RoundTrip]:
    return (
        round_trip(questions[0], laid[0], laid[1]),
        round_trip(questions[1], laid[1], laid[0]),
    )
