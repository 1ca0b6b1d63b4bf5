"""The chance that two pieces without a whole belong together, and are laid on each other rightly.

What belongs together was cut from one whole. So what two pieces share ends where one of them does,
it bends but does not stretch, it is not its mirror image, and it has the same relief; and who sees
nothing else finds no better place for it. Where it lies beside its place it does not look so, so it
is looked at once more where it slid to.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.special import expit

from sherd.arrays import Floats, Ints
from sherd.correspondence.confidence import LEAST, MOST, above
from sherd.correspondence.labels.anchors import first_labeling, proposed_anchors
from sherd.correspondence.labels.two_way import Both, TwoLabelings
from sherd.correspondence.placements import anchor_problem
from sherd.correspondence.question import Question
from sherd.correspondence.shared.judgment import MIRROR_CHANCE
from sherd.correspondence.shared.likeness import Likeness
from sherd.correspondence.shared.relief_correlation import alike_in_relief
from sherd.correspondence.shared.two_way_placement import SharedPlacement, share_something
from sherd.mesh.border_loops import border_loops
from sherd.results.advice import SURE
from sherd.surface.transformed import mirrored, sampled_within

__all__ = [
    "HANDEDNESS",
    "WORTH_A_SLIDE",
    "ends_with_one",
    "enough_lead",
    "fills_a_gap",
    "fits_a_twin",
    "join_chance",
    "join_features",
    "lies_within",
    "may_be_right",
    "may_lie_right",
    "mean_strain",
]

# A rim that is farther from the borders of both pieces than a spacing of labels ends inside both.
# And who goes on beyond the other crosses as much of its border: some 130 right answers to 18
# puzzles share 0.10 of it and more, a lion's leg on another leg, of which half is shared, nothing.
INSIDE = 0.03
# A piece that lies within another but for slivers along its cut has no rim there that could tell:
# it ends everywhere, rightly or wrongly. Wrong answers have a fifth of their rim inside both, on
# average (81 questions of seven puzzles).
WITHIN, UNTOLD = 0.95, 0.2
# What fills a gap shares so much of the borders that it reaches over, but for those of other gaps
# nearby, which it only touches. Right answers of ten puzzles that fill one share 1.0 of its border
# and 0.06 to 0.14 of others; those beside whom another piece is missing share 0.2 to 0.9.
FILLED, TOUCHED = 0.9, 0.15
# Between the shares of the rim that lie inside both, where an answer finally lies. Of 26 right ones
# to five puzzles 0.0 in all but two, which have 0.03 and 0.07; pieces of a horse that lie right and
# share two thirds of what they could have 0.20 to 0.23. A cat's left foreleg on its right one,
# alike by all that is seen of its skin, has 0.34 and 0.38, as both go on beyond it. Five steps to
# either, and more.
ENDING, ENDING_STEP = 0.28, 0.01
# Fewer nodes than this have hardly a neighborhood, so a mirror image of them says nothing.
LEAST_NODES = 8
MIRROR_ROUNDS = 2
# Parts of a body that are nearly their own mirror image fit the other way by up to 0.17 better (21
# right answers on animated animals).
TURNED = 0.22
# What strain counts as where nothing is shared: more than any right answer has.
UNSHARED_STRAIN = 0.3
# Which of the features these are.
HANDEDNESS, LEADING, RELIEF = 4, 6, 7
# Between the reliefs of wrong places and of right ones, and how wide the doubt is. On the generated
# animal right ones are alike by 0.5 to 0.97, a leg on another one, where all else seems right, by
# 0.0; on two animated animals ten right ones by 0.3 to 0.6, six of seven foreign ones by 0.2 at
# most. Of what else was looked at arms and legs of two people on those of the other side, turned to
# fit, had 0.06 to 0.24, 14 right ones 0.33 to 0.9, two that are right but 0.04 off 0.28, and one of
# a horse, which is refused so, 0.2. More of it proves nothing: another person's is as much alike.
UNLIKE, UNLIKE_STEP = 0.25, 0.02
# A logistic regression over 95 questions of six puzzles of animals and a man whose pieces reach
# half as far again, of pieces and of unions, wrong ones counting twice, with weights kept small: of
# 31 right ones 9 are below 0.65, of 64 wrong or foreign ones none is above 0.46; with each puzzle
# left out in turn 10 and 0.59. Right is an error below 0.06; what is between that and 0.1 counts as
# neither.
COEFFICIENTS = (0.6, 1.6, 0.8, -6.6, 5.5, -17.7)
# Between the shares of places that lead where nodes see only what is shared: two thirds of another
# person have 0.71 to 0.74 on two women, with a chance of 0.56 to 0.75 by all else (0.78 where that
# is 0.30), and 52 of 53 right answers of people, a wolf, a cat and a horse 0.80 and more (one that
# is 0.06 off has 0.70). Three steps to either. More of it proves nothing: of a twentieth of another
# person that lies wholly within the place it was laid on all places lead.
LED, LED_STEP = 0.77, 0.01
# What may be right slides: what is so likely before, and where at least so many places lead
# already. Of the right answers of five puzzles that a slide makes sure the least likely
# one had 0.23, and in the one where fewest places led 0.73 did; a slide raises that by up to 0.14.
WORTH_A_SLIDE, LED_BEFORE = 0.2, 0.65


def join_chance(features: Floats) -> float:
    """`1 / (1 + exp(-features @ coefficients))`, kept inside [0.005, 0.995], if reliefs are alike.

    Where they are not, or too few places lead, it falls to 0. At most MIRROR_CHANCE where the
    mirror image clearly fits better.
    """
    most = MIRROR_CHANCE if _fits_mirrored(features) else MOST
    alike = above(features[RELIEF], UNLIKE, UNLIKE_STEP) * above(features[LEADING], LED, LED_STEP)
    return float(np.clip(_but_for_likeness(features) * alike, LEAST, most))


def may_be_right(features: Floats) -> bool:
    """Whether an answer may be right, and if not where it lies, then beside that.

    Its mirror image may fit better there; where it slid to it must not.
    """
    return bool(_but_for_likeness(features) >= WORTH_A_SLIDE and enough_lead(features))


def may_lie_right(features: Floats) -> bool:
    """Whether the skin may be asked where an answer lies: enough places lead, reliefs may agree."""
    return bool(enough_lead(features) and features[RELIEF] >= UNLIKE - 3 * UNLIKE_STEP)


def enough_lead(features: Floats) -> bool:
    """Whether so many places lead that an answer may be right, or lie beside its place."""
    return bool(features[LEADING] >= LED_BEFORE)


def ends_with_one(questions: Both[Question], placements: Both[SharedPlacement]) -> float:
    """How surely what is shared ends where one of both pieces does."""
    return above(-_inside_share(questions, placements), -ENDING, ENDING_STEP)


def lies_within(questions: Both[Question], placements: Both[SharedPlacement]) -> bool:
    """Whether one of two pieces lies within the other, but for slivers along its cut."""
    return max(_shares(questions, placements)) > WITHIN


def _shares(questions: Both[Question], placements: Both[SharedPlacement]) -> list[float]:
    """The share of its area that each of two pieces has in common with the other."""
    both = zip(questions, placements, strict=True)
    return [_mean_share(*each) for each in both]


def fills_a_gap(questions: Both[Question], placements: Both[SharedPlacement]) -> bool:
    """Whether each of two pieces goes on all around where the other one ends.

    As a limb does on a body that lacks it: what is shared has whole borders of both.
    """
    both = zip(questions, placements, strict=True)
    return not lies_within(questions, placements) and all(_has_borders(*each) for each in both)


def _has_borders(question: Question, place: SharedPlacement) -> bool:
    """Whether what is shared has all of the borders of a piece that it reaches over, and any."""
    mesh = question.part.mesh
    length, reached = 0.0, 0.0
    for loop in border_loops(mesh.faces):
        points = mesh.vertices[loop]
        sides = np.linalg.norm(points - np.roll(points, -1, axis=0), axis=1)
        shared = float(sides @ place.shared[loop])
        if shared > TOUCHED * sides.sum():
            length += float(sides.sum())
            reached += shared
    return reached > FILLED * length


def fits_a_twin(features: Floats) -> bool:
    """Whether what is shared is laid on its twin: all but its side is right.

    The mirror image clearly fits better, or it would be sure if reliefs were alike, however few
    places lead.
    """
    unlike = _but_for_likeness(features) >= SURE and features[RELIEF] < UNLIKE
    return _fits_mirrored(features) or bool(unlike)


def _but_for_likeness(features: Floats) -> float:
    return float(expit(features[:LEADING] @ np.array(COEFFICIENTS)))


def _fits_mirrored(features: Floats) -> bool:
    return bool(features[HANDEDNESS] < -TURNED)


def join_features(
    labelings: TwoLabelings,
    questions: Both[Question],
    placements: Both[SharedPlacement],
    likeness: Likeness | None,
    seed: int,
) -> Floats:
    """Features (8,) of what two pieces share, of which `likeness` is that of both.

    One; what both directions agree on, and what that is worth, of the labelings; the share of the
    rim of what is shared that lies inside both pieces, at least UNTOLD if one is within the other,
    unless this is within it as well, so that all borders are where the other piece has one;
    the logarithm of the energy of mirror images over that of what is shared itself; strain; of the
    nodes inside, seeing only what is shared, the share whose places lead, 0 where it is too little
    to be seen; how alike reliefs are.
    """
    if not share_something(placements):
        worth = float(np.clip(labelings.worth, -1.0, 1.0))
        return np.array([1.0, labelings.agreement, worth, 0.0, 0.0, UNSHARED_STRAIN, 0.0, 0.0])
    both = tuple(zip(questions, placements, strict=True))
    rim = _inside_share(questions, placements)
    if max(shares := _shares(questions, placements)) > WITHIN >= min(shares):
        rim = max(rim, UNTOLD)
    return np.array(
        [
            1.0,
            labelings.agreement,
            float(np.clip(labelings.worth, -1.0, 1.0)),
            rim,
            _handedness(labelings, questions, placements, seed),
            float(np.mean([mean_strain(*each) for each in both])),
            0.0 if likeness is None else likeness.leading,
            alike_in_relief(questions, placements),
        ]
    )


def mean_strain(question: Question, place: SharedPlacement) -> float:
    """Mean strain of what is shared, by area; tears count as 1."""
    weights = question.part.mesh.vertex_areas * place.shared
    return float(np.average(np.minimum(place.strain, 1.0), weights=weights))


def _mean_share(question: Question, place: SharedPlacement) -> float:
    """The share of a piece's area that the other one has, too."""
    return float(np.average(place.shared, weights=question.part.mesh.vertex_areas))


