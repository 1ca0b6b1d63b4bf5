"""A piece whose mirror image lies on what is joined already belongs beside that.

Of a body with two sides each limb has a twin. Where one of them is joined, and the other one is to
be, the mirror image of the second lies on the first as a whole, from its tip to what both share
with the trunk. What is shared at the place where the limb belongs is a rim, and how the limb goes
on beyond it nobody sees there; what another animal's limb shares with the same rim may be as
alike. The twin tells, since it has all of the limb.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
from scipy.special import logit
from scipy.stats import wasserstein_distance

from sherd.arrays import Floats, Ints
from sherd.correspondence.confidence import measured_chance
from sherd.correspondence.shared.two_way_placement import SharedPlacement
from sherd.puzzle.pairwise.answer import JOINED, Meeting, ground_of
from sherd.puzzle.pairwise.join_chance import ends_with_one, lies_within
from sherd.surface.described import DescribedSurface

__all__ = ["apart_by_distances", "beside_their_twins"]

# How many times as likely it is that a limb belongs there, if its mirror image surely lies on what
# is there. Five bodies that lack a limb were asked for its mirror image: their own surely lies on
# the twin in five of five (0.95 and more), that of another species in none of eight (0.39 at most).
# So nearly all that belong have that evidence, and of the others one in ten at most.
TWIN_ODDS = 10.0
# More of a place than this is not beside another one. Pieces that reach over the middle share that
# with their mirror image: right places of a horse's and a cat's limb share 0.54 and 0.59 of
# themselves with the twin's, those that lie on the twin 0.73 and more.
COMMON = 0.66
# What has two sides is as far from all else on both, by the Wasserstein distance, but for what a
# union is bent by and answers are off: 0.003 to 0.007 for four limbs of two men and a horse that
# lie 0.3 to 0.9 off on bodies of one piece, 0.010 and 0.011 for legs of a cat and a horse that lie
# 2.5 and 4.6 off on unions. Legs at places of other legs have 0.042 to 0.065: half way, by ratio.
# Two legs of men that lie 1.7 and 2.5 off on bent unions have 0.033 and 0.040; such are left to
# what lies across from the twin, and is never called sure. Nor does it help that the skin fits: a
# leg of a cat on another one, 24 off, fits by 0.93 and has 0.065, one of a horse, 34 off, fits by
# 0.29 and has 0.049.
AS_FAR = 0.02
# Distances are compared from so many nodes.
MOST_NODES = 100


def beside_their_twins(
    answers: Sequence[Meeting], asked_mirrored: Callable[[], Meeting]
) -> Meeting:
    """The likeliest of several answers of which none is sure, by what the mirror image says, too.

    What lies beside the place of the mirror image, is as far there from all else as its twin is,
    and could be sure by that, has TWIN_ODDS times the odds of what is seen of its skin but for
    reliefs. That few of its places lead is no evidence then, as they look like those of its twin;
    nor is it that one of two places is more alike, or that a rim has few bumps.

    Joints bend beside a rim, so the skin that is shared there often tells nothing. So of all that
    may lie right but for the twin's sake, as enough places lead and what is shared ends where one
    of both pieces ends, what is most nearly as far from all else is as sure as that the twin is
    one, if it is clearly so.

    Parameters
    ----------
    answers
        At least one.
    asked_mirrored
        Asks the same of the mirror image of the second surface.
    """
    best = max(answers, key=ground_of)
    if best.chance >= JOINED:
        return best
    beside = [each for each in answers if not lies_within(each.questions, each.placements)]
    fitting = [each for each in beside if _raised(each.fitting) >= JOINED]
    ending = {
        each: surely
        for each in beside
        if each.leads and (surely := ends_with_one(each.questions, each.placements)) >= JOINED
    }
    if not fitting and not ending:
        return best
    twin = asked_mirrored()
    if twin.by_skin < JOINED or not lies_within(twin.questions, twin.placements):
        return best

    @cache
    def off(answer: Meeting) -> float:
        apart = _common(answer, twin) < COMMON
        return _off_by_distances(answer, twin) if apart else math.inf

    sure = [(each, _raised(each.fitting)) for each in fitting if off(each) < AS_FAR]
    nearest = min(ending, key=off, default=None)
    if nearest is not None and off(nearest) < AS_FAR:
        sure.append((nearest, ending[nearest] * twin.by_skin))
    return max(
        [best, *(replace(each, chance=chance, twin=False) for each, chance in sure)], key=ground_of
    )


def _raised(chance: float) -> float:
    return measured_chance(math.log(TWIN_ODDS) + float(logit(chance)))


def _common(answer: Meeting, twin: Meeting) -> float:
    """The share of an answer's place on the first surface where the mirror image lies, too."""
    areas = answer.questions[0].full.mesh.vertex_areas
    place = areas * answer.placements[1].shared
    return float(place @ twin.placements[1].shared / max(place.sum(), 1e-12))


def _off_by_distances(answer: Meeting, twin: Meeting) -> float:
    """How much distances to the rest of the first surface differ there and at the twin's place.

    Mean over nodes that both placements lay of how far apart they are, by area; infinite where
    there are none.
    """
    full, part = twin.questions[0].full, answer.questions[0].part
    here, there = answer.placements[0], twin.placements[0]
    nodes = part.sparse.vertices[part.sparse.farthest_first]
    nodes = nodes[here.shared[nodes] & there.shared[nodes]][:MOST_NODES]
    rest = full.mesh.vertex_areas * ~(answer.placements[1].shared | twin.placements[1].shared)
    counts = np.bincount(full.dense.cells, rest, minlength=len(full.dense))
    weights = counts.astype(np.float64, copy=False)
    if not len(nodes) or not weights.any():
        return math.inf
    own, its = (_from_nodes(full, place, nodes) for place in (here, there))
    return apart_by_distances(own, its, weights)


def _from_nodes(full: DescribedSurface, place: SharedPlacement, nodes: Ints) -> Floats:
    """Distances (q, n) from where nodes (q,) lie to all labels."""
    feet = place.trip.points[nodes].nearest_vertices(full.mesh)
    distances: Floats = full.dense.between[full.dense.cells[feet]].astype(np.float64)
    return distances


def apart_by_distances(first: Floats, second: Floats, weights: Floats) -> float:
    """Mean Wasserstein distance of the rows of two arrays (q, n), by weights (n,).

    What does not hang together is infinitely far, and tells nothing where it is so from both;
    infinite where one reaches what the other one does not.
    """
    counted = weights > 0.0
    pairs = zip(first[:, counted], second[:, counted], strict=True)
    return float(np.mean([_apart(*pair, weights[counted]) for pair in pairs]))


def _apart(one: Floats, other: Floats, weights: Floats) -> float:
    reached = np.isfinite(one)
    if not reached.any() or np.any(reached != np.isfinite(other)):
        return math.inf
    told = weights[reached]
    return float(wasserstein_distance(one[reached], other[reached], told, told))
