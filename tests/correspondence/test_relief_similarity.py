"""Labels by SHOT and by relief: of one thing in another pose more right ones come first."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from sherd.arrays import Bools
from sherd.correspondence.labels.labeling import SAME_SCALE, Problem
from sherd.correspondence.labels.relief_similarity import with_relief
from sherd.correspondence.placements import anchor_problem
from sherd.correspondence.question import Question
from sherd.mesh.surface_points import closest_points
from sherd.shapes import creature, puzzle_pieces
from sherd.shapes.fragment import Fragment
from sherd.surface.described import DescribedSurface
from sherd.surface.prepared import described_part


@pytest.fixture(scope="module")
def pieces() -> tuple[Fragment, Fragment]:
    full, walking = creature(5000), creature(5000, pose="walk")
    first, second = puzzle_pieces(full, [full, walking], overlap=0.3)
    return first, second


@pytest.fixture(scope="module")
def problem(pieces: tuple[Fragment, Fragment]) -> Problem:
    unit = max(piece.mesh.length for piece in pieces)
    full, part = (described_part(piece.mesh, unit) for piece in pieces)
    return anchor_problem(Question(full, part, SAME_SCALE), np.random.default_rng(0))


def right_labels(problem: Problem, pieces: tuple[Fragment, Fragment]) -> Bools:
    """(k, s) whether a label lies within 0.045 of where a node belongs, on the standing animal."""

    def places(surface: DescribedSurface, piece: Fragment, vertices: np.ndarray) -> np.ndarray:
        at = closest_points(surface.placed, surface.mesh.vertices[vertices])
        own = at.nearest_vertices(surface.placed)
        return piece.truth.positions(piece.full)[own] / piece.mesh.length

    full, part = problem.question.full, problem.question.part
    nodes = places(part, pieces[1], part.sparse.vertices)
    labels = places(full, pieces[0], full.dense.vertices)
    scale = pieces[1].mesh.length / pieces[0].mesh.length
    away = np.linalg.norm(nodes[:, None] * scale - labels[None], axis=2)
    near: Bools = away < 0.045
    return near


def test_more_right_labels_come_first(problem: Problem, pieces: tuple[Fragment, Fragment]) -> None:
    right = right_labels(problem, pieces)
    shared = right.any(axis=1)
    assert shared.sum() > 30

    def first(each: Problem) -> float:
        best = each.peaks.argmax(axis=1)
        return float(right[np.arange(len(best)), best][shared].mean())

    assert first(with_relief(problem)) > 1.2 * first(problem)


def test_costs_keep_their_unit(problem: Problem) -> None:
    spreads = [each.peaks.std(axis=1).mean() for each in (problem, with_relief(problem))]
    assert spreads[1] == pytest.approx(spreads[0], rel=0.3)


def test_a_surface_without_relief_leaves_the_problem_as_it_is(
    problem: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    nothing = partial(np.zeros, problem.similarity.shape, np.float32)
    monkeypatch.setattr(
        "sherd.correspondence.labels.relief_similarity.patch_similarity", lambda *_: nothing()
    )
    same = replace(problem)
    assert with_relief(same) is same
