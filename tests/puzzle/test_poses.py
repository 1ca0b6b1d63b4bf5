"""A union in the pose of another one of its members."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from sherd.arrays import Floats
from sherd.mesh.geometry import closest_rotation
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.puzzle.growing import poses
from sherd.puzzle.growing.asking import Asking
from sherd.puzzle.growing.poses import ask_in_poses, in_pose_of
from sherd.puzzle.growing.record import Growth
from sherd.puzzle.growing.union import Join, Union, united
from sherd.puzzle.pairwise.answer import Meeting
from sherd.shapes import creature
from sherd.shapes.fragment import Fragment
from sherd.surface.described import DescribedSurface
from sherd.surface.prepared import described_part


@pytest.fixture(scope="module")
def cut(cut_halves: Callable[[float, float], tuple[Fragment, Fragment]]) -> tuple[Fragment, ...]:
    """The front standing, the larger one, and the rear walking; both have the trunk."""
    return cut_halves(1.05, 0.85)


@pytest.fixture(scope="module")
def joined(alone: list[Union], laid_truly: Callable[[int, int], Join]) -> Growth:
    """Both laid on each other from the truth."""
    return replace(Growth.begun(alone), joins=[laid_truly(0, 1)])


@pytest.fixture(scope="module")
def union(joined: Growth) -> Union:
    """Both, standing as the front does."""
    return united(joined.joins[0])


@pytest.fixture(scope="module")
def posed(union: Union, joined: Growth) -> Union:
    """Both, walking as the rear does."""
    bent = in_pose_of(union, described_part(union.mesh, union.mesh.length), 1, joined)
    assert bent is not None
    return bent


def off_by(union: Union, piece: int) -> float:
    """How far what a union has of a piece lies from it, after the best rigid motion (rms)."""
    rows = union.owner == piece
    here, there = union.places[rows], union.mesh.vertices[rows]
    weights = np.ones(len(here))
    turned = (here - here.mean(axis=0)) @ closest_rotation(here, there, weights).T
    return float(np.sqrt((((there - there.mean(axis=0)) - turned) ** 2).sum(axis=1).mean()))


def test_what_a_member_has_lies_as_it_does_there(cut, near, union, posed) -> None:
    assert posed.members == (1, 0)
    length = cut[0].full.length
    # the union has the pose of the front, so the rear is bent there, and now the front is
    assert off_by(union, 0) < 0.005 * length
    assert off_by(posed, 1) < 0.005 * length
    assert off_by(union, 1) > 2 * off_by(posed, 1)
    assert posed.mesh.area == pytest.approx(union.mesh.area, rel=0.02)
    # the same skin, named by the same places
    away = cKDTree(union.places[union.owner == 0]).query(posed.places[posed.owner == 0])[0]
    assert away.max() < near * length


def test_the_trunk_of_the_front_is_bent_as_the_rear_has_it(cut, near, posed) -> None:
    rear, walking = cut[1], creature(5000, pose="walk")
    trees = [cKDTree(piece.truth.positions(piece.full)) for piece in cut]
    front = np.flatnonzero(posed.owner == 0)
    own = cKDTree(cut[0].mesh.vertices).query(posed.places[front])[1]
    truth = trees[0].data[own]
    common = trees[1].query(truth)[0] < near * rear.full.length
    assert common.sum() > 50
    there = walking.vertices[cKDTree(cut[0].full.vertices).query(truth[common])[1]]
    here = posed.mesh.vertices[front[common]]
    away = np.linalg.norm(here[:, None] - here[None], axis=2)
    true = np.linalg.norm(there[:, None] - there[None], axis=2)
    assert np.abs(away - true).mean() < 0.015 * rear.full.length


def test_a_member_of_which_nothing_is_left_gives_no_pose(joined, union) -> None:
    gone = replace(joined, pieces={**joined.pieces, 2: joined.pieces[0]}, joins=[])
    surface = described_part(union.mesh, union.mesh.length)
    assert in_pose_of(replace(union, members=(0, 1, 2)), surface, 2, gone) is None


def not_asked(*_: Any) -> Any:
    """Neither as told nor across."""
    pytest.fail("only what both share is asked for here")


@dataclass
class Asked:
    """What was looked at and asked, without geometry, of pieces that are as likely as told.

    In the pose of a member the union is larger, by a tenth of its number if nothing is told.
    """

    chances: dict[int, float]
    larger: dict[int, float] = field(default_factory=dict)
    glances: list[tuple[int, int]] = field(default_factory=list)
    in_full: list[tuple[int, int]] = field(default_factory=list)

    def bent(self, union: Union, surface: DescribedSurface, member: int, growth: Growth) -> Union:
        size = union.mesh.length * (1.0 + self.larger.get(member, 0.1 * member))
        mesh = TriangleMesh(surface.mesh.vertices * size, surface.mesh.faces)
        others = (each for each in union.members if each != member)
        return replace(union, mesh=mesh, members=(member, *others))

    def glance(self, first: Union, second: Union) -> Any:
        self.glances.append((first.members[0], second.members[0]))
        return self.answer(second)

    def asked(self, first: Union, second: Union, meet: Any, growth: Growth) -> Join:
        self.in_full.append((first.members[0], second.members[0]))
        return Join(first, second, meet(first, second, None, None))

    def meet(self, first: Union, second: Union, known: Any, taken: Any) -> Any:
        return self.answer(second)

    def answer(self, second: Union) -> Any:
        nothing: Any = None
        chance = self.chances[second.members[0]]
        return Meeting(nothing, nothing, nothing, 1.0, chance, False, by_skin=chance)

    def of(self, union: Union, others: list[Union], evidence: Floats, growth: Growth) -> bool:
        ways = Asking(self.meet, self.glance, *[not_asked] * 5)
        return ask_in_poses([union, *others], evidence, ways, growth)


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> Asked:
    found = Asked({})
    monkeypatch.setattr(poses, "in_pose_of", found.bent)
    monkeypatch.setattr(poses, "asked", found.asked)
    monkeypatch.setattr(poses, "unless_strangers", lambda join, growth: join)
    return found


def test_what_looks_likely_at_a_glance_is_asked_and_nobody_twice(joined, asked) -> None:
    pieces = [Union.of_piece(joined.pieces[0].mesh, number) for number in range(4)]
    small = [replace(each, mesh=joined.pieces[1].mesh) for each in pieces]
    growth, evidence = Growth.begun(pieces), np.ones((4, 4))
    asked.chances = {2: 0.1, 3: 0.9}
    here = replace(pieces[0], members=(0, 1))
    assert asked.of(here, small[2:], evidence, growth)
    assert asked.glances == [(1, 2), (1, 3)]
    assert asked.in_full == [(1, 3)]
    # the odds of nine to one are those of two poses
    assert growth.chances == {((1, 0), (3,)): pytest.approx(4.5 / 5.5)}
    # a group that has grown is asked in the pose of who is new
    assert not asked.of(replace(here, members=(0, 1, 3)), small[2:3], evidence, growth)
    assert asked.glances[2:] == [(3, 2)]


def test_what_is_likely_in_one_of_many_poses_only_is_not(joined, asked) -> None:
    pieces = [Union.of_piece(joined.pieces[0].mesh, number) for number in range(5)]
    last = replace(pieces[-1], mesh=joined.pieces[1].mesh)
    asked.chances = {4: 0.7}
    growth = Growth.begun(pieces)
    # in each pose it is as likely, so it is asked in all of them, and the group's own is the fourth
    here = replace(pieces[0], members=(0, 1, 2, 3))
    assert not asked.of(here, [last], np.ones((5, 5)), growth)
    assert sorted(asked.in_full) == [(1, 4), (2, 4), (3, 4)]
    odds = 0.7 / 0.3 / 4
    assert growth.chances[(3, 0, 1, 2), (4,)] == pytest.approx(odds / (1 + odds))


def test_poses_that_are_alike_are_asked_once(joined, asked) -> None:
    pieces = [Union.of_piece(joined.pieces[0].mesh, number) for number in range(5)]
    last = replace(pieces[-1], mesh=joined.pieces[1].mesh)
    asked.chances = {4: 0.1}
    # the first member has the union's own pose, the last two have one
    asked.larger = {1: 0.001, 2: 0.2, 3: 0.201}
    here = replace(pieces[0], members=(0, 1, 2, 3))
    asked.of(here, [last], np.ones((5, 5)), Growth.begun(pieces))
    assert asked.glances == [(2, 4)]


def test_poses_are_those_of_which_evidence_says_most(joined, asked) -> None:
    count = poses.POSES + 3
    pieces = [Union.of_piece(joined.pieces[0].mesh, number) for number in range(count + 1)]
    last = replace(pieces[-1], mesh=joined.pieces[1].mesh)
    evidence = np.add.outer(np.arange(count + 1.0), np.arange(count + 1.0))
    asked.chances = {count: 0.1}
    here = replace(pieces[0], members=tuple(range(count)))
    asked.of(here, [last], evidence, Growth.begun(pieces))
    assert sorted(asked.glances) == [(count - poses.POSES + k, count) for k in range(poses.POSES)]
