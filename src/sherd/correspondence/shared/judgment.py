"""How far an overlap can be trusted: vertex by vertex and as a whole."""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.spatial import cKDTree

from sherd.arrays import Floats, Ints
from sherd.correspondence.confidence import LEAST, MOST, confidences
from sherd.correspondence.labels.two_way import Both, TwoLabelings
from sherd.correspondence.question import Question
from sherd.correspondence.shared.open_border import open_seam, other_goes_on
from sherd.correspondence.shared.region_cut import shared_regions
from sherd.correspondence.shared.two_way_placement import (
    SharedPlacement,
    sharing_cost,
)
from sherd.correspondence.unfollowed import FOLLOWED
from sherd.correspondence.working_placement import Queries
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.advice import UnfollowedLandmark
from sherd.results.overlap_result import StrainCurve
from sherd.threads import side_by_side

__all__ = [
    "APART",
    "LARGEST_APART",
    "MIRROR_CHANCE",
    "logarithm_apart",
    "mirror_is_better",
    "overlap_chance",
    "shared_confidence",
    "strain_curve",
    "unfollowed_pairs",
]

# From a twentieth of the length, which any pose strains everywhere, to tears.
STRAINS = tuple(float(round(strain, 3)) for strain in np.geomspace(0.05, 1.0, 14))
NEIGHBORS = 8
# Beyond this two placements disagree, and not more.
MOST_APART = 0.3

# Distances between both directions, in sqrt(area), are told apart from the spacing of vertices on
# 50,000 up to the width of a neighborhood; their logarithm counts, from the spacing on 10,000.
APART, LEAST_APART, LARGEST_APART = 0.01, 0.002, 0.05
# A logistic regression over 61 pairs, wrong ones counting twice: 35 of cuts of a generated animal
# and of three animated ones with cuts of themselves in another pose and of others, the wrong ones
# those that were hardest to tell, every second pair of SMAL and every second single view. Right is
# an error below 0.05, over what is shared and over what is matched, wrong one above 0.1 and 0.05.
# Of the 29 wrong ones none is above 0.64, of the 32 right ones 9 are below 0.65. Of the others
# of SMAL and the views, which are in no fit, none of 10 wrong ones is above 0.51, and 5 of 20
# right ones are below 0.65. Being more alike than the mirror image, which no animal is of another,
# let a view of a wolf pass that lacked a third of what is shared.
CHANCE_COEFFICIENTS = (-6.4, 5.9, 12.3, -1.2, 19.6, -0.5)

# Two equal limbs agree perfectly, so beyond this no agreement counts. Of 66 such pairs, and two of
# legs of the generated animal, the mirror image was better by more in ten that were wrong, and in
# four right ones. The generated animal's left front leg on its right one is not told from
# these by anything else: labeled in full, the mirror image saves more in all of them, since a body
# has two equal sides.
MIRROR_MARGIN = 0.06
# Four in fourteen of such answers were right; one in six of those asked before.
MIRROR_CHANCE = 0.15


def shared_confidence(part: TriangleMesh, queries: Queries, place: SharedPlacement) -> Floats:
    """Chance (n,) that each vertex of the working mesh is shared and its point near the truth.

    That of :mod:`sherd.correspondence.confidence` inside what is shared; what is not shared has
    the least.
    """
    asked = place.shared[queries.vertices]
    result = np.full(part.vertex_count, LEAST)
    if not asked.any():
        return result
    here = part.vertices[queries.vertices[asked]]
    tree = cKDTree(here)
    near = tree.query(part.vertices, k=min(NEIGHBORS, len(here)))[1].reshape(len(part.vertices), -1)
    lack = (1.0 - np.clip(place.similarity[asked], 0.0, 1.0))[near].mean(axis=1)
    strain = np.minimum(place.strain, 1.0)
    apart = np.minimum(place.apart, MOST_APART)
    ones = np.ones(part.vertex_count)
    inside = place.shared
    whole = (float(lack[inside].mean()), float(strain[inside].mean()))
    columns = (ones, lack, strain, apart, whole[0] * ones, whole[1] * ones)
    result[inside] = confidences(np.stack(columns, axis=1))[inside]
    return result


