"""Both shapes laid on each other as elastic surfaces, each where the other is, as one answer."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

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
from sherd.correspondence.shared.open_border import open_seam, other_goes_on
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
from sherd.threads import side_by_side

__all__ = [
    "SharedPlacement",
    "drawn_together",
    "first_look",
    "looked_closer",
    "placed_together",
    "share_something",
    "sharing_cost",
]

# Where there and back end up farther apart than this, the two directions do not mean the same
# place: two spacings of labels.
CLOSES = 0.06
# Once both directions were drawn together, a vertex is shared if they close within the spacing of
# vertices on 10,000: a wrong place is no nearer, and the border is as sharp as the mesh.
CLOSED = 0.015
PLACE_ROUNDS, TOGETHER_ROUNDS = 12, 4
# Open border beyond which both look once more, over the root of the shared area: a border as long
# as that of a square is open along a twelfth. Of 26 SMAL pairs that are as open vertex IoU rises
# from 0.479 to 0.491, of those two that lie right and lack a tenth of what is shared from 0.87 to
# 0.95; where the border is closed it falls by as much as it rises.
CLOSED_BORDER = 0.3
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
    the inverse of the other's, where these are near. The second time both see only what is shared,
    and once more where much of the border of that is open, as it then still grows.

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
    return looked_closer(
        questions, queries, first_look(questions, labelings, queries, strain=strain), strain=strain
    )


def first_look(
    questions: Both[Question],
    labelings: TwoLabelings,
    queries: Both[Queries],
    *,
    strain: float,
) -> Both[SharedPlacement]:
    """The first half of :func:`placed_together`: laid and drawn together once.

    Enough to see which of several places is right, at two fifths of the work. Similarities are not
    known yet.
    """
    found = (
        (labelings.forward, labelings.forward_agrees),
        (labelings.backward, labelings.backward_agrees),
    )
    laid = side_by_side(
        partial(_first_laid, *each) for each in zip(questions, found, queries, strict=True)
    )
    return drawn_together(questions, (laid[0], laid[1]), strain)


def looked_closer(
    questions: Both[Question],
    queries: Both[Queries],
    found: Both[SharedPlacement],
    *,
    strain: float,
) -> Both[SharedPlacement]:
    """The second half of :func:`placed_together`, from a :func:`first_look`."""
    drawn, seen = _looked_again(questions, queries, found, strain)
    if _is_open(questions, drawn):
        drawn, seen = _looked_again(questions, queries, drawn, strain)
    judged = side_by_side(
        partial(_judged, question, own, look)
        for question, own, look in zip(questions, drawn, seen, strict=True)
    )
    return (judged[0], judged[1])


def _looked_again(
    questions: Both[Question], queries: Both[Queries], found: Both[SharedPlacement], strain: float
) -> tuple[Both[SharedPlacement], Both[Look]]:
    """Laid by what both see of what is shared, and drawn together; and what they saw."""
    seen = side_by_side(
        partial(_laid_again, *each)
        for each in zip(questions, queries, found, found[::-1], strict=True)
    )
    (there, look_there), (back, look_back) = seen
    return drawn_together(questions, (there, back), strain), (look_there, look_back)


def _is_open(questions: Both[Question], found: Both[SharedPlacement]) -> bool:
    """Whether more of the border than `CLOSED_BORDER` is open, on either shape."""
    return any(
        open_seam(question, place.trip, place.shared) > CLOSED_BORDER
        for question, place in zip(questions, found, strict=True)
    )


def _first_laid(question: Question, found: tuple[Labeling, Bools], queries: Queries) -> Deformation:
    """Laid by the nodes that agree, and by neighborhoods that each shape's cut makes incomplete."""
    labeling, agrees = found
    present = agrees[question.part.sparse.cells].astype(np.float64)
    start = _from_labeling(question, labeling, agrees, present)
    look = _look_by_cut(question, queries)
    return registered_to_surface(question, start, look, reaches=FIRST_REACHES, present=present)


