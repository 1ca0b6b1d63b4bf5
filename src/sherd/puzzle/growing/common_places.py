"""Which places two joins have in common: of one piece, of unions that grew, of two on a third."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from sherd.arrays import Bools, Floats, Ints
from sherd.puzzle.growing.union import LAYER, Join, Union, origins
from sherd.puzzle.pairwise.join_chance import lies_within
from sherd.spectral.sampling import farthest_point_sample_euclidean

__all__ = [
    "crowding",
    "is_within",
    "laid_alike",
    "left_out",
    "lying_in",
    "nearest_places",
    "recalled",
    "taken_by",
]

# So many places fix a placement on a surface, also if one of them is gone.
RECALLED = 4


def crowding(one: Join, other: Join) -> float:
    """Share of the smaller place that two pieces have on a third one that is the other's too.

    Both were laid on unions that have the third piece. Shares are of area, as both may have been
    asked in meshes that are not equally fine.
    """
    common = _area_in_common(one, other)
    return common / min(_area_taken(one), _area_taken(other)) if common else 0.0


def lying_in(one: Join, other: Join) -> float:
    """Share of the place of a piece on a third one that is another piece's, too.

    What lies in a part of a large place does not have it: where pieces overlap a limb and the half
    of the body beside it both have its rim.
    """
    common = _area_in_common(one, other)
    return common / _area_taken(one) if common else 0.0


def _area_in_common(one: Join, other: Join) -> float:
    """Of the places that two pieces have on a third one, as the smaller of both says."""
    smaller, larger = sorted((one, other), key=_area_taken)
    owners, places = _taken(smaller)
    others, further = _taken(larger)
    areas = _areas_taken(smaller)
    reach = LAYER * max(join.first.mesh.mean_edge_length for join in (one, other))
    common = 0.0
    for piece in np.intersect1d(owners, others):
        near, _ = nearest_places(further[others == piece], places[owners == piece], reach)
        common += float(areas[owners == piece][near].sum())
    return common


def is_within(join: Join) -> bool:
    """Whether one lies within the other, which adds nothing and has no border there to tell by."""
    return lies_within(join.met.questions, join.met.placements)


def taken_by(join: Join, union: Union) -> Bools:
    """The vertices (n,) of a union where the second of a join lies; the join's first is in it."""
    owners, places = _taken(join)
    reach = LAYER * union.mesh.mean_edge_length
    taken = np.zeros(union.mesh.vertex_count, dtype=bool)
    for piece in np.intersect1d(owners, union.owner):
        rows = np.flatnonzero(union.owner == piece)
        tree = cKDTree(places[owners == piece])
        near = tree.query(union.places[rows], distance_upper_bound=reach)[0]
        taken[rows] = np.isfinite(near)
    return taken


def recalled(join: Join, first: Union, second: Union) -> Ints:
    """A few pairs (p, 2) of vertices of larger unions that lie on each other by an earlier join.

    Of what both directions agreed on best some that lie far apart; none where larger unions no
    longer have the place.
    """
    question, place = join.met.questions[0], join.met.placements[0]
    nodes = question.part.sparse
    order = nodes.vertices[nodes.farthest_first]
    order = order[place.shared[order]]
    if not len(order):
        return np.empty((0, 2), dtype=np.int64)
    sure = place.apart[order] <= np.median(place.apart[order])
    owner, places = origins(join.second, question.part)
    owners, further = origins(join.first, question.full)
    pairs: list[list[int]] = []
    for vertex in order[sure]:
        foot = int(place.trip.points[[vertex]].nearest_vertices(question.full.mesh)[0])
        found = [
            _vertex_at(first, second, int(owner[vertex]), places[vertex]),
            _vertex_at(first, second, int(owners[foot]), further[foot]),
        ]
        if {side for side, _ in found} == {0, 1}:
            pairs.append([at for _, at in sorted(found)])
        if len(pairs) == RECALLED:
            break
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def left_out(before: Join, join: Join) -> float:
    """Share of what two unions were said to share that larger ones, which have it still, do not.

    0 where these have nothing of it any more, as of what two pieces share a union keeps one side.
    """
    reach = LAYER * join.first.mesh.mean_edge_length
    lost, found = 0, 0
    now = _of_both(join)
    for union, owners, places in _sharing(before):
        for larger, others, further, shared in now:
            if not set(union.members) <= set(larger.members):
                continue
            for piece in np.intersect1d(owners, others):
                rows = np.flatnonzero(others == piece)
                nearest = rows[nearest_places(further[rows], places[owners == piece], reach)[1]]
                lost += int((~shared[nearest]).sum())
                found += len(nearest)
    return lost / max(found, 1)


