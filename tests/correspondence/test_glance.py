"""What labels alone say of a place, before anything is laid there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sherd.correspondence.labels.inverse import inverse_labeling
from sherd.correspondence.labels.labeling import Labeling
from sherd.correspondence.labels.two_way import TwoLabelings
from sherd.correspondence.placements import anchor_problem
from sherd.correspondence.question import Question
from sherd.correspondence.shared.glance import Glance, glance
from sherd.correspondence.shared.open_border import MOST_OPEN


@pytest.fixture(scope="module")
def questions(planted) -> tuple[Question, Question]:
    """The piece on the blob that it was cut from, and the blob on the piece."""
    there = planted.question
    return there, Question(there.part, there.full, there.comparison)


@pytest.fixture(scope="module")
def problems(questions):
    return tuple(anchor_problem(each, np.random.default_rng(0)) for each in questions)


@pytest.fixture(scope="module")
def forms(planted) -> tuple[np.ndarray, np.ndarray]:
    """Something that changes over the blob, and over the piece as it does there."""
    x, y, z = planted.question.full.mesh.vertices.T
    field = np.sin(20 * x + 5 * y) + np.sin(17 * z - 8 * x)
    return field[planted.kept], field


@pytest.fixture(scope="module")
def right(planted, problems) -> TwoLabelings:
    """All of the piece where it belongs."""
    count = len(planted.labels)
    placed = np.ones(count, dtype=bool)
    forward = Labeling(planted.labels, planted.rotations, np.zeros(count), 0.0, placed)
    backward = inverse_labeling(problems[1], forward)
    return TwoLabelings(
        forward, backward, placed, backward.placed, (20.0, 20.0), 1.0, 0.5, 0.0, 0.2
    )


def seen(questions, problems, forms, labelings) -> Glance:
    return glance(questions, problems, labelings, forms)


def test_the_right_place_leads_is_closed_and_alike_in_form(
    questions, problems, forms, right
) -> None:
    found = seen(questions, problems, forms, right)
    assert found.likeness.leading > 0.8
    assert found.is_open < 0.5 * MOST_OPEN
    assert found.form > 0.5


def test_a_wrong_place_is_less_alike(questions, problems, forms, right) -> None:
    wrong = replace(right, forward=replace(right.forward, labels=np.roll(right.forward.labels, 7)))
    found, good = (seen(questions, problems, forms, each) for each in (wrong, right))
    assert found.likeness.leading < good.likeness.leading - 0.2
    assert found.form < good.form - 0.2


def test_a_place_of_which_half_is_left_out_is_open(questions, problems, forms, right) -> None:
    part = questions[0].part
    height = part.mesh.vertices[part.sparse.vertices][:, 2]
    lower = height < np.median(height)
    half = replace(right, forward_agrees=right.forward_agrees & lower)
    found, good = (seen(questions, problems, forms, each) for each in (half, right))
    assert found.is_open > good.is_open + 0.3


def test_where_nothing_agrees_nothing_is_said(questions, problems, forms, right) -> None:
    nothing = replace(
        right,
        forward_agrees=np.zeros_like(right.forward_agrees),
        backward_agrees=np.zeros_like(right.backward_agrees),
    )
    assert seen(questions, problems, forms, nothing) == Glance(None, MOST_OPEN, 0.0)


def test_swapping_the_shapes_says_the_same(questions, problems, forms, right) -> None:
    swapped = replace(
        right,
        forward=right.backward,
        backward=right.forward,
        forward_agrees=right.backward_agrees,
        backward_agrees=right.forward_agrees,
    )
    one = seen(questions, problems, forms, right)
    assert seen(questions[::-1], problems[::-1], forms[::-1], swapped) == one
