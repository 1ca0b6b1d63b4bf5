"""Where a limb lies across from its twin, which tells of it what its own place cannot.

The last limb of a body shares a joint with what is joined already, and joints bend: its skin is
stretched there by as much as that of strangers that fit by chance, so even where it lies right what
is shared does not tell. But its mirror image lies on its twin, as a whole and with all its relief,
as a piece lies on its whole; see :func:`sherd.match`. And the body is its own mirror image but for
the limb, so what lies on the twin lies on the other side as well.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.special import expit, logit

from sherd.arrays import Bools, Floats, Ints
from sherd.correspondence.confidence import LEAST, MOST
from sherd.correspondence.shared.judgment import shared_area
from sherd.correspondence.shared.round_trip import on_border
from sherd.correspondence.shared.two_way_placement import share_something
from sherd.match import match_result
from sherd.mesh.surface_points import closest_points
from sherd.mesh.topology import renumbered
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import Stages
from sherd.place import labeled_again, laid_part, placed_part
from sherd.puzzle.pairwise.answer import LIKELY, Meeting
from sherd.puzzle.pairwise.body import Body, Told
from sherd.puzzle.pairwise.join_chance import ends_with_one, lies_within
from sherd.puzzle.pairwise.meeting import free_vertices
from sherd.puzzle.pairwise.skin_chance import least_alike
from sherd.puzzle.pairwise.sliding import alike_in_reliefs, slid
from sherd.results.match_options import MatchOptions
from sherd.results.match_result import MatchResult
from sherd.results.overlap_options import OverlapOptions
from sherd.scan.intake import scan_intake
from sherd.spectral.geodesics import Geodesics
from sherd.spectral.sampling import farthest_point_sample_euclidean
from sherd.surface.transformed import mirrored_mesh
from sherd.threads import one_blas_thread

__all__ = ["MOST_ACROSS", "laid_across", "on_its_twin", "twin_features"]

# Of one, the logit of the chance that the match of the mirror image has, and how much more alike
# reliefs are there than they must be. A logistic regression, weights kept small, over 59 pieces
# asked beside unions of three to five pieces of a horse, two men and a cat: of the same body in
# other poses and cut elsewhere, 12 of them right, and of other species; wrong ones counting twice.
# Of right ones one is below 0.65, of wrong ones none is above 0.26. With each shape left out in
# turn right ones have 0.55 and more, wrong ones 0.37 at most.
TWIN_COEFFICIENTS = (-2.7, 2.6, 8.1)
# Limbs of another body of the same kind lie on the twin as well: two arms of a man on another one
# 0.99, a leg of one generated animal on another one 0.99. So what is told by a twin is likely, and
# never sure: this is just below what is joined while groups grow.
MOST_ACROSS = 0.75
# A limb has less than half of its body.
LIMB = 0.5
# So many places of the body say by their distances where a limb lies, and so many of the limb ask:
# the labels of a limb are a few dozen.
LANDMARKS, ASKING = 120, 200
# Half of the landmarks are as far from a place on one side as from that on the other but for this,
# a spacing of labels.
AS_FAR = 0.03
# In edges: what lies farther from the mirror image of the body is nowhere on the other side.
NEAR = 2.0


@one_blas_thread()
def laid_across(body: Body, second: TriangleMesh) -> Meeting | None:
    """Where a surface lies on a body, if its mirror image lies on its twin there.

    As likely as that the mirror image lies on the twin, that the body is its own mirror image, and
    that what both share ends where one of them does; never sure. None where the mirror image lies
    nowhere, or the surface lies within the body.

    Parameters
    ----------
    body
        Asks all that are left.
    second
        Without what needs repair, in the same unit of length, and smaller.
    """
    image = on_its_twin(body, second)
    if image is None:
        return None
    chance = _twin_chance(image, body.met(mirrored_mesh(second), _all_told(image)))
    if chance < LIKELY:
        return None
    symmetry, told = _other_side(body, image)
    if not told.known.any():
        return None
    met = body.met(second, told)
    if not share_something(met.placements):
        return None
    if lies_within(met.questions, met.placements):
        return None
    met = _where_reliefs_agree(met)
    chance *= symmetry * ends_with_one(met.questions, met.placements)
    return replace(met, chance=float(np.clip(chance, LEAST, MOST_ACROSS)))


def on_its_twin(body: Body, second: TriangleMesh) -> MatchResult | None:
    """The mirror image of a surface matched on a body.

    None where it cannot be, where it would rather lie there as it is, and where it covers so much
    that no body is left that could have two sides.
    """
    found = body.image_matched(second)
    if found is None:
        return None
    image = found.result
    as_it_is = image.twin_score
    mirrored = as_it_is is None or image.best.score > as_it_is
    covered = float(body.mesh.vertex_areas @ image.best.mask) / body.mesh.area
    return image if mirrored and covered < LIMB else None


def twin_features(image: MatchResult, lying: Meeting) -> Floats:
    """Features (3,) of a mirror image that lies on its twin.

    One; the logit of the chance of its match; by how much reliefs are more alike than they must be.
    """
    questions, placements = lying.questions, lying.placements
    chance = float(np.clip(0.0 if image.chance is None else image.chance, LEAST, MOST))
    alike = alike_in_reliefs(questions, placements)
    least = least_alike(shared_area(questions, placements))
    return np.array([1.0, logit(chance), alike - least])


def _twin_chance(image: MatchResult, lying: Meeting) -> float:
    if not share_something(lying.placements):
        return LEAST
    features = twin_features(image, lying)
    return float(expit(features @ np.array(TWIN_COEFFICIENTS)))


def _all_told(found: MatchResult) -> Told:
    return Told(found.positions, np.ones(found.part.vertex_count, dtype=bool))


def _other_side(body: Body, image: MatchResult) -> tuple[float, Told]:
    """Where what lies on the twin lies on the other side; and how surely there is one.

    The body without the twin is matched with its own mirror image. A stump has been seen to lie on
    itself then, with its back on its front, so that is forbidden once the distances from all the
    rest say where the stump is.
    """
    first, twin = body.mesh, image.best.mask
    used, faces = renumbered(first.faces[~twin[first.faces].all(axis=1)])
    rest = mirrored_mesh(TriangleMesh(first.vertices[used], faces, name=first.name))
    placed = placed_part(
        body.template, scan_intake(rest), MatchOptions(seed=body.seed), _quiet(), twin=False
    )
    symmetry = match_result(placed, _quiet())
    told = _carried(first, used, symmetry, image)
    stump = _across_by_distances(first, used, symmetry, image)
    if not stump.any():
        return float(symmetry.chance or 0.0), told
    free = free_vertices(placed.template, first, stump)
    again = match_result(laid_part(labeled_again(placed, free, _quiet()), _quiet()), _quiet())
    told_again = _carried(first, used, again, image)
    if told_again.known.mean() > told.known.mean():
        symmetry, told = again, told_again
    return float(symmetry.chance or 0.0), told


def _carried(first: TriangleMesh, used: Ints, symmetry: MatchResult, image: MatchResult) -> Told:
    """Places across from those on the twin, by the body's mirror image that lies there."""
    body = symmetry.part
    chart = TriangleMesh(symmetry.positions, body.faces)
    met = closest_points(chart, image.positions)
    off = np.linalg.norm(met.positions(chart) - image.positions, axis=1)
    known = (off < NEAR * first.mean_edge_length) & ~on_border(chart, met)
    return Told(met.interpolate(chart, first.vertices[used]), known)