def laid_alike(one: Join, other: Join) -> Ints:
    """A few pairs (p, 2) of vertices of two unions that both joins laid on one place of a third.

    Some that lie far apart; the seconds of both joins are the unions. None where nothing is shared.
    """
    owners, places = _taken(one)
    others, further = _taken(other)
    reach = LAYER * one.first.mesh.mean_edge_length
    own, its = _lying(one), _lying(other)
    pairs: list[Ints] = []
    for piece in np.intersect1d(owners, others):
        rows, columns = np.flatnonzero(owners == piece), np.flatnonzero(others == piece)
        near, nearest = nearest_places(further[columns], places[rows], reach)
        pairs.append(np.column_stack([own[rows[near]], its[columns[nearest]]]))
    if not pairs:
        return np.empty((0, 2), dtype=np.int64)
    found = np.concatenate(pairs)
    count = min(RECALLED, len(found))
    points = one.second.mesh.vertices[found[:, 0]]
    return found[farthest_point_sample_euclidean(points, count, start=0)] if count else found


def nearest_places(known: Floats, asked_for: Floats, reach: float) -> tuple[Bools, Ints]:
    """Which places (q, 3) have one of the known ones (k, 3) within reach, and of these the nearest.

    None of them if nothing is known.
    """
    if not len(known):
        return np.zeros(len(asked_for), dtype=bool), np.empty(0, dtype=np.int64)
    away, nearest = cKDTree(known).query(asked_for, distance_upper_bound=reach)
    near: Bools = np.isfinite(away)
    return near, np.asarray(nearest, dtype=np.int64)[near]


def _taken(join: Join) -> tuple[Ints, Floats]:
    """Where the second lies on the first: pieces (q,) and places (q, 3) there."""
    question = join.met.questions[0]
    owners, places = origins(join.first, question.full)
    shared = join.met.placements[1].shared
    return owners[shared], places[shared]


def _areas_taken(join: Join) -> Floats:
    """The areas (q,) of these places, in the unit of the meshes."""
    areas: Floats = join.met.questions[0].full.mesh.vertex_areas
    return areas[join.met.placements[1].shared] * join.met.unit**2


def _area_taken(join: Join) -> float:
    return float(_areas_taken(join).sum())


def _vertex_at(first: Union, second: Union, owner: int, place: Floats) -> tuple[int, int]:
    """Which of two unions has a place of a piece (0 or 1; -1: neither), and its vertex there."""
    side = 0 if owner in first.members else 1
    union = (first, second)[side]
    rows = np.flatnonzero(union.owner == owner)
    if not len(rows):
        return -1, -1
    off = np.linalg.norm(union.places[rows] - place, axis=1)
    nearest = int(off.argmin())
    if off[nearest] > LAYER * union.mesh.mean_edge_length:
        return -1, -1
    return side, int(rows[nearest])


def _sharing(join: Join) -> list[tuple[Union, Ints, Floats]]:
    """Of both unions what is shared: pieces (q,) and places (q, 3)."""
    return [
        (union, owners[shared], places[shared]) for union, owners, places, shared in _of_both(join)
    ]


def _of_both(join: Join) -> list[tuple[Union, Ints, Floats, Bools]]:
    """The second and the first: the piece and place of each vertex, and whether it is shared."""
    sides = zip((join.second, join.first), join.met.questions, join.met.placements, strict=True)
    return [
        (union, *origins(union, question.part), place.shared) for union, question, place in sides
    ]


def _lying(join: Join) -> Ints:
    """The vertices (q,) of the second that lie where it was laid on the first, as in `_taken`."""
    question, place = join.met.questions[1], join.met.placements[1]
    rows = place.trip.points[np.flatnonzero(place.shared)].nearest_vertices(question.full.mesh)
    at = question.full.mesh.vertices[rows]
    return np.asarray(cKDTree(question.full.placed.vertices).query(at)[1], dtype=np.int64)
