"""Growth: the surest partner first, the union asked again, and what is foreign left alone."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from sherd.arrays import Bools, Ints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.puzzle.growing import asking, belonging, completion, growth, record
from sherd.puzzle.growing.asking import Asking
from sherd.puzzle.growing.growth import grow
from sherd.puzzle.growing.union import Join, Union

SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
FACES = [[0, 1, 2], [0, 2, 3]]


def pieces(count: int) -> list[Union]:
    """Squares, the first one the largest."""
    return [Union.of_piece(TriangleMesh(SQUARE * (2 - 0.1 * k), FACES), k) for k in range(count)]


@dataclass(frozen=True)
class Answer:
    """A meeting, as far as growth asks."""

    chance: float
    twin: bool = False
    by_skin: float = 0.0
    filling: float = 0.0
    in_gap: Answer | None = None
    recognized: float = 0.0
    at_large: float | None = None
    fills: bool = False
    elsewhere: bool = False


def no_twins(first: Union, second: Union) -> None:
    """Nothing lies across from anything."""


def no_part(first: Union, second: Union) -> float:
    """Nothing looks like a part of anything."""
    return 0.0


def unlike_mirrored(first: Union, second: Union) -> Answer:
    """No mirror image lies on anything."""
    return Answer(0.0)


def unlike(numbers: Collection[int], others: Collection[int]) -> float:
    """Nobody has the skin of anybody."""
    return 0.0


def ways(
    meet: Any,
    across: Any = no_twins,
    as_a_part: Any = no_part,
    mirrored: Any = unlike_mirrored,
    kinship: Any = unlike,
) -> Asking:
    """Members are not asked here."""
    return Asking(meet, meet, meet, across, as_a_part, mirrored, kinship)


def answer(chance: float, *, twin: bool = False, by_skin: float = 0.0, filling: float = 0.0) -> Any:
    return Answer(chance, twin, by_skin, filling)


@pytest.fixture(autouse=True)
def _joined_without_geometry(monkeypatch: pytest.MonkeyPatch) -> None:
    def stand_in(join: Join) -> Union:
        here, there = join.first, join.second
        return Union(here.mesh, here.owner, here.places, (*here.members, *there.members))

    for room in (growth, completion):
        monkeypatch.setattr(room, "united", stand_in)
    for name in ("ask_members", "told_by_members"):
        monkeypatch.setattr(growth, name, lambda *_: None)
    monkeypatch.setattr(growth, "ask_in_poses", lambda *_: False)
    monkeypatch.setattr(growth, "open_loop", lambda joins: np.inf)
    monkeypatch.setattr(growth, "laid_alike", lambda one, other: np.empty((0, 2), dtype=np.int64))
    for room in (asking, completion):
        monkeypatch.setattr(room, "recalled", lambda join, first, second: np.array([[7, 7]]))
        leave_out(monkeypatch, room, lambda before, join: 0.0)
    monkeypatch.setattr(completion, "is_within", lambda join: False)
    # nobody belongs by what is half likely, but where that is asked
    monkeypatch.setattr(belonging, "is_within", lambda join: True)
    monkeypatch.setattr(completion, "laid_as_before", lambda *_: None)
    for room in (growth, asking, record):
        monkeypatch.setattr(room, "taken_by", lambda join, union: np.array([True]))
    crowd(monkeypatch, lambda one, other: 0.0)
    monkeypatch.setattr(asking, "common_area", lambda join: join.first.mesh.area)


def crowd(monkeypatch: pytest.MonkeyPatch, crowding: Callable[[Join, Join], float]) -> None:
    """Places of one size: who lies in another one's has it."""
    for room in (growth, record):
        monkeypatch.setattr(room, "crowding", crowding)
    for room in (record, completion):
        monkeypatch.setattr(room, "lying_in", crowding)


def leave_out(
    monkeypatch: pytest.MonkeyPatch, room: Any, share: Callable[[Join, Join], float]
) -> None:
    monkeypatch.setattr(room, "left_out", share)


def grown(some: list[Union], evidence: Any, asked: Asking) -> record.Growth:
    """All that came of it."""
    found = record.Growth.begun(some)
    grow(found, evidence, asked)
    return found


def test_a_chain_is_joined_and_what_is_foreign_stays_alone() -> None:
    asked = []

    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        asked.append((first.members, second.members))
        near = any(abs(i - j) == 1 for i in first.members for j in second.members)
        return answer(0.9 if near and 4 not in second.members else 0.1)

    found = grown(pieces(5), np.ones((5, 5)), ways(meet))
    assert sorted(map(sorted, found.groups)) == [[0, 1, 2, 3], [4]]
    assert [join.second.members for join in found.joins] == [(1,), (2,), (3,)]
    assert len(set(asked)) == len(asked)
    assert set(found.chances) == set(asked)


