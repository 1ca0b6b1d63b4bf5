"""Answers to one question that lie at the same place are no rivals."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from sherd.correspondence.shared.rivals import are_rivals
from sherd.shapes import creature


@pytest.fixture(scope="module")
def questions() -> Any:
    mesh = creature(5000)
    mesh = mesh.with_vertices(mesh.vertices / mesh.length)
    question = SimpleNamespace(part=SimpleNamespace(mesh=mesh))
    return question, question


def answer(questions: Any, *, moved: float, share: float) -> Any:
    """The first vertices, as many as `share` says, laid on themselves and moved."""
    mesh = questions[0].part.mesh
    shared = np.arange(mesh.vertex_count) < share * mesh.vertex_count
    trip = SimpleNamespace(there=mesh.vertices + np.array([moved, 0.0, 0.0]))
    place = SimpleNamespace(trip=trip, shared=shared)
    return place, place


def test_answers_at_one_place_are_no_rivals_however_much_each_covers(questions) -> None:
    whole = answer(questions, moved=0.0, share=1.0)
    third = answer(questions, moved=0.05, share=0.3)
    assert not are_rivals(questions, [whole, third]).any()


def test_answers_at_different_places_are_rivals(questions) -> None:
    here = answer(questions, moved=0.0, share=1.0)
    there = answer(questions, moved=0.2, share=1.0)
    nothing = answer(questions, moved=0.0, share=0.0)
    rivals = are_rivals(questions, [here, there, nothing])
    assert np.array_equal(rivals, ~np.eye(3, dtype=bool))