def overlap_chance(
    labelings: TwoLabelings,
    mirrored_ratio: float,
    questions: Both[Question],
    placements: Both[SharedPlacement],
) -> float:
    """The chance that an overlap is right: `1 / (1 + exp(-features @ coefficients))`.

    Kept inside [0.005, 0.995]. The features: what both directions agree on, and what that is worth
    (see :class:`sherd.correspondence.labels.two_way.TwoLabelings`); the logarithm of how far apart
    the directions were, on average over what is shared, before they were drawn together; by how
    much the mirror image is more alike, if it is; and how much of the border of what is shared is
    open, on the shape where it is more.
    """
    is_open = max(
        open_seam(question, place.trip, place.shared)
        for question, place in zip(questions, placements, strict=True)
    )
    features = np.array(
        [
            1.0,
            labelings.agreement,
            float(np.clip(labelings.worth, -1.0, 1.0)),
            logarithm_apart(questions, placements),
            min(mirrored_ratio - labelings.first_ratio, 0.0),
            is_open,
        ]
    )
    raw = 1.0 / (1.0 + np.exp(-features @ np.array(CHANCE_COEFFICIENTS)))
    return float(np.clip(raw, LEAST, MOST))


def logarithm_apart(questions: Both[Question], placements: Both[SharedPlacement]) -> float:
    """How far apart both directions were, on average over what is shared; as a feature."""
    apart = 0.5 * (_apart(questions[0], placements[0]) + _apart(questions[1], placements[1]))
    return float(np.log(np.clip(apart, LEAST_APART, LARGEST_APART) / APART))


def mirror_is_better(first_ratio: float, mirrored_ratio: float) -> bool:
    """Whether the mirror image of one shape is more alike the other than the shape itself is.

    Then limbs of both sides are laid on each other: a left leg and a right one.
    """
    return mirrored_ratio < first_ratio - MIRROR_MARGIN


def _apart(question: Question, place: SharedPlacement) -> float:
    """Mean distance of both directions over what is shared, or over all if nothing is."""
    areas = question.part.mesh.vertex_areas
    weights = areas * place.shared if place.shared.any() else areas
    return float(np.average(np.minimum(place.apart, MOST_APART), weights=weights))


def strain_curve(questions: Both[Question], placements: Both[SharedPlacement]) -> StrainCurve:
    """Share of each shape's area that would be shared if more strain were accepted, or less."""
    second, first = side_by_side(
        partial(_shares, question, place)
        for question, place in zip(questions, placements, strict=True)
    )
    return StrainCurve(STRAINS, first=first, second=second)


def _shares(question: Question, place: SharedPlacement) -> tuple[float, ...]:
    """Share of the part's area for each of `STRAINS`."""
    mesh, goes_on = question.part.mesh, other_goes_on(question, place.trip)
    costs = [sharing_cost(place.trip, place.strain, strain) for strain in STRAINS]
    regions = shared_regions(mesh, costs, goes_on)
    return tuple(float(mesh.vertex_areas @ region / mesh.area) for region in regions)


def unfollowed_pairs(
    landmarks: Ints, first: TriangleMesh, points: SurfacePoints, unit: float
) -> tuple[UnfollowedLandmark, ...]:
    """The landmarks that an answer does not follow, farthest first.

    Parameters
    ----------
    landmarks
        (p, 2) vertices of the first and second shape.
    first, points
        The first shape, and the point on it of each vertex of the second.
    unit
        What counts as 1.
    """
    if len(landmarks) == 0:
        return ()
    answers = points[landmarks[:, 1]].positions(first)
    off = np.linalg.norm(answers - first.vertices[landmarks[:, 0]], axis=1) / unit
    return tuple(
        UnfollowedLandmark(int(landmarks[k, 1]), int(landmarks[k, 0]), float(off[k]))
        for k in np.argsort(-off, kind="stable")
        if off[k] > FOLLOWED
    )
