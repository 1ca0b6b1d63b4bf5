"""Correlation of what two surfaces keep in every pose, where one is laid on the other.

Labels lie well on any limb that is as thick and as long. But wherever a map lays it, the relief of
the one must be that of the other, place by place; see :mod:`sherd.descriptors.relief`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.stats import rankdata

from sherd.arrays import Bools, Floats, Ints
from sherd.correspondence.labels.consistent import node_areas
from sherd.correspondence.labels.labeling import Labeling, Problem
from sherd.correspondence.labels.two_way import Both
from sherd.correspondence.question import Question
from sherd.correspondence.registration import Deformation, working_points
from sherd.correspondence.shared.two_way_placement import SharedPlacement
from sherd.descriptors.relief import FINE, JUDGED, form, relief
from sherd.mesh.surface_points import SurfacePoints

__all__ = [
    "alike_at_labels",
    "alike_in",
    "alike_in_form",
    "alike_in_relief",
    "alike_where_laid",
    "concordance_in",
    "judged_reliefs",
    "seen_area",
    "seen_where_laid",
]

# Nearer to a cut than so many widths the angles of faces that are gone are missing in the average.
CUT_WIDTHS = 2
CUT = CUT_WIDTHS * FINE
# Two nodes are always in order or in reverse order.
LEAST_NODES = 3


def alike_in_relief(questions: Both[Question], placements: Both[SharedPlacement]) -> float:
    """How alike the reliefs of two pieces are where one lies on the other, in [-1, 1].

    See :func:`alike_in`.
    """
    reliefs = (relief(questions[0].part.mesh), relief(questions[1].part.mesh))
    return alike_in(reliefs, questions, placements)


def alike_in_form(questions: Both[Question], placements: Both[SharedPlacement]) -> float:
    """How alike the forms of two pieces are where one lies on the other, in [-1, 1].

    See :func:`alike_in`.
    """
    forms = (form(questions[0].part.mesh), form(questions[1].part.mesh))
    return alike_in(forms, questions, placements)


def alike_in(
    fields: Both[Floats], questions: Both[Question], placements: Both[SharedPlacement]
) -> float:
    """How alike what is known of two shapes is where one lies on the other, in [-1, 1].

    Spearman's rank correlation over what is shared, by area, mean of both directions; 0 where
    nothing is shared. Ranks, since a nose or a hoof has more relief than all the rest.

    Parameters
    ----------
    fields
        (n,) and (m,), of the part's vertices of the one question and of the other.
    questions, placements
        Of both directions.
    """
    both = zip(questions, placements, fields, fields[::-1], strict=True)
    return float(np.mean([_alike(*each) for each in both]))


def alike_where_laid(question: Question, deformation: Deformation) -> float | None:
    """How alike the relief of a part is to that of the full shape where all of it is laid.

    Spearman's rank correlation by area, in [-1, 1], as :func:`alike_in`, but of one direction. None
    if hardly a vertex is away from the cuts of both.
    """
    full, part = question.full, question.part
    points = working_points(question, deformation)
    everywhere = np.ones(part.mesh.vertex_count, dtype=bool)
    seen = _seen(question, points, everywhere, relief(part.mesh), relief(full.mesh))
    if len(seen.vertices) < LEAST_NODES:
        return None
    return _rank_correlation(seen)


def judged_reliefs(questions: Both[Question]) -> list[Both[Floats]]:
    """The reliefs of both parts, (n,) and (m,), at each of the widths that judge, `JUDGED`."""
    here, there = (question.part.mesh for question in questions)
    return [(relief(here, width), relief(there, width)) for width in JUDGED]


def concordance_in(
    fields: Both[Floats], questions: Both[Question], placements: Both[SharedPlacement]
) -> float:
    """How far what is known of two shapes is the same where one lies on the other, in [-1, 1].

    As :func:`alike_in`, but by Lin's concordance correlation (1989) of the ranks among the values
    of both: 1 only where both have the same values, not where one has as much more everywhere.
    """
    both = zip(questions, placements, fields, fields[::-1], strict=True)
    return float(np.mean([_concordance(*each) for each in both]))


def seen_area(question: Question, shared: Bools, points: SurfacePoints, width: float) -> Floats:
    """The area (n,) of the part that is shared, less along both cuts, of what is `width` wide.

    `points` of the full shape are where the part's vertices lie.
    """
    full, part = question.full, question.part
    depth = np.minimum(part.cut_distance, points.interpolate(full.mesh, full.cut_distance))
    seen: Floats = part.mesh.vertex_areas * shared * np.clip(depth / (CUT_WIDTHS * width), 0.0, 1.0)
    return seen


def alike_at_labels(
    fields: Both[Floats], problems: Both[Problem], found: Both[Labeling], kept: Both[Bools]
) -> float:
    """How alike what is known of two shapes is where nodes have labels, times the root of the area.

    As :func:`alike_in`, of the nodes that are kept and not of all vertices, before anything is
    laid. A rank correlation of n independent places scatters by 1 / sqrt(n) where nothing is alike,
    so what it proves grows with the root of the area.

    Parameters
    ----------
    fields
        (n,) and (m,), of the vertices of the second shape and of the first.
    problems
        The nodes of the second shape with labels of the first, and the other way around.
    found, kept
        Labelings of both, and (k,) the nodes of each that count.
    """
    alike, area = 0.0, 0.0
    for side, problem in enumerate(problems):
        labels = found[side].labels
        areas = node_areas(problem) * kept[side]
        depth = np.minimum(problem.node_depth, problem.label_depth[labels])
        trust = areas * np.clip(depth / CUT, 0.0, 1.0)
        rows = np.flatnonzero(trust > 0)
        area += 0.5 * float(areas.sum())
        if len(rows) >= LEAST_NODES:
            here = fields[side][problem.nodes.vertices[rows]]
            there = fields[1 - side][problem.labels.vertices[labels[rows]]]
            alike += 0.5 * _correlation(rankdata(here), rankdata(there), trust[rows])
    return alike * math.sqrt(area)


@dataclass(frozen=True)
class Seen:
    """What is known of two shapes at places that both share.

    Attributes
    ----------
    vertices
        (k,) of the part.
    here, there
        (k,) what is known of the part, and of the full shape where it lies.
    trust
        (k,) area that counts.
    """

    vertices: Ints
    here: Floats
    there: Floats
    trust: Floats

    def among(self, vertices: Ints) -> Seen:
        """The same at those of its places that are among `vertices`."""
        kept = np.isin(self.vertices, vertices)
        return Seen(self.vertices[kept], self.here[kept], self.there[kept], self.trust[kept])


def seen_where_laid(question: Question, place: SharedPlacement, own: Floats, other: Floats) -> Seen:
    """What is known of the part (n,) and of the full shape (m,), at each vertex that is shared."""
    return _seen(question, place.trip.points, place.shared, own, other)


def _seen(
    question: Question, points: SurfacePoints, shared: Bools, own: Floats, other: Floats
) -> Seen:
    """The same of what is `shared` (n,) of the part, whose vertices lie at points (n,)."""
    trust = seen_area(question, shared, points, FINE)
    rows = np.flatnonzero(trust > 0)
    there = points[rows].interpolate(question.full.mesh, other)
    return Seen(rows, own[rows], there, trust[rows])


def _alike(question: Question, place: SharedPlacement, own: Floats, other: Floats) -> float:
    seen = seen_where_laid(question, place, own, other)
    if len(seen.vertices) < 2:
        return 0.0
    return _rank_correlation(seen)


def _concordance(question: Question, place: SharedPlacement, own: Floats, other: Floats) -> float:
    seen = seen_where_laid(question, place, own, other)
    if len(seen.vertices) < 2:
        return 0.0
    here, there = np.split(rankdata(np.concatenate([seen.here, seen.there])), 2)
    means = [np.average(each, weights=seen.trust) for each in (here, there)]
    apart = np.average((here - there) ** 2, weights=seen.trust)
    # had both nothing in common but their spreads and means
    expected = np.average((here - means[0]) ** 2 + (there - means[1]) ** 2, weights=seen.trust)
    expected += (means[0] - means[1]) ** 2
    return float(1.0 - apart / expected) if expected > 0 else 0.0


def _rank_correlation(seen: Seen) -> float:
    """Spearman's, by the area that counts."""
    return _correlation(rankdata(seen.here), rankdata(seen.there), seen.trust)


def _correlation(first: Floats, second: Floats, weights: Floats) -> float:
    """Pearson's correlation with weights (n,); 0 if one of both is constant."""
    first = first - np.average(first, weights=weights)
    second = second - np.average(second, weights=weights)
    spread = math.sqrt(float(weights @ first**2) * float(weights @ second**2))
    return float(weights @ (first * second)) / spread if spread > 0 else 0.0
