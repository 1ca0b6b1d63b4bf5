"""What members of two unions say to each other in their own poses, where the unions say nothing.

A union has the pose of its first piece. Where that bends a joint as a third piece does not, the
third one finds nothing there, though another member shares that joint as well and bends it much as
the third one does: hind legs of a horse that gallops, of which the front half is the largest piece.
So where unions find nothing their members are asked, each as it is. What one of them surely shares
is carried to where its union has it, and laid there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.correspondence.confidence import LEAST
from sherd.correspondence.shared.two_way_placement import CLOSED, share_something
from sherd.mesh.surface_points import closest_points
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.puzzle.growing.asking import Asking, against, asked, unless_strangers
from sherd.puzzle.growing.common_places import left_out, nearest_places
from sherd.puzzle.growing.record import CROWD, Growth, chance_of, laid_there
from sherd.puzzle.growing.union import LAYER, Join, Union, larger_first, named_at, origins
from sherd.puzzle.pairwise.answer import JOINED, LIKELY
from sherd.puzzle.pairwise.body import Told
from sherd.puzzle.pairwise.join_chance import ends_with_one

__all__ = ["ask_members", "carried", "laid_as_before", "told_by", "told_by_members"]

# Of two unions so many pairs of members are asked, those that cheap evidence ranks first. Of seven
# pieces these are nearly all, and a pair costs a third of a question; of a dozen the right one is
# seldom behind (it was the first to third in four puzzles).
MEMBERS = 4


def ask_members(
    first: Union, second: Union, evidence: Floats, asking: Asking, growth: Growth
) -> None:
    """Ask members of two unions that were not asked yet; what is sure is kept in mind.

    Who bends a joint alike sees it at a glance; what looks likely then is asked as all others are.
    """
    ranked = sorted(product(first.members, second.members), key=lambda pair: -evidence[pair])
    for pair in ranked[:MEMBERS]:
        one, other = larger_first(*(growth.pieces[member] for member in pair))
        key = (one.members, other.members)
        if key in growth.chances or key in growth.of_members:
            continue
        found = Join(one, other, asking.glance(one, other))
        if found.met.chance >= LIKELY:
            found = unless_strangers(asked(one, other, asking.meet, growth), growth)
        growth.of_members[key] = found.met.chance
        if found.met.chance >= JOINED:
            growth.sure_of_members.append(found)


def told_by_members(first: Union, second: Union, asking: Asking, growth: Growth) -> Join | None:
    """The larger union and the other one, laid as a member of each surely lies on one of the other.

    As likely as these two are to share what they share, that what the unions share so ends where
    one of them does, and that nothing likely contradicts it. None if nothing is sure, or the unions
    cannot be laid so.
    """
    for before in sorted(growth.sure_of_members, key=chance_of, reverse=True):
        sides = {before.first.members[0], before.second.members[0]}
        if not (sides & set(first.members) and sides & set(second.members)):
            continue
        join = _laid_unless_taken(before, first, second, asking, growth)
        if join is not None and join.met.chance >= JOINED:
            growth.told[first.members, second.members] = before
            return join
    return None


def _laid_unless_taken(
    before: Join, first: Union, second: Union, asking: Asking, growth: Growth
) -> Join | None:
    """Both laid as members were, unless others have that place; less sure if it was elsewhere."""
    join = laid_as_before(before, first, second, asking, growth)
    if join is None or any(laid_there(join, place, loser) for place, loser in growth.settled):
        return None
    for each in growth.likely_before(first, second):
        if each is not before and left_out(each, join) > CROWD:
            return against(join, each)
    return join


def laid_as_before(
    before: Join, first: Union, second: Union, asking: Asking, growth: Growth
) -> Join | None:
    """Two unions laid on each other as parts of them were; None if these do not lie there then.

    As likely as that was, and that what they share ends where one of both does.
    """
    told = told_by(before, first, second, growth.joins)
    if not told.known.any():
        return None
    met = asking.lay(first, second, told)
    if not share_something(met.placements):
        return None
    chance = before.met.chance * ends_with_one(met.questions, met.placements)
    join = Join(first, second, replace(met, chance=max(chance, LEAST)))
    return None if left_out(before, join) > CROWD else join


def told_by(before: Join, first: Union, second: Union, joins: Sequence[Join]) -> Told:
    """Where a union lies on another one, as a part of each lies on the other's.

    Parameters
    ----------
    before
        Of two pieces, or unions.
    first, second
        Unions that have their members, one each.
    joins
        What the unions were made by, in that order.
    """
    side = 0 if set(before.second.members) <= set(second.members) else 1
    part, full = (before.second, before.first) if side == 0 else (before.first, before.second)
    question, place = before.met.questions[side], before.met.placements[side]
    meets = place.shared & (place.trip.gap <= CLOSED)
    pieces, feet = named_at(place.trip.points, question.full.mesh, *origins(full, question.full))
    positions, found = carried(feet, pieces, first, joins)
    owners, own = origins(part, question.part)
    told = np.array(second.mesh.vertices)
    everywhere = np.zeros(len(told), dtype=bool)
    for piece in part.members:
        faces = question.part.mesh.faces
        faces = faces[(owners[faces] == piece).all(axis=1)]
        rows = np.flatnonzero(second.owner == piece)
        if not len(faces) or not len(rows):
            continue
        chart = TriangleMesh(own, faces)
        at = closest_points(chart, second.places[rows])
        off = np.linalg.norm(at.positions(chart) - second.places[rows], axis=1)
        known = off < LAYER * chart.mean_edge_length
        known &= (meets & found)[chart.faces[at.faces]].all(axis=1)
        told[rows] = at.interpolate(chart, positions)
        everywhere[rows[known]] = True
    return Told(told, everywhere)


def carried(
    places: Floats, pieces: Ints, union: Union, joins: Sequence[Join]
) -> tuple[Floats, Bools]:
    """Positions (q, 3) on a union of places (q, 3) on its members (q,), and which it has.

    Where a member gave way to another one when it was joined, its places are those of the other.
    """
    owners, at = np.array(pieces), np.array(places)
    for join in joins:
        if set(join.members) <= set(union.members):
            _give_way(join, owners, at)
    found = np.zeros(len(places), dtype=bool)
    positions = np.zeros_like(at)
    reach = LAYER * union.mesh.mean_edge_length
    for owner in np.unique(owners):
        own, rows = np.flatnonzero(union.owner == owner), np.flatnonzero(owners == owner)
        near, vertices = nearest_places(union.places[own], at[rows], reach)
        positions[rows[near]] = union.mesh.vertices[own[vertices]]
        found[rows[near]] = True
    return positions, found


def _give_way(join: Join, owners: Ints, at: Floats) -> None:
    """Name places on the second of a join, where it lies on the first, as the first does."""
    question, place = join.met.questions[0], join.met.placements[0]
    own, there = origins(join.second, question.part)
    others, further = origins(join.first, question.full)
    feet = place.trip.points.nearest_vertices(question.full.mesh)
    reach = LAYER * join.second.mesh.mean_edge_length
    for owner in np.intersect1d(np.unique(owners), own):
        surface, rows = np.flatnonzero(own == owner), np.flatnonzero(owners == owner)
        near, vertices = nearest_places(there[surface], at[rows], reach)
        shared = place.shared[surface[vertices]]
        lying = feet[surface[vertices[shared]]]
        gone = rows[near][shared]
        owners[gone], at[gone] = others[lying], further[lying]