def _across_by_distances(
    first: TriangleMesh, used: Ints, symmetry: MatchResult, image: MatchResult
) -> Bools:
    """The vertices (n,) of a body around places that are as far from all else as the twin is.

    Of places of the twin those on the other side that half of the landmarks are as far from as
    their own mirror images are from the twin. As a sum it would miss what the mirror image of the
    body gets wrong, which are single limbs.
    """
    length = first.length
    count = min(LANDMARKS, len(used))
    rows = farthest_point_sample_euclidean(first.vertices[used], count, start=0)
    geodesics = Geodesics(first)
    here = _finite(geodesics.distances_from(used[rows])) / length
    there = _finite(geodesics.distances_from(symmetry.nearest_vertices[rows])) / length
    asking = np.unique(image.nearest_vertices)
    chosen = farthest_point_sample_euclidean(
        first.vertices[asking], min(ASKING, len(asking)), start=0
    )
    others = np.flatnonzero(~image.best.mask)
    across = []
    for place in asking[chosen]:
        apart = np.median(np.abs(there[:, others] - here[:, [place]]), axis=0)
        nearest = int(apart.argmin())
        if apart[nearest] < AS_FAR:
            across.append(others[nearest])
    if not across:
        return np.zeros(first.vertex_count, dtype=bool)
    around: Bools = geodesics.distances_to_set(np.unique(across)) < AS_FAR * length
    return around


def _finite(distances: Floats) -> Floats:
    """What is not connected is as far as anything is."""
    reached = distances[np.isfinite(distances)].max(initial=0.0)
    return np.where(np.isfinite(distances), distances, reached)


def _where_reliefs_agree(met: Meeting) -> Meeting:
    """Slid along the skin, which is stretched at a joint, if reliefs are more alike there."""
    found = slid(met.questions, met.placements, strain=OverlapOptions().strain)
    before, after = (alike_in_reliefs(met.questions, each) for each in (met.placements, found))
    return replace(met, placements=found) if after > before else met


def _quiet() -> Stages:
    return Stages(visible=False)