def _inside_share(questions: Both[Question], placements: Both[SharedPlacement]) -> float:
    """The share of the rim of what is shared that lies inside both pieces; 0 without a rim.

    All of it where one goes on beyond the other and crosses no border of it. Nothing ends inside
    a piece that does not go on: what is left out of the other one there is a hole in it.
    """
    both = tuple(zip(questions, placements, strict=True))
    on = [_goes_on(*each) for each in both]
    if any(on[side] and _border(*both[1 - side]) < INSIDE for side in (0, 1)):
        return 1.0
    inside = np.concatenate([on[1 - side] * _rim_inside(*both[side]) for side in (0, 1)])
    return float(inside.mean()) if len(inside) else 0.0


def _goes_on(question: Question, place: SharedPlacement) -> bool:
    """Whether more of a piece than slivers along its cut is not shared."""
    mesh = question.part.mesh
    beyond = ~place.shared & (question.part.cut_distance > INSIDE)
    return bool(mesh.vertex_areas @ beyond > (1.0 - WITHIN) * mesh.area)


def _border(question: Question, place: SharedPlacement) -> float:
    """How much of the border of a piece is shared, as a length."""
    mesh = question.part.mesh
    border = mesh.boundary_edges
    ends = mesh.vertices[border[place.shared[border].all(axis=1)]]
    return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum())