def test_who_grew_still_lies_beside_whom_a_part_of_it_lay_beside() -> None:
    one, other, third = pieces(3)
    known = record.Growth.begun([one, other, third])
    known.together.append((other.members, third.members))
    grew = Union(other.mesh, other.owner, other.places, (1, 7))
    assert known.are_together(third, grew)
    assert known.are_together(grew, third)
    assert not known.are_together(one, third)


def test_a_twin_that_a_small_union_would_take_is_asked_again_first(monkeypatch) -> None:
    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        # alone 0 takes 2 for its own, but less surely than 1; with 1 it lies elsewhere
        chance = {1: 0.95, 2: 0.9 if first.members == (0,) else 0.1}[second.members[0]]
        return answer(chance)

    leave_out(monkeypatch, completion, lambda before, join: 1.0)
    found = grown(pieces(3), np.ones((3, 3)), ways(meet))
    assert sorted(map(sorted, found.groups)) == [[0, 1], [2]]


def test_of_many_others_only_those_with_most_evidence_are_asked() -> None:
    asked = []

    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        asked.append((first.members[0], second.members[0]))
        return answer(0.0)

    evidence = np.zeros((14, 14))
    evidence[0] = evidence[:, 0] = np.arange(14)
    grown(pieces(14), evidence, ways(meet))
    assert {b for a, b in asked[: growth.PARTNERS] if a == 0} == set(range(6, 14))


def test_groups_that_both_grew_are_joined_at_last() -> None:
    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        members = {*first.members, *second.members}
        sure = members in ({0, 1}, {2, 3}, {0, 1, 2, 3})
        return answer(0.9 if sure else 0.0)

    found = grown(pieces(4), np.ones((4, 4)), ways(meet))
    assert sorted(map(sorted, found.groups)) == [[0, 1, 2, 3]]


def test_what_joined_a_group_before_does_not_dispute_what_the_group_says(monkeypatch) -> None:
    """2 and 3 are joined after 0 and 1; they lie where 1 does on 0, as all overlap there."""
    crowd(monkeypatch, lambda one, other: 0.9)
    asked = []

    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        asked.append((first.members, second.members))
        sure = {*first.members, *second.members} in ({0, 1}, {2, 3}, {0, 1, 2, 3})
        return answer(0.9 if sure else 0.0)

    found = grown(pieces(4), np.ones((4, 4)), ways(meet))
    assert sorted(map(sorted, found.groups)) == [[0, 1, 2, 3]]
    assert not found.last
    assert not any(set(first) & set(second) for first, second in asked)


def test_who_lost_a_place_has_lost_it_for_those_who_join_it(monkeypatch) -> None:
    crowd(monkeypatch, lambda one, other: 0.9)
    one, other, third = pieces(3)
    place = Join(one, other, Answer(0.9))
    grew = Union(third.mesh, third.owner, third.places, (2, 7))
    assert record.laid_there(Join(one, grew, Answer(0.9)), place, (2,))
    assert not record.laid_there(Join(one, grew, Answer(0.9)), place, (5,))


def test_a_place_that_follows_from_two_likely_ones_is_as_likely_as_the_less_likely_one() -> None:
    one, other, third = pieces(3)
    grew = Union(other.mesh, other.owner, other.places, (1, 2))
    known = record.Growth.begun([one, other, third])
    known.last = [Join(other, third, Answer(0.55)), Join(one, grew, Answer(0.76))]
    assert known.last_chances() == {1: 0.76, 2: 0.55}


def test_what_was_sure_before_is_recalled_where_a_twin_draws_it_away() -> None:
    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        if second.members == (1,):
            return answer(0.95)
        sure = first.members == (0,) or len(known) == 1
        return answer(0.8 if sure else 0.1)

    found = grown(pieces(3), np.ones((3, 3)), ways(meet))
    assert sorted(map(sorted, found.groups)) == [[0, 1, 2]]


@pytest.mark.parametrize(
    ("there", "again", "joined"), [(0.9, 0.7, True), (0.0, 0.7, False), (0.9, 0.4, False)]
)
def test_what_is_likely_where_it_surely_lay_is_joined(there, again, joined, monkeypatch) -> None:
    """`there` is the share of its place that it had before, `again` its chance there."""

    def crowding(one: Join, other: Join) -> float:
        return there if one.second.members == other.second.members else 0.0

    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        return answer({1: 0.95, 2: 0.9 if first.members == (0,) else again}[second.members[0]])

    crowd(monkeypatch, crowding)
    leave_out(monkeypatch, completion, lambda before, join: 1.0)
    found = grown(pieces(3), np.ones((3, 3)), ways(meet))
    assert (len(found.groups) == 1) == joined
    if joined:
        assert again < found.joins[-1].met.chance < 0.9


