"""A union in the pose of another one of its members, asked where it finds nothing in its own.

A union has the pose of its first piece, and where that bends a joint as a third piece does not the
third one is not found. Members are asked as they are, too, but a single piece may have half of a
joint only. So at last the largest group is bent as a member is: what that one has lies as it does
there, and elasticity carries the rest along.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.correspondence.labels.labeling import SAME_SCALE
from sherd.correspondence.question import Question
from sherd.mesh.geometry import closest_rotation
from sherd.mesh.surface_points import closest_points
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.puzzle.growing.asking import Asking, Meet, asked, unless_strangers
from sherd.puzzle.growing.members import carried
from sherd.puzzle.growing.record import Growth, chance_at
from sherd.puzzle.growing.union import (
    LAYER,
    Union,
    floating,
    larger_first,
    main_group_first,
    named_at,
)
from sherd.puzzle.pairwise.answer import Ground, Meeting, ground_of
from sherd.surface.described import DescribedSurface
from sherd.surface.prepared import described_part

__all__ = ["ask_in_poses", "in_pose_of"]

# Who is left is asked in the poses of so many members, those of which cheap evidence says most: of
# seven pieces these are nearly all.
POSES = 4
# Poses between which no vertex moves farther than labels are apart are one: what is seen is as far
# apart. Of 30 poses of eight groups 12 are the group's own, eleven of them to 0.025: what floats on
# it has the bends of its own piece already. The others move some vertices by 0.034 to 0.24, and the
# limb that was found in such a pose needed 0.18.
SAME_POSE = 0.03


def ask_in_poses(groups: Sequence[Union], evidence: Floats, asking: Asking, growth: Growth) -> bool:
    """Ask the largest group in poses of its members for all that are left; whether one is likely.

    That is kept in mind. What looks likely at a glance is asked as all others are, and is as likely
    as it is found in one of so many poses. Nobody is asked twice in one pose, also if the group has
    grown: who joined it hardly changes what is seen at other joints.
    """
    likely = False
    largest, *others = main_group_first(groups)
    bent = _in_poses(largest, _unasked(largest, others, evidence, growth), growth)
    for posed, waiting in bent:
        for other in waiting:
            first, second = larger_first(posed, other)
            if _may_be_likely(asking.glance(first, second)):
                meet = _in_one_of(growth.poses[other.members], asking.meet)
                join = unless_strangers(asked(first, second, meet, growth), growth)
                growth.chances[first.members, second.members] = join.met.chance
                likely |= _may_be_likely(join.met)
    return likely


def _in_poses(
    largest: Union, unasked: Mapping[int, Sequence[Union]], growth: Growth
) -> list[tuple[Union, list[Union]]]:
    """The largest group in the poses of members, and who has not been asked of it there.

    Poses that differ by less than what is seen are one, and its own is known already.
    """
    if not unasked:
        return []
    surface = described_part(largest.mesh, largest.mesh.length)
    seen = [(surface.mesh.vertices, [other for each in unasked.values() for other in each])]
    found = []
    for member, waiting in unasked.items():
        growth.posed |= {(member, other.members) for other in waiting}
        posed = in_pose_of(largest, surface, member, growth)
        if posed is None:
            continue
        bent = posed.mesh.vertices / largest.mesh.length
        left = list(waiting)
        for pose, told in seen:
            if _are_one(bent, pose, surface.mesh.vertex_areas):
                left = [other for other in left if other not in told]
        seen.append((bent, left))
        found.append((posed, left))
        for other in left:
            growth.poses[other.members] = growth.poses.get(other.members, 1) + 1
    return found


def _in_one_of(poses: int, meet: Meet) -> Meet:
    """The same question where it is asked in so many poses of one union.

    Any of them may be the right one, and in each something may look right by accident. So each has
    its share of the odds that one question has (Bonferroni): another animal's leg had 0.18 and 0.17
    on a horse in two poses and 0.84 in a third.
    """

    def shared(chance: float) -> float:
        return chance_at(chance / (1.0 - chance) / poses)

    def met(one: Union, other: Union, known: Ints, taken: Bools | None) -> Meeting:
        found = meet(one, other, known, taken)
        return replace(
            found,
            chance=shared(found.chance),
            by_skin=shared(found.by_skin),
            filling=shared(found.filling),
            at_large=None if found.at_large is None else shared(found.at_large),
        )

    return met


def _unasked(
    largest: Union, others: Sequence[Union], evidence: Floats, growth: Growth
) -> dict[int, list[Union]]:
    """By the members in whose poses others are asked, those that were not asked there yet."""
    ranked = [(other, _ranked(largest, other, evidence)) for other in others]
    waiting = {
        member: [
            other
            for other, members in ranked
            if member in members and (member, other.members) not in growth.posed
        ]
        for member in largest.members[1:]
    }
    return {member: found for member, found in waiting.items() if found}


def _ranked(union: Union, other: Union, evidence: Floats) -> list[int]:
    """The members in whose poses a union is asked for another one; it has the first one's."""

    def rank(member: int) -> float:
        return max(float(evidence[member, each]) for each in other.members)

    return sorted(union.members[1:], key=rank, reverse=True)[:POSES]


def _may_be_likely(met: Meeting) -> bool:
    return ground_of(met)[0] != Ground.NONE


def _are_one(one: Floats, other: Floats, areas: Floats) -> bool:
    """Whether two poses of one surface, in units of it, are one but for a rigid motion."""
    here = one - np.average(one, axis=0, weights=areas)
    there = other - np.average(other, axis=0, weights=areas)
    turned = here @ closest_rotation(here, there, areas).T
    return bool(np.linalg.norm(turned - there, axis=1).max() < SAME_POSE)


def in_pose_of(
    union: Union, surface: DescribedSurface, member: int, growth: Growth
) -> Union | None:
    """The same union in the pose of a member; None if it has nothing of that any more.

    What the member has lies as it does there, and elasticity carries the rest along. The first of
    its members is that one then. The `surface` is the union in units of itself.
    """
    unit = union.mesh.length
    at = closest_points(surface.placed, surface.mesh.vertices)
    lying, known = _as_it_lies(
        union, member, at.interpolate(surface.placed, union.mesh.vertices), growth
    )
    owner, places = named_at(at, union.mesh, union.owner, union.places)
    own = owner == member
    lying[own], known[own] = places[own], True
    if not known.any():
        return None
    bent = floating(Question(surface, surface, SAME_SCALE), lying / unit, known) * unit
    mesh = TriangleMesh(bent, surface.mesh.faces, name=union.mesh.name)
    others = (each for each in union.members if each != member)
    return Union(mesh, owner, places, (member, *others))


def _as_it_lies(
    union: Union, member: int, positions: Floats, growth: Growth
) -> tuple[Floats, Bools]:
    """Where positions (q, 3) on a union lie on a member (q, 3), and which of them (q,) it has."""
    piece = growth.pieces[member].mesh
    carry, found = carried(piece.vertices, np.full(piece.vertex_count, member), union, growth.joins)
    faces = piece.faces[found[piece.faces].all(axis=1)]
    if not len(faces):
        return np.zeros_like(positions), np.zeros(len(positions), dtype=bool)
    chart = TriangleMesh(carry, faces)
    at = closest_points(chart, positions)
    off = np.linalg.norm(at.positions(chart) - positions, axis=1)
    known: Bools = off < LAYER * union.mesh.mean_edge_length
    return at.interpolate(chart, piece.vertices), known