def _rim_inside(question: Question, place: SharedPlacement) -> Ints:
    """For each edge that leaves what is shared, whether it is inside of both pieces there."""
    first, second = question.part.mesh.edges.T
    leaving = place.shared[first] != place.shared[second]
    rim = np.where(place.shared[first], first, second)[leaving]
    here = question.part.cut_distance[rim]
    there = place.trip.points[rim].interpolate(question.full.mesh, question.full.cut_distance)
    inside: Ints = (np.minimum(here, there) > INSIDE).astype(np.int64)
    return inside


def _handedness(
    labelings: TwoLabelings,
    questions: Both[Question],
    placements: Both[SharedPlacement],
    seed: int,
) -> float:
    """The logarithm of the energy of mirror images over that of what is shared, in its place.

    Nodes and labels are those of what is shared. A body as a whole is its own mirror image and
    says nothing; a left leg on a right one has less energy mirrored, one on itself has more.
    """
    turned, straight = 0.0, 0.0
    for side, question in enumerate(questions):
        part = sampled_within(question.part, placements[side].shared)
        if len(part.sparse) < LEAST_NODES:
            continue
        chance = max(labelings.chance[side], 1e-12)
        there = replace(question, free=placements[1 - side].shared)
        straight += _total_energy(there.with_part(part), seed) / chance
        turned += _total_energy(there.with_part(mirrored(part)), seed) / chance
    return float(np.log(turned / straight)) if straight > 0 and turned > 0 else 0.0


def _total_energy(question: Question, seed: int) -> float:
    problem = anchor_problem(question, np.random.default_rng(seed))
    found = proposed_anchors(problem, first_labeling(problem), rounds=MIRROR_ROUNDS)
    return found.energy * len(problem.nodes)
