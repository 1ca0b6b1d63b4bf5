"""How far an overlap can be trusted: vertex by vertex and as a whole."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from scipy.spatial import cKDTree
from scipy.special import logit

from sherd.arrays import Bools, Floats, Ints
from sherd.correspondence.confidence import LEAST, MOST, confidences, measured_chance
from sherd.correspondence.labels.two_way import Both, TwoLabelings
from sherd.correspondence.question import Question
from sherd.correspondence.shared.glance import Glance
from sherd.correspondence.shared.likeness import Likeness, likeness_inside, mean_likeness
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
from sherd.results.advice import SURE, UnfollowedLandmark
from sherd.results.overlap_result import StrainCurve
from sherd.threads import side_by_side

__all__ = [
    "CLOSER_RISE",
    "LAID_RISE",
    "MIRROR_CHANCE",
    "form_log_odds",
    "further_chance",
    "likeness_of_both",
    "may_be_sure",
    "mirror_is_better",
    "mirror_says_something",
    "most_chance",
    "most_open",
    "overlap_chance",
    "overlap_log_odds",
    "place_chances",
    "place_log_odds",
    "shared_area",
    "shared_confidence",
    "strain_curve",
    "unfollowed_pairs",
]

# From a twentieth of the length, which any pose strains everywhere, to tears.
STRAINS = tuple(float(round(strain, 3)) for strain in np.geomspace(0.05, 1.0, 14))
NEIGHBORS = 8
# Beyond this two placements disagree, and not more.
MOST_APART = 0.3

# A logistic regression over 46 pairs, wrong ones counting twice: 20 of cuts of a generated animal
# and of animated ones with cuts of themselves in another pose and of others, half of the wrong ones
# legs on other legs, every second pair of SMAL and every second single view. Right is an error
# below 0.05, over what is shared and over what is matched, wrong one above 0.1 and 0.05. Of the 23
# wrong ones none is above 0.39, of the 23 right ones 4 are below 0.65. Of 20 others of SMAL and the
# views, in no fit, none of 8 wrong ones is above 0.19, and 1 of 12 right ones is below 0.65. Fitted
# to the same pairs, what kept nodes save and how far apart both directions were, instead of what is
# seen inside, let wrong ones come to 0.62, and 8 and 3 right ones were below.
CHANCE_COEFFICIENTS = (-15.1, 7.1, -29.4, -1.3, 13.8, 7.8, 30.0)

# What is found may be right and lack half of what is shared: then a good part of what one direction
# places the other does not confirm. Of 20 answers that agree on less than this one was right (SMAL,
# views, cuts of animals); a fox on a lion of which half is left out is otherwise told by nothing.
CONFIRMED, UNCONFIRMED_CHANCE = 2.0 / 3.0, 0.5

# A logistic regression over 94 answers to 27 pairs: every second pair of SMAL, six single views,
# five pairs of cuts of a generated and of animated animals; of each pair what saves most, further
# places, and where the true labels lead. 25 lie right (an error below 0.06), 69 wrong (above 0.1).
FORM_COEFFICIENTS = (-5.7, -3.5, 5.7, 12.4)

# A conditional logit over 105 answers to 23 questions that were not sure: every second pair of SMAL
# and nine single views; of each what saves most and up to five further places. In seven what saves
# most lies right (an error below 0.1), in seven a further place does, in seven none; two are
# between right and wrong. Left out and judged by the others, five of the seven further places are
# believed, and all of the seven first ones. That an answer is a further place counts for nothing.
PLACE_COEFFICIENTS = (0.14, 0.09, 0.65)

# The logarithms of how many times as likely places are on average once they are laid, as their
# labels say, and as a first look says: borders are wider open around nodes than around vertices,
# and close as both shapes see more of each other. Of 135 answers to 25 pairs of SMAL that are not
# sure, and nearly the same on either half of these pairs.
LAID_RISE, CLOSER_RISE = 2.8, 0.4
# By as much laying may raise what speaks for what saves most: of 48 pairs of SMAL by 4.7 at most,
# where the border of what nodes see is as open as can be, and closes.
MOST_RISE = 5.0

# A further place is one of up to six answers to one question, and half may be left out where it is
# right, so it takes both kinds of evidence. Of 160 wrong answers at further places to 53 questions
# (SMAL, single views, parts cut anew from the animals of SMAL, half of which share nothing, and
# animals with people) none has more than 7.4 of the first plus twice the second; of 13 right ones
# four have 11.5 to 15.3, three 7.8 to 8.6, the others less. The line is half way between 7.4 and
# 11.5. The half of SMAL on which nothing was chosen has 6.7 for wrong ones, and 8.6, 13.9 and 15.3.
FURTHER_COEFFICIENTS = (-9.5, 1.0, 2.0)

# Of what cannot be judged: any other place is rather believed.
LEAST_ODDS = -np.inf

# By as much a mirror image may be better by accident: of 34 right answers 6 are above.
MIRROR_ACCIDENT = 0.03
# Beyond this a limb may lie on its twin of the other side. Of 66 pairs, and two of legs of the
# generated animal, the mirror image was better by more in ten that were wrong, and in four right
# ones: the mirror image of a whole animal may lie as well as the animal, elsewhere.
MIRROR_MARGIN = 0.06
# At its own place a limb of the other side is no more alike than its mirror image is: of six wrong
# answers with so good a mirror image 0.55 to 0.61 of the places are more alike, of four right ones
# 0.53 (two species), 0.74, 0.79 and 0.81 (generated animal, animated horse). Of 31 wrong answers of
# all kinds none is above 0.66.
HANDED = 2.0 / 3.0
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


def likeness_of_both(
    questions: Both[Question], placements: Both[SharedPlacement]
) -> Likeness | None:
    """Mean of both directions; None where too little is shared to be judged."""
    there, back = placements
    found = side_by_side(
        partial(likeness_inside, question, own.trip.there, own.shared, other.shared)
        for question, own, other in zip(questions, (there, back), (back, there), strict=True)
    )
    return mean_likeness(*found)


def share_of_both(
    share: Callable[[Question, Floats, Bools], float | None],
    questions: Both[Question],
    placements: Both[SharedPlacement],
) -> float | None:
    """Mean of a share of places over the directions that tell it; None if neither does."""
    found = side_by_side(
        partial(share, question, place.trip.there, place.shared)
        for question, place in zip(questions, placements, strict=True)
    )
    told = [each for each in found if each is not None]
    return float(np.mean(told)) if told else None


def most_open(questions: Both[Question], placements: Both[SharedPlacement]) -> float:
    """How much of the border of what is shared is open, on the shape where it is more."""
    return max(
        open_seam(question, place.trip, place.shared)
        for question, place in zip(questions, placements, strict=True)
    )


def shared_area(questions: Both[Question], placements: Both[SharedPlacement]) -> float:
    """Area that is shared, mean of both shapes."""
    areas = [
        float(question.part.mesh.vertex_areas @ place.shared)
        for question, place in zip(questions, placements, strict=True)
    ]
    return 0.5 * (areas[0] + areas[1])


def overlap_log_odds(
    labelings: TwoLabelings, mirrored_ratio: float, likeness: Likeness | None, is_open: float
) -> float:
    """The logarithm of the odds that an overlap is right: `features @ coefficients`.

    The features: what both directions agree on, and how much less alike than the best labels that
    is (see :class:`sherd.correspondence.labels.two_way.TwoLabelings`); how much of the border of
    what is shared is open, on the shape where it is more; of the nodes inside, the share whose
    places lead, and the share whose places are more alike to them than to their mirror images,
    seeing only what is shared (see :class:`sherd.correspondence.shared.likeness.Likeness`); and by
    how much more alike the mirror image is than by accident, `mirrored_ratio` being the energy of
    its first labeling over that by chance, or `first_ratio` where :func:`mirror_says_something`
    denies it. `LEAST_ODDS` where too little is shared to be judged.
    """
    if likeness is None:
        return LEAST_ODDS
    features = np.array(
        [
            1.0,
            labelings.agreement,
            labelings.lack,
            is_open,
            likeness.leading,
            likeness.handed,
            min(mirrored_ratio - labelings.first_ratio + MIRROR_ACCIDENT, 0.0),
        ]
    )
    return float(features @ np.array(CHANCE_COEFFICIENTS))


def most_chance(labelings: TwoLabelings, mirrored_ratio: float) -> float:
    """What the chance of an overlap may be at the most.

    A half where the directions agree on less than `CONFIRMED`, and `MIRROR_CHANCE` where limbs of
    both sides are laid on each other, whatever else speaks for it.
    """
    if mirror_is_better(labelings.first_ratio, mirrored_ratio):
        return MIRROR_CHANCE
    return MOST if labelings.agreement >= CONFIRMED else UNCONFIRMED_CHANCE


def overlap_chance(log_odds: float, most: float) -> float:
    """The chance that an overlap is right, by its :func:`overlap_log_odds`.

    At least 0.005 and at most :func:`most_chance`.
    """
    return min(measured_chance(log_odds), most)


def further_chance(by_labels: float, by_form: float) -> float:
    """The chance that an answer at a further place is right, not only its place.

    Of a place that is right half may be left out, and of up to six answers to one question one may
    please by accident; so both kinds of evidence must speak for it far more clearly than for what
    saves most.

    Parameters
    ----------
    by_labels, by_form
        :func:`overlap_log_odds` and :func:`form_log_odds` of it.
    """
    log_odds = np.array([1.0, by_labels, by_form]) @ np.array(FURTHER_COEFFICIENTS)
    return measured_chance(float(log_odds))


def form_log_odds(likeness: Likeness | None, is_open: float, form: float) -> float:
    """The logarithm of the odds that an answer lies at the right place, by its form.

    Parameters
    ----------
    likeness, is_open
        As for :func:`overlap_log_odds`: the share of nodes whose places lead, and open border.
    form
        How alike forms are, see :func:`sherd.correspondence.shared.relief.form`, times the root of
        the area that is shared. A rank correlation of n independent places scatters by 1 / sqrt(n)
        where nothing is alike, so what it proves grows with that.
    """
    if likeness is None:
        return LEAST_ODDS
    features = np.array([1.0, is_open, likeness.leading, form])
    return float(features @ np.array(FORM_COEFFICIENTS))


def place_log_odds(by_labels: float, by_form: float) -> float:
    """The logarithm of the odds of a place against none, by both kinds of evidence.

    Parameters
    ----------
    by_labels, by_form
        :func:`overlap_log_odds` and :func:`form_log_odds` of what was laid there.
    """
    return float(np.array([1.0, by_labels, by_form]) @ np.array(PLACE_COEFFICIENTS))


def may_be_sure(labelings: TwoLabelings, seen: Glance) -> bool:
    """Whether what saves most may be sure once it is laid, as far as labels know.

    Not where the directions agree on less than `CONFIRMED`, nor where all the rest is so bad that
    laying has never made up for it.
    """
    ratio = labelings.first_ratio
    log_odds = overlap_log_odds(labelings, ratio, seen.likeness, seen.is_open)
    sure = float(logit(SURE))
    return labelings.agreement >= CONFIRMED and log_odds > sure - MOST_RISE


def place_chances(log_odds: Sequence[float], rivals: Bools, elsewhere: Sequence[float]) -> Floats:
    """The chance (k,) of each of several answers, of whose places one is right or none.

    A conditional logit (McFadden, *Conditional logit analysis of qualitative choice behavior*,
    1974): `exp(u) / (1 + sum of exp(u))` with `u` of :func:`place_log_odds`, the sum over the
    answer itself and its rivals, and 1 for none. So a place that another one nearly equals
    is not likely, however much speaks for it.

    Parameters
    ----------
    log_odds
        (k,) of each.
    rivals
        (k, k) bool, see :func:`sherd.correspondence.shared.rivals.are_rivals`: answers at one place
        do not contradict each other.
    elsewhere
        Of other places, which are rivals of all: what they are expected to have where nothing was
        laid yet.
    """
    odds = np.exp(np.asarray(log_odds, dtype=np.float64))
    others = float(np.exp(np.asarray(elsewhere, dtype=np.float64)).sum())
    chances: Floats = odds / (1.0 + odds + rivals @ odds + others)
    return chances


def mirror_says_something(likeness: Likeness | None) -> bool:
    """Whether limbs of both sides may be laid on each other, by what is seen at the very place."""
    return likeness is not None and likeness.handed <= HANDED


def mirror_is_better(first_ratio: float, mirrored_ratio: float) -> bool:
    """Whether the mirror image of one shape is more alike the other than the shape itself is.

    Then limbs of both sides are laid on each other: a left leg and a right one.
    """
    return mirrored_ratio < first_ratio - MIRROR_MARGIN


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
