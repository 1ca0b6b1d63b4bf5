"""Asking what two surfaces share: what is not sure has an answer, too."""

from __future__ import annotations

from dataclasses import replace
from functools import cache, lru_cache
from typing import Any

import numpy as np
import pytest

from sherd.correspondence.confidence import LEAST
from sherd.correspondence.labels.two_way import Both
from sherd.correspondence.shared.judgment import shared_area, shared_confidence
from sherd.correspondence.shared.two_way_placement import SharedPlacement, first_look
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.puzzle.pairwise import meeting as module
from sherd.puzzle.pairwise.answer import LIKELY, Meeting, likelier
from sherd.puzzle.pairwise.meeting import PairQuestion, pair_question
from sherd.puzzle.pairwise.skin_chance import SlidChance
from sherd.results.advice import SURE
from sherd.shapes import creature, cut_by_ball, landmarks, puzzle_pieces, whole
from sherd.surface.prepared import described_part


def bumpy_tube() -> TriangleMesh:
    u, v = np.meshgrid(np.arange(30) * 2 * np.pi / 30, np.linspace(0, 4, 30), indexing="ij")
    radius = 0.5 + 0.1 * np.cos(3 * u + 2 * v)
    points = np.stack([radius * np.cos(u), radius * np.sin(u), v], axis=2).reshape(-1, 3)
    number = np.arange(900).reshape(30, 30)
    right = np.roll(number, -1, axis=0)
    corners = number[:, :-1], right[:, :-1], right[:, 1:], number[:, 1:]
    halves = ((0, 1, 2), (0, 2, 3))
    faces = [np.stack([corners[i] for i in half], axis=2).reshape(-1, 3) for half in halves]
    return TriangleMesh(points, np.concatenate(faces), name="tube")


described_once = lru_cache(described_part)


@cache
def front_and_back() -> tuple[TriangleMesh, TriangleMesh]:
    full = creature(5000)
    ends = (landmarks(full)[name] for name in ("nose", "tail_tip"))
    front, back = (cut_by_ball(whole(full, full), end, 0.85).mesh for end in ends)
    return front, back


@cache
def labeled_once() -> PairQuestion:
    """The front and the back, labeled; who asks `replace`s it, so that the answer is its own."""
    return pair_question(*front_and_back(), 0, describe=described_once)


@cache
def answered_once() -> Meeting:
    """The same at a glance."""
    return labeled_once().at_a_glance()


@pytest.fixture
def laid(monkeypatch) -> Both[SharedPlacement]:
    """Both as they lie at a glance, by whatever labels: what is told from that is tested here."""
    found = answered_once().placements
    for name in ("first_look", "looked_closer"):
        monkeypatch.setattr(module, name, lambda *_, **__: found)
    monkeypatch.setattr(module, "followed", lambda _, labelings: labelings)
    return found


def likeliest(answers: list[Meeting], _: object) -> Meeting:
    """No mirror image is asked."""
    return max(answers, key=lambda met: met.chance)


def test_what_lies_nowhere_else_is_answered_as_it_is(monkeypatch) -> None:
    """All further places may turn out to be the one that is known."""
    monkeypatch.setattr(module, "labelings_by_form", lambda *_: [])
    front, _ = front_and_back()
    tube = bumpy_tube()
    tube = tube.with_vertices(tube.vertices * np.sqrt(front.area / tube.area))
    assert pair_question(front, tube, 0, describe=described_once).in_full().chance < SURE


def test_a_further_place_that_grew_into_the_first_one_is_not_laid_again(laid, monkeypatch) -> None:
    question = replace(labeled_once())
    monkeypatch.setattr(module, "labelings_by_form", lambda *_: [question.led, question.led])
    monkeypatch.setattr(module, "finished_place", lambda _, begun: replace(begun))
    monkeypatch.setattr(module, "beside_their_twins", likeliest)
    monkeypatch.setattr(module, "may_be_right", lambda *_: False)
    monkeypatch.setattr(module, "may_lie_right", lambda *_: False)
    monkeypatch.setattr(module, "join_chance", lambda _: 0.1)
    looks = []
    monkeypatch.setattr(module, "first_look", lambda *_, **__: looks.append(1) or laid)
    assert question.in_full().chance == pytest.approx(0.1)
    assert len(looks) == 1


def test_what_comes_back_nowhere_is_not_looked_at_closer(monkeypatch) -> None:
    """Also if one direction still shares something; who reads the answer finds it unlikely."""

    def seen_once(*given: Any, **options: float) -> Any:
        there, back = first_look(*given, **options)
        return replace(there, shared=np.zeros_like(there.shared)), back

    monkeypatch.setattr(module, "first_look", seen_once)
    monkeypatch.setattr(module, "looked_closer", lambda *_, **__: pytest.fail("looked closer"))
    met = replace(labeled_once()).at_a_glance()
    assert met.chance == LEAST
    assert not met.twin
    assert not met.placements[0].shared.any()
    assert met.placements[1].shared.any()
    for question, queries, place in zip(met.questions, met.queries, met.placements, strict=True):
        trust = shared_confidence(question.part.mesh, queries, place)
        assert trust.max() < SURE


