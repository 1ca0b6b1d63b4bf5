"""Unknown scale: the factor that a part was shrunk or enlarged by is found."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.correspondence import scale
from sherd.correspondence.labels.labeling import UNKNOWN_SCALE, Labeling, labeling_problem
from sherd.correspondence.question import Question
from sherd.correspondence.scale import (
    LARGEST_SCALE,
    estimated_scale,
    largest_factor,
    length_ratio,
)
from sherd.mesh.sizes import LARGEST_PART
from sherd.surface.described import DescribedSurface, Known
from sherd.surface.samples import Samples
from sherd.surface.transformed import enlarged
from sherd.surface.working import WorkingSurface


def true_problem(planted, factor: float):
    """The planted question about the piece made larger by `factor`, with its true labeling."""
    question = planted.question.with_part(enlarged(planted.question.part, factor))
    similarity = np.zeros((len(planted.labels), len(question.full.dense), 16), dtype=np.float32)
    problem = labeling_problem(question, similarity, np.random.default_rng(0))
    count = len(planted.labels)
    return problem, Labeling(planted.labels, planted.rotations, np.zeros(count), 0.0)


@pytest.mark.parametrize("factor", [0.6, 1.0, 1.5])
def test_the_ratio_of_lengths_is_one_over_the_factor(planted, factor: float) -> None:
    ratio, spread = length_ratio(*true_problem(planted, factor))
    # distances on the piece and on the blob differ by the error of the heat method, one percent
    assert ratio * factor == pytest.approx(1.0, abs=0.015)
    assert spread < 0.02


def test_wrong_labels_have_uneven_ratios(planted) -> None:
    problem, labeling = true_problem(planted, 1.0)
    wrong = np.random.default_rng(0).permutation(len(problem.labels))[: len(labeling.labels)]
    other = Labeling(wrong, labeling.rotations, labeling.local_cost, 0.0)
    assert length_ratio(problem, other)[1] > 0.2


def test_nodes_that_all_have_one_label_tell_nothing(planted) -> None:
    problem, labeling = true_problem(planted, 1.0)
    same = np.zeros_like(labeling.labels)
    other = Labeling(same, labeling.rotations, labeling.local_cost, 0.0)
    assert length_ratio(problem, other) == (1.0, np.inf)


def test_the_scale_of_a_part_is_estimated(planted) -> None:
    """A third of the nodes, for speed."""
    part, few = planted.question.part, slice(0, 70)
    nodes = part.sparse
    known = Known(
        sparse=Samples.of(nodes.vertices[few], nodes.distances[few], nodes.directions[few, few])
    )
    small = enlarged(DescribedSurface(part.working, reference=part.reference, known=known), 0.6)
    question = Question(planted.question.full, small, UNKNOWN_SCALE)
    found = estimated_scale(question, np.random.default_rng(0), largest=largest_factor(question))
    assert not found.at_bound
    assert found.factor * 0.6 == pytest.approx(1.0, abs=0.04)


def test_the_factor_is_corrected_three_times(planted, monkeypatch) -> None:
    """Labelings that see only half of what is missing leave an eighth of it."""
    true = 1.2

    def trial(question: Question, factor: float, rng: np.random.Generator) -> tuple[float, float]:
        return -abs(np.log(true / factor)), float(np.sqrt(true / factor))

    monkeypatch.setattr(scale, "_trial", trial)
    room = largest_factor(planted.question)
    found = estimated_scale(planted.question, np.random.default_rng(0), largest=room)
    grid = np.geomspace(1 / LARGEST_SCALE, LARGEST_SCALE, scale.GRID)
    largest = np.sqrt(LARGEST_PART / planted.question.part.mesh.area)
    first = np.abs(np.log(true / grid[grid <= largest])).min()
    assert abs(np.log(true / found.factor)) == pytest.approx(first / 8)


@pytest.mark.parametrize(
    ("size", "ratio", "expected"), [(0.2, 9.0, 2.0), (0.2, 0.01, 0.5), (1.0, 9.0, None)]
)
def test_no_scale_beyond_the_range_or_the_full_shape_is_answered(
    planted, monkeypatch, size: float, ratio: float, expected: float | None
) -> None:
    """Whatever ratio the labelings give: from a half to two, and to 1.3 times the full area."""
    mesh, full = planted.question.part.mesh, planted.question.full
    other = mesh.with_vertices(mesh.vertices * size)
    part = DescribedSurface(WorkingSurface(other, other, None))
    tried = []

    def trial(question: Question, factor: float, rng: np.random.Generator) -> tuple[float, float]:
        tried.append(factor)
        return 1.0, ratio

    monkeypatch.setattr(scale, "_trial", trial)
    largest = np.sqrt(LARGEST_PART * full.mesh.area / other.area)
    question = Question(full, part, UNKNOWN_SCALE)
    room = largest_factor(question)
    found = estimated_scale(question, np.random.default_rng(0), largest=room)
    assert found.at_bound
    assert found.factor == pytest.approx(expected or largest)
    assert max(tried) <= min(LARGEST_SCALE, largest) * (1 + 1e-12)
    assert min(tried) == pytest.approx(0.5)