def _laid_again(
    question: Question, queries: Queries, own: SharedPlacement, other: SharedPlacement
) -> tuple[Deformation, Look]:
    """Laid by what both shapes see of what is shared; and what they saw."""
    look = _look_inside(question, queries, own.shared, other.shared)
    present = own.shared.astype(np.float64)
    start = own.deformation
    laid = registered_to_surface(question, start, look, reaches=SECOND_REACHES, present=present)
    return laid, look


def _judged(question: Question, own: SharedPlacement, look: Look) -> SharedPlacement:
    positions = own.deformation.positions
    alike = similar_places(question.full, positions, look, reach=ANSWER_REACH)[2]
    return replace(own, similarity=alike)


def share_something(placements: Both[SharedPlacement]) -> bool:
    """Whether each of both shapes has vertices that the other one has, too."""
    return all(bool(place.shared.any()) for place in placements)


def sharing_cost(trip: RoundTrip, strain: Floats, accepted: float) -> Floats:
    """Cost (n,) of sharing each vertex; 1 is its price, and none costs more than 2.

    `max(gap / CLOSED, strain / accepted)`, and 2 over the border of the other shape: what comes
    back elsewhere is as little shared as what only fits when it is torn.
    """
    cost = np.maximum(trip.gap / CLOSED, strain / accepted)
    return np.where(trip.beyond, MOST_COST, np.minimum(cost, MOST_COST))


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


def drawn_together(
    questions: Both[Question], laid: Both[Deformation], strain: float
) -> Both[SharedPlacement]:
    """Each drawn to the middle between its own places and the inverse of the other's."""
    drawn = side_by_side(
        partial(_drawn_to_middle, *each)
        for each in zip(questions, laid, _trips(questions, laid), strict=True)
    )
    together = (drawn[0][0], drawn[1][0])
    strained = side_by_side(
        partial(_strain_around, question, own)
        for question, own in zip(questions, together, strict=True)
    )
    placements = side_by_side(
        partial(_cut_out, *each, accepted=strain)
        for each in zip(
            questions, drawn, _trips(questions, together), strained, strained[::-1], strict=True
        )
    )
    return (placements[0], placements[1])


def _drawn_to_middle(
    question: Question, own: Deformation, trip: RoundTrip
) -> tuple[Deformation, Floats]:
    """Drawn to the middle where both directions mean the same place; and how far apart (n,)."""
    apart = np.maximum(np.linalg.norm(trip.there - trip.inverse, axis=1), trip.gap)
    closes = (apart < CLOSES) & ~trip.beyond & (trip.missed < CLOSES / 2)
    middle = 0.5 * (trip.there + trip.inverse)
    present = closes.astype(np.float64)
    drawn = registered_to_positions(question, own, middle, rounds=TOGETHER_ROUNDS, present=present)
    return drawn, apart


def _cut_out(
    question: Question,
    drawn: tuple[Deformation, Floats],
    trip: RoundTrip,
    own_strain: Floats,
    other_strain: Floats,
    *,
    accepted: float,
) -> SharedPlacement:
    """What closes at little strain is shared; its similarities are not known yet."""
    deformation, apart = drawn
    # the other surface is strained where this one is as well; either may tell
    strain = np.maximum(own_strain, trip.points.interpolate(question.full.mesh, other_strain))
    cost = sharing_cost(trip, strain, accepted)
    shared = shared_region(question.part.mesh, cost, other_goes_on(question, trip))
    return SharedPlacement(deformation, trip, shared, strain, apart, np.empty(0))


def _strain_around(question: Question, own: Deformation) -> Floats:
    return _around(question, elastic_strain(question.part, own))


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
    there, back = side_by_side(
        partial(round_trip, *each) for each in zip(questions, laid, laid[::-1], strict=True)
    )
    return there, back