def test_of_two_in_one_place_neither_is_joined_unless_one_is_far_surer(monkeypatch) -> None:
    crowd(monkeypatch, lambda one, other: 0.9)

    def meet(surer: float) -> Any:
        def asked(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
            there = first.members == (0,) and taken is None
            return answer({1: surer, 2: 0.8}[second.members[0]] if there else 0.1)

        return asked

    close = grown(pieces(3), np.ones((3, 3)), ways(meet(0.85)))
    assert sorted(map(sorted, close.groups)) == [[0], [1], [2]]
    clear = grown(pieces(3), np.ones((3, 3)), ways(meet(0.97)))
    assert [join.second.members for join in clear.joins] == [(1,), (2,)]
    # that both are right is as likely then as that pieces overlap: 4 (0.26 32 + 1) : (32 + 1)
    assert [join.met.chance for join in clear.last] == [pytest.approx(0.53, abs=0.01)]


def crowd_in_two_places(monkeypatch: pytest.MonkeyPatch) -> None:
    """All lie in one place, but for those that were found elsewhere."""
    crowd(monkeypatch, lambda one, other: 0.9 * (one.met.elsewhere == other.met.elsewhere))


def test_a_twin_in_the_place_of_another_is_asked_elsewhere_and_both_are_joined(monkeypatch) -> None:
    crowd_in_two_places(monkeypatch)
    asked = []

    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        asked.append((first.members, second.members, taken is not None))
        # 1 lies where 2 belongs, and elsewhere as surely; 2 lies nowhere else
        here, elsewhere = {1: (0.9, 0.9), 2: (0.8, 0.05)}[second.members[0]]
        return answer(here) if taken is None else Answer(elsewhere, elsewhere=True)

    found = grown(pieces(3), np.ones((3, 3)), ways(meet))
    assert [join.second.members for join in found.joins] == [(2,), (1,)]
    assert [join.met.chance for join in found.joins] == [0.8, 0.9]
    assert asked[-1] == ((0, 2), (1,), True)


@pytest.mark.parametrize(("again", "joined"), [(0.65, [1, 2]), (0.3, [])])
def test_who_is_asked_elsewhere_and_lies_there_still_overlaps_the_other(
    again, joined, monkeypatch
) -> None:
    """A leg and a flank that share the hip; without that the leg is found by what is below it."""
    crowd_in_two_places(monkeypatch)

    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        if first.members == (1,):
            return answer(0.02)
        here = {1: 0.87, 2: 0.8}[second.members[0]]
        return answer(here if taken is None else {1: again, 2: 0.01}[second.members[0]])

    found = grown(pieces(3), np.ones((3, 3)), ways(meet))
    assert [join.second.members[0] for join in found.joins] == joined


def test_two_that_overlap_in_one_place_are_both_joined_where_the_loop_closes(monkeypatch) -> None:
    crowd(monkeypatch, lambda one, other: 0.9)
    monkeypatch.setattr(growth, "open_loop", lambda joins: 0.01 if len(joins) == 3 else np.inf)
    taken_before = []

    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        taken_before.append(taken is not None)
        return answer({1: 0.85, 2: 0.8}[second.members[0]])

    found = grown(pieces(3), np.ones((3, 3)), ways(meet))
    assert sorted(map(sorted, found.groups)) == [[0, 1, 2]]
    assert not any(taken_before)


@pytest.mark.parametrize(
    ("by_skin", "back", "joined"), [(0.7, 0.01, 3), (0.3, 0.01, 1), (0.7, 0.1, 1)]
)
def test_two_in_one_place_are_both_joined_where_they_show_the_same_skin_there(
    by_skin, back, joined, monkeypatch
) -> None:
    """By themselves they are laid elsewhere on each other; what a third one says of both is asked.

    `back` is how far off one comes back around the three.
    """
    pairs = np.array([[3, 5]])
    crowd(monkeypatch, lambda one, other: 0.9)
    monkeypatch.setattr(growth, "open_loop", lambda joins: back if len(joins) == 3 else np.inf)
    monkeypatch.setattr(growth, "laid_alike", lambda one, other: pairs)
    asked = []

    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        if first.members == (1,):
            asked.append(len(known))
            return answer(0.1, by_skin=by_skin if len(known) else 0.0)
        return answer({1: 0.85, 2: 0.8}[second.members[0]] if taken is None else 0.1)

    found = grown(pieces(3), np.ones((3, 3)), ways(meet))
    assert max(map(len, found.groups)) == joined
    assert asked[:2] == [0, 1]


def test_what_is_laid_on_its_twin_is_asked_elsewhere_each_time() -> None:
    asked = []

    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        asked.append((first.members, second.members, taken is not None))
        if second.members == (1,):
            return answer(0.95)
        # on its twin, elsewhere in doubt, and sure once the other piece is there
        return answer(0.8 if len(first.members) == 2 else 0.5) if taken is not None else mirror

    mirror = answer(0.15, twin=True)
    found = grown(pieces(3), np.ones((3, 3)), ways(meet))
    assert sorted(map(sorted, found.groups)) == [[0, 1, 2]]
    assert [each for each in asked if each[1] == (2,)] == [
        ((0,), (2,), False),
        ((0,), (2,), True),
        ((0, 1), (2,), False),
        ((0, 1), (2,), True),
    ]


def test_what_only_looks_like_a_twin_may_be_laid_there_again() -> None:
    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        if second.members == (1,):
            return answer(0.95)
        if taken is not None:
            return answer(0.1)
        return answer(0.9) if len(first.members) == 2 else answer(0.4, twin=True)

    found = grown(pieces(3), np.ones((3, 3)), ways(meet))
    assert sorted(map(sorted, found.groups)) == [[0, 1, 2]]


@pytest.mark.parametrize(
    ("again", "left", "joined"), [(0.7, 1.0, 2), (0.7, 0.0, 3), (0.98, 1.0, 3)]
)
def test_what_leaves_out_what_was_likely_is_contradicted_by_it(
    again, left, joined, monkeypatch
) -> None:
    """2 likely lies on 0; on the union of 0 and 1 it surely lies elsewhere, or there as well.

    `again` is the chance of the earlier place, asked once more, `left` the share that is left out.
    """
    asked = []

    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        if second.members == (1,):
            return answer(0.95)
        if len(first.members) == 1:
            return answer(0.6)
        asked.append(len(known))
        return answer(again if len(known) else 0.9)

    def elsewhere(join: Join) -> bool:
        return 0.7 < join.met.chance <= 0.9

    def left_out(before: Join, join: Join) -> float:
        return left if elsewhere(before) != elsewhere(join) else 0.0

    for room in (asking, completion):
        leave_out(monkeypatch, room, left_out)
    found = grown(pieces(3), np.ones((3, 3)), ways(meet))
    assert max(map(len, found.groups)) == joined
    # what is not joined is asked once more at last
    assert asked == ([0, 1] if left else [0]) + [1] * (joined == 2)


def test_what_was_likely_is_asked_again_where_the_union_finds_nothing(monkeypatch) -> None:
    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        if second.members == (1,):
            return answer(0.95)
        return answer(0.6 if len(first.members) == 1 else 0.9 if len(known) else 0.0)

    monkeypatch.setattr(asking, "left_out", lambda before, join: float(join.met.chance == 0.0))
    found = grown(pieces(3), np.ones((3, 3)), ways(meet))
    assert sorted(map(sorted, found.groups)) == [[0, 1, 2]]


def likely(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
    """1 surely belongs to 0, and 2 likely, as 0 says; the group sees less of it."""
    if second.members == (1,):
        return answer(0.95)
    return answer(0.6 if first.members == (0,) else 0.2)


@pytest.mark.parametrize(
    ("left", "within", "joined"), [(0.0, False, 3), (1.0, False, 2), (0.0, True, 2)]
)
def test_what_is_likely_is_joined_at_last_if_the_group_lies_there(
    left, within, joined, monkeypatch
) -> None:
    leave_out(monkeypatch, completion, lambda before, join: left)
    monkeypatch.setattr(completion, "is_within", lambda join: within)
    found = grown(pieces(3), np.ones((3, 3)), ways(likely))
    assert max(map(len, found.groups)) == joined
    assert [join.met.chance for join in found.last] == [0.6] * (joined - 2)


@pytest.mark.parametrize(
    ("by_skin", "twin", "joined"), [(0.6, False, 3), (0.4, False, 2), (0.6, True, 3)]
)
def test_at_last_the_skin_alone_makes_an_answer_likely(by_skin, twin, joined) -> None:
    """Also where labels fit the mirror image better: the skin says that it is not mirrored."""

    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        if second.members == (1,):
            return answer(0.95)
        return answer(0.1, by_skin=by_skin, twin=twin)

    found = grown(pieces(3), np.ones((3, 3)), ways(meet))
    assert max(map(len, found.groups)) == joined
    assert [join.met.chance for join in found.last] == [by_skin] * (joined - 2)


@pytest.mark.parametrize(("its", "joined"), [(0.2, 3), (0.8, 2)])
def test_what_is_likely_may_have_a_joined_piece_in_a_part_of_its_place(
    its, joined, monkeypatch
) -> None:
    """`its` is the share of the place of 2 that 1 has, which lies in it as a whole."""
    crowd(monkeypatch, lambda one, other: 0.8)
    for room in (record, completion):
        monkeypatch.setattr(
            room, "lying_in", lambda one, other: its if one.second.members == (2,) else 0.8
        )
    found = grown(pieces(3), np.ones((3, 3)), ways(likely))
    assert max(map(len, found.groups)) == joined


def test_what_the_completed_group_is_sure_of_is_no_surer_than_what_completed_it() -> None:
    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        if second.members == (1,):
            return answer(0.95)
        if second.members == (2,):
            return answer(0.6)
        return answer(0.9 if set(first.members) == {0, 1, 2} else 0.1)

    found = grown(pieces(4), np.ones((4, 4)), ways(meet))
    assert sorted(map(sorted, found.groups)) == [[0, 1, 2, 3]]
    assert [(join.second.members, join.met.chance) for join in found.last] == [
        ((2,), 0.6),
        ((3,), 0.6),
    ]


@pytest.mark.parametrize(
    ("filling", "fills", "joined"), [(0.6, True, 3), (0.6, False, 2), (0.4, True, 2)]
)
def test_at_last_what_fills_a_gap_is_laid_there(filling, fills, joined, monkeypatch) -> None:
    """Though it was not likely, and the group does not find it."""

    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        if second.members == (1,):
            return answer(0.95)
        return answer(0.1, filling=filling if first.members == (0,) else 0.0)

    def laid_as_before(before: Join, first: Union, second: Union, *_: Any) -> Join:
        assert before.met.chance == filling
        return Join(first, second, before.met)

    monkeypatch.setattr(completion, "laid_as_before", laid_as_before)
    monkeypatch.setattr(completion, "_fills_a_gap", lambda join: fills)
    found = grown(pieces(3), np.ones((3, 3)), ways(meet))
    assert max(map(len, found.groups)) == joined
    assert [join.met.chance for join in found.last] == [filling] * (joined - 2)


def test_of_two_that_fill_one_gap_none_is_laid_there(monkeypatch) -> None:
    crowd(monkeypatch, lambda one, other: 0.9)

    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        alone = first.members == (0,) and second.members in ((1,), (2,))
        return answer(0.1, filling=0.6 if alone else 0.0)

    monkeypatch.setattr(completion, "_fills_a_gap", lambda join: True)
    found = grown(pieces(3), np.ones((3, 3)), ways(meet))
    assert not found.last


def test_nothing_likely_is_joined_where_another_one_likely_lies(monkeypatch) -> None:
    crowd(monkeypatch, lambda one, other: 0.9)

    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        alone = first.members == (0,) and second.members in ((1,), (2,))
        return answer(0.6 if alone else 0.0)

    found = grown(pieces(3), np.ones((3, 3)), ways(meet))
    assert len(found.groups) == 3
    assert not found.last


def only_a_pair(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
    """The first two belong together, and nothing else does."""
    return answer(0.9 if {*first.members, *second.members} == {0, 1} else 0.0)


def test_who_is_alone_is_asked_at_last_whether_the_largest_group_has_its_twin() -> None:
    asked = []

    def across(first: Union, second: Union) -> Any:
        asked.append((first.members, second.members))
        # what 3 is the twin of has to be joined first
        chance = {2: 0.7, 3: 0.6 if 2 in first.members else 0.4, 4: 0.0}[second.members[0]]
        return answer(chance) if chance else None

    found = grown(pieces(5), np.ones((5, 5)), ways(only_a_pair, across))
    assert sorted(map(sorted, found.groups)) == [[0, 1, 2, 3], [4]]
    assert [join.met.chance for join in found.last] == [0.7, 0.6]
    assert found.joins[1:] == found.last == found.across
    assert found.chances[(0, 1, 2), (3,)] == 0.6
    assert sorted(asked[3:5]) == [((0, 1, 2), (3,)), ((0, 1, 2), (4,))]
    assert asked[5:] == [((0, 1, 2, 3), (4,))]


def test_two_that_lie_across_from_one_twin_contradict_each_other(monkeypatch) -> None:
    def across(first: Union, second: Union) -> Any:
        return answer(0.7 if second.members == (2,) else 0.6)

    crowd(monkeypatch, lambda one, other: 1.0)
    found = grown(pieces(4), np.ones((4, 4)), ways(only_a_pair, across))
    assert sorted(map(sorted, found.groups)) == [[0, 1], [2], [3]]


def test_a_single_piece_is_not_asked_for_twins() -> None:
    def nothing(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        return answer(0.0)

    def across(first: Union, second: Union) -> Any:
        raise AssertionError("asked for a twin")

    assert len(grown(pieces(3), np.ones((3, 3)), ways(nothing, across)).groups) == 3


@pytest.mark.parametrize(("share", "groups"), [(0.1, [[0], [1, 2]]), (0.04, [[0], [1], [2]])])
def test_strangers_to_the_largest_piece_are_joined_by_much_only(share, groups, monkeypatch) -> None:
    """Not at last either, when what is likely is joined."""

    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        return answer(0.9 if 0 not in (*first.members, *second.members) else 0.0)

    some = pieces(3)
    monkeypatch.setattr(asking, "common_area", lambda join: share * some[0].mesh.area)
    found = grown(some, np.ones((3, 3)), ways(meet))
    assert sorted(map(sorted, found.groups)) == groups


def test_a_larger_piece_of_something_else_hides_nothing(monkeypatch) -> None:
    """What belongs together is asked as if it were not there, and the last stages, too."""
    some = [
        Union.of_piece(TriangleMesh(SQUARE * size, FACES), number)
        for number, size in enumerate((2.0, 1.9, 9.0, 1.8))
    ]
    asked, wholes = [], []

    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        wholes.append(begun.length_of_whole)
        return answer(0.9 if (first.members, second.members) == ((0,), (1,)) else 0.0)

    def across(first: Union, second: Union) -> Any:
        asked.append(first.members)

    # a tenth of the largest of them, 0.005 of the one that is larger
    monkeypatch.setattr(asking, "common_area", lambda join: 0.1 * some[0].mesh.area)
    begun = record.Growth.begun(some)
    grow(begun, np.ones((4, 4)), ways(meet, across))
    assert sorted(map(sorted, begun.groups)) == [[0, 1], [2], [3]]
    assert begun.root is some[0]
    assert asked == [(0, 1), (0, 1)]
    alone = record.Growth.begun([some[0], some[1], some[3]]).length_of_whole
    assert wholes[0] >= 9.0
    assert wholes[-1] == alone


@pytest.mark.parametrize(
    ("enough", "groups"), [((1,), [[0, 1, 3], [2]]), ((), [[0], [1], [2], [3]])]
)
def test_what_shares_little_with_the_next_root_is_joined_if_another_shares_enough(
    enough, groups, monkeypatch
) -> None:
    some = [
        Union.of_piece(TriangleMesh(SQUARE * size, FACES), number)
        for number, size in enumerate((2.0, 1.9, 9.0, 1.8))
    ]

    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        return answer(0.9 if 0 in first.members else 0.0)

    def area(join: Join) -> float:
        return (0.1 if join.second.members == enough else 0.04) * some[0].mesh.area

    monkeypatch.setattr(asking, "common_area", area)
    found = grown(some, np.ones((4, 4)), ways(meet))
    assert sorted(map(sorted, found.groups)) == groups
    assert not found.last
    assert bool(found.sure) == bool(enough)


@pytest.mark.parametrize(("shared", "groups"), [(0.1, [[0, 1], [2, 3, 4]]), (0.04, [[0, 1]])])
def test_a_second_group_has_a_root_as_well(shared, groups, monkeypatch) -> None:
    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        both = {first.members[0], second.members[0]}
        return answer(0.9 if both in ({0, 1}, {2, 3}, {2, 4}) else 0.0)

    some = pieces(5)

    def area(join: Join) -> float:
        return (shared if join.second.members == (3,) else 0.04) * some[0].mesh.area

    monkeypatch.setattr(asking, "common_area", area)
    found = grown(some, np.ones((5, 5)), ways(meet))
    assert sorted(sorted(group) for group in found.groups if len(group) > 1) == groups
    assert found.roots == {group[0] for group in groups}


def test_a_stranger_that_is_not_believed_of_another_joins_who_is_next(monkeypatch) -> None:
    """Of many pieces the group has not asked it, but it asks the group."""

    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        pairs = {((0,), (1,)): 0.9, ((0, 1), (2,)): 0.8, ((2,), (3,)): 0.95}
        return answer(pairs.get((first.members, second.members), 0.0))

    evidence = np.ones((11, 11))
    evidence[2] = evidence[:, 2] = 0.1
    for other in (0, 3):
        evidence[2, other] = evidence[other, 2] = 0.5
    some = pieces(11)
    monkeypatch.setattr(asking, "common_area", lambda join: 0.04 * some[0].mesh.area)
    found = grown(some, evidence, ways(meet))
    assert [sorted(group) for group in found.groups if len(group) > 1] == [[0, 1, 2]]
    assert not found.last


def test_where_nothing_is_sure_the_largest_piece_is_the_root() -> None:
    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        return answer(0.0)

    found = grown(pieces(4), np.ones((4, 4)), ways(meet))
    assert found.root is found.largest is found.pieces[0]


def test_where_unions_find_nothing_their_members_are_asked(monkeypatch) -> None:
    # 2 belongs to 1, which 0 has joined, but 0 and 1 find nothing
    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        return answer(0.9 if (first.members, second.members) == ((0,), (1,)) else 0.1)

    def by_members(first: Union, second: Union, *_: Any) -> Join | None:
        both = {first.members, second.members} == {(0, 1), (2,)}
        return Join(first, second, answer(0.8)) if both else None

    monkeypatch.setattr(growth, "told_by_members", by_members)
    found = grown(pieces(4), np.ones((4, 4)), ways(meet))
    assert sorted(map(sorted, found.groups)) == [[0, 1, 2], [3]]
    assert found.chances[(0, 1), (2,)] == 0.8
    assert not found.last


def test_of_two_that_members_lay_on_one_place_as_surely_neither_has_it(monkeypatch) -> None:
    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        return answer(0.9 if (first.members, second.members) == ((0,), (1,)) else 0.1)

    def by_members(first: Union, second: Union, *_: Any) -> Join | None:
        return Join(first, second, answer(0.8)) if first.members == (0, 1) else None

    monkeypatch.setattr(growth, "told_by_members", by_members)
    crowd(monkeypatch, lambda one, other: 1.0)
    found = grown(pieces(4), np.ones((4, 4)), ways(meet))
    assert [join.met.chance for join in found.joins] == [0.9]


def fills_a_gap(*members: int) -> Any:
    """0 and 1 belong together; others are found nowhere, but these fill a gap of what has 0."""

    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        if second.members == (1,):
            return answer(0.9)
        filling = 0 in first.members and second.members[0] in members
        return Answer(0.1, in_gap=Answer(0.1) if filling else None)

    return meet


def test_what_fills_a_gap_of_the_largest_group_belongs_to_it_without_a_place() -> None:
    found = grown(pieces(4), np.ones((4, 4)), ways(fills_a_gap(2)))
    assert sorted(map(sorted, found.groups)) == [[0, 1, 2], [3]]
    assert found.unplaced == [2]
    assert [join.second.members for join in found.joins] == [(1,)]


def test_unless_two_claim_that_gap_or_it_was_filled(monkeypatch) -> None:
    crowd(monkeypatch, lambda one, other: float({2, 3} >= {one.second.members[0]}))
    found = grown(pieces(4), np.ones((4, 4)), ways(fills_a_gap(2, 3)))
    assert not found.unplaced
    crowd(monkeypatch, lambda one, other: float(other.second.members == (1,)))
    found = grown(pieces(4), np.ones((4, 4)), ways(fills_a_gap(2)))
    assert not found.unplaced


def test_what_fills_a_gap_of_a_single_piece_is_alone() -> None:
    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        return Answer(0.1, in_gap=Answer(0.1))

    found = grown(pieces(2), np.ones((2, 2)), ways(meet))
    assert sorted(found.groups) == [(0,), (1,)]
    assert not found.unplaced


@pytest.mark.parametrize(("chance", "unplaced"), [(0.49, []), (0.51, [3])])
def test_what_looks_like_a_part_of_the_largest_group_belongs_to_it(chance, unplaced) -> None:
    asked = []

    def as_a_part(first: Union, second: Union) -> float:
        asked.append((first.members, second.members))
        return chance if second.members == (3,) else 0.1

    some = pieces(3)
    for number, size in ((3, 1.0), (4, 1.2)):  # a fourth of the largest, and too large for a part
        some.append(Union.of_piece(TriangleMesh(SQUARE * size, FACES), number))
    found = grown(some, np.ones((5, 5)), ways(fills_a_gap(2), as_a_part=as_a_part))
    assert found.unplaced == [2, *unplaced]
    # who fills a gap belongs already
    assert asked == [((0, 1), (3,))]


@pytest.mark.parametrize(
    ("chance", "at_large", "unplaced"),
    [(0.39, None, []), (0.41, None, [2]), (0.49, 0.33, [2]), (0.49, 0.31, []), (0.39, 0.9, [])],
)
def test_what_is_half_likely_somewhere_belongs_without_a_place(
    chance, at_large, unplaced, monkeypatch
) -> None:
    """Of both units in mean, but no likelier than in their own."""

    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        if second.members == (1,):
            return answer(0.95)
        once = (first.members, second.members) == ((0,), (2,))
        return Answer(0.1, by_skin=chance, at_large=at_large) if once else answer(0.1)

    monkeypatch.setattr(belonging, "is_within", lambda join: False)
    found = grown(pieces(4), np.ones((4, 4)), ways(meet))
    assert found.unplaced == unplaced
    assert [3] in map(list, found.groups)


def test_so_does_what_is_half_likely_on_who_belongs_so(monkeypatch) -> None:
    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        pair = (first.members, second.members)
        return answer({((0,), (1,)): 0.95, ((0,), (3,)): 0.45, ((2,), (3,)): 0.45}.get(pair, 0.1))

    monkeypatch.setattr(belonging, "is_within", lambda join: False)
    found = grown(pieces(5), np.ones((5, 5)), ways(meet))
    assert found.unplaced == [3, 2]
    assert sorted(map(sorted, found.groups)) == [[0, 1, 2, 3], [4]]


@pytest.mark.parametrize(("share", "unplaced"), [(0.017, []), (0.02, [2])])
def test_whose_skin_is_recognized_belongs_without_a_place(share, unplaced) -> None:
    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        if second.members == (1,):
            return answer(0.95)
        once = (first.members, second.members) == ((0,), (2,))
        return Answer(0.1, recognized=share * pieces(1)[0].mesh.area if once else 0.0)

    found = grown(pieces(4), np.ones((4, 4)), ways(meet))
    assert found.unplaced == unplaced
    assert [3] in map(list, found.groups)


@pytest.mark.parametrize(
    ("image", "belongs"),
    [
        (Answer(0.9, by_skin=0.9), False),
        (Answer(0.1, recognized=0.02 * 4.0), True),
        (Answer(0.1, recognized=0.017 * 4.0), False),
        (Answer(0.1, fills=True), True),
    ],
)
def test_so_does_what_fills_a_gap_or_is_recognized_mirrored(image, belongs) -> None:
    """As a tail does that bends to the left where the group bends to the right."""
    asked = []

    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        return answer(0.95 if second.members == (1,) else 0.1)

    def mirrored(first: Union, second: Union) -> Answer:
        asked.append((first.members, second.members))
        return image if second.members == (2,) else Answer(0.1)

    found = grown(pieces(4), np.ones((4, 4)), ways(meet, mirrored=mirrored))
    assert found.unplaced == [2] * belongs
    assert [3] in map(list, found.groups)
    assert asked == [((0, 1), (2,)), ((0, 1), (3,))]


def test_what_lies_within_or_is_a_group_of_its_own_does_not(monkeypatch) -> None:
    def within(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        return answer(0.95 if second.members == (1,) else 0.45)

    assert not grown(pieces(3), np.ones((3, 3)), ways(within)).unplaced

    def two_groups(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        pair = {*first.members, *second.members}
        return answer(0.95 if pair in ({0, 1}, {2, 3}) else 0.45)

    monkeypatch.setattr(belonging, "is_within", lambda join: False)
    found = grown(pieces(4), np.ones((4, 4)), ways(two_groups))
    assert sorted(map(sorted, found.groups)) == [[0, 1], [2, 3]]
    assert not found.unplaced


def test_nothing_is_a_part_of_a_single_piece() -> None:
    def nothing(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        return answer(0.1)

    def as_a_part(first: Union, second: Union) -> float:
        raise AssertionError("a single piece is no whole")

    found = grown(pieces(2), np.ones((2, 2)), ways(nothing, as_a_part=as_a_part))
    assert not found.unplaced


@pytest.mark.parametrize(("kin", "unplaced"), [(0.15, []), (0.17, [2, 3])])
def test_who_has_the_skin_of_a_group_belongs_to_it(kin, unplaced) -> None:
    """Or that of who belongs so; and then nobody is asked whether it looks like a part."""
    as_parts = []

    def kinship(numbers: Collection[int], others: Collection[int]) -> float:
        return kin if (*numbers, 0) == (2, *others[:1]) or (*numbers, others[-1]) == (3, 2) else 0.1

    def as_a_part(first: Union, second: Union) -> float:
        as_parts.extend(second.members)
        return 0.1

    some = pieces(3)
    some += [Union.of_piece(TriangleMesh(SQUARE * 0.5, FACES), number) for number in (3, 4)]
    found = grown(some, np.ones((5, 5)), ways(only_a_pair, kinship=kinship, as_a_part=as_a_part))
    assert found.unplaced == unplaced
    assert [4] in map(list, found.groups)
    assert not {*as_parts} & {*unplaced}


def test_who_has_the_skin_of_another_group_belongs_to_that() -> None:
    def meet(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        pair = (first.members, second.members)
        return answer(0.95 if pair in (((0,), (1,)), ((2,), (3,))) else 0.1)

    def kinship(numbers: Collection[int], others: Collection[int]) -> float:
        return 0.2 if (*numbers,) == (4,) and 2 in others else 0.1

    found = grown(pieces(6), np.ones((6, 6)), ways(meet, kinship=kinship))
    assert sorted(map(sorted, found.groups)) == [[0, 1], [2, 3, 4], [5]]
    assert found.unplaced == [4]


def test_who_has_the_skin_of_a_single_piece_belongs_to_it() -> None:
    def nothing(first: Union, second: Union, known: Ints, taken: Bools | None) -> Any:
        return answer(0.1)

    def kinship(numbers: Collection[int], others: Collection[int]) -> float:
        return 0.2 if {*numbers, *others} == {0, 2} else 0.1

    found = grown(pieces(3), np.ones((3, 3)), ways(nothing, kinship=kinship))
    assert sorted(map(sorted, found.groups)) == [[0, 2], [1]]
    assert found.unplaced == [2]


def test_what_was_recalled_of_two_is_asked_once() -> None:
    first, second, third = pieces(3)
    known, free = np.array([[0, 1]]), np.zeros(4, dtype=bool)
    count = []
    meet = asking.remembering(lambda *_: count.append(1) or len(count))
    assert meet(first, second, known, None) == 1
    assert meet(first, second, known.copy(), None) == 1
    assert meet(first, second, known, free) == 2
    assert meet(first, second, known, free.copy()) == 2
    assert meet(first, third, known, None) == 3
    assert meet(first, second, known[::-1, ::-1], None) == 4
    # growth itself asks nothing else twice
    nothing = known[:0]
    assert meet(first, second, nothing, None) == 5
    assert meet(first, second, nothing, None) == 6
    assert meet(first, second, known, None) == 1