def test_what_may_be_right_its_place_slides_and_is_judged_there(laid, monkeypatch) -> None:
    """It lies where it slid to if that is likelier, or if reliefs are more alike there."""
    home = []

    def slid(_: object, found: Any, **__: float) -> Any:
        home.append((replace(found[0]), replace(found[1])))
        return home[-1]

    monkeypatch.setattr(module, "labelings_by_form", lambda *_: [])
    monkeypatch.setattr(module, "beside_their_twins", likeliest)
    monkeypatch.setattr(module, "may_be_right", lambda *_: True)
    monkeypatch.setattr(module, "may_lie_right", lambda *_: False)
    monkeypatch.setattr(module, "slid", slid)
    monkeypatch.setattr(module, "one_place", list)  # all answers here have one chance
    monkeypatch.setattr(module, "join_chance", lambda _: 0.7)
    for chance, alike, moves in ((0.9, 0.0, True), (0.7, 1.0, True), (0.7, -1.0, False)):
        said = SlidChance(chance, 0.0)
        monkeypatch.setattr(module, "chance_where_it_slid", lambda *_, said=said: said)
        monkeypatch.setattr(
            module,
            "alike_in_relief",
            lambda _, found, alike=alike: alike * any(found is each for each in home),
        )
        found = replace(labeled_once()).in_full()
        assert found.chance == chance
        assert found.placements is (home[-1] if moves else laid)


def test_what_is_sure_by_its_skin_stays_where_a_slide_would_leave_it(laid, monkeypatch) -> None:
    """A slide looks for what is alike and may find it beside the right place."""

    def slid(_: object, found: Any, **__: float) -> Any:
        return replace(found[0]), replace(found[1])

    monkeypatch.setattr(module, "labelings_by_form", lambda *_: [])
    monkeypatch.setattr(module, "beside_their_twins", likeliest)
    monkeypatch.setattr(module, "may_be_right", lambda *_: False)
    monkeypatch.setattr(module, "may_lie_right", lambda *_: True)
    monkeypatch.setattr(module, "slid", slid)
    monkeypatch.setattr(module, "one_place", list)
    monkeypatch.setattr(module, "join_chance", lambda _: 0.1)
    monkeypatch.setattr(module, "chance_as_it_lies", lambda *_: SlidChance(0.95, 0.95, 0.95))
    monkeypatch.setattr(module, "chance_where_it_slid", lambda *_: SlidChance(0.3, 0.3))
    found = replace(labeled_once()).in_full()
    assert found.chance == 0.95
    assert found.placements is laid
    monkeypatch.setattr(module, "chance_where_it_slid", lambda *_: SlidChance(0.9, 0.9))
    moved = replace(labeled_once()).in_full()
    assert moved.placements is not laid


@pytest.mark.usefixtures("laid")
def test_what_fills_a_gap_may_be_right_and_is_alike_in_relief(monkeypatch) -> None:
    """What is of another kind may go on all around, and its reliefs are less alike."""
    question = labeled_once()
    monkeypatch.setattr(module, "likeness_of_both", lambda *_: None)
    monkeypatch.setattr(module, "join_features", lambda *_: np.zeros(8))
    monkeypatch.setattr(module, "may_lie_right", lambda _: True)
    monkeypatch.setattr(PairQuestion, "_slid", lambda question, met, _: met)
    for case in ((True, True, True), (False, True, True), (True, False, True), (True, True, False)):
        may_be, alike, all_around = case
        said = SlidChance(0.0, 0.0, alike=alike)
        monkeypatch.setattr(module, "may_be_right", lambda _, may_be=may_be: may_be)
        monkeypatch.setattr(module, "chance_as_it_lies", lambda *_, said=said: said)
        monkeypatch.setattr(module, "fills_a_gap", lambda *_, around=all_around: around)
        # the same labels, judged anew
        assert replace(question).at_a_glance().fills == all(case)


def test_how_much_is_recognized_is_told_but_not_of_what_lies_within_or_of_little(
    laid, monkeypatch
) -> None:
    question = labeled_once()
    monkeypatch.setattr(module, "likeness_of_both", lambda *_: None)
    monkeypatch.setattr(module, "join_features", lambda *_: np.zeros(8))
    monkeypatch.setattr(module, "may_be_right", lambda *_: False)
    monkeypatch.setattr(module, "may_lie_right", lambda *_: True)
    monkeypatch.setattr(module, "chance_as_it_lies", lambda *_: SlidChance(0.3, 0.3))
    monkeypatch.setattr(module, "lies_within", lambda *_: False)
    shares = iter([0.7, 0.9, 0.7, 0.9])
    monkeypatch.setattr(module, "recognized_by_relief", lambda *_: next(shares))
    area = shared_area(question.questions, laid) * question.unit**2
    assert replace(question).at_a_glance().recognized == pytest.approx(0.3 * area)
    with monkeypatch.context() as patch:
        patch.setattr(module, "lies_within", lambda *_: True)
        assert replace(question).at_a_glance().recognized == 0.0
    larger = max(mesh.area for mesh in front_and_back())
    monkeypatch.setattr(module, "RECOGNIZED", 0.49 * area / larger)
    assert replace(question).at_a_glance().recognized == pytest.approx(0.3 * area)
    monkeypatch.setattr(module, "RECOGNIZED", 0.52 * area / larger)
    assert replace(question).at_a_glance().recognized == 0.0


def test_two_pieces_that_only_meet_are_not_laid_over_each_other() -> None:
    """The skin of the trunk has no bumps, so its one half looks like the other one, moved."""
    full, walking = creature(5000), creature(5000, pose="walk")
    rear, front, _ = puzzle_pieces(full, [walking, full, walking])
    assert likelier(pair_question(rear.mesh, front.mesh, 0).in_full()) < LIKELY
