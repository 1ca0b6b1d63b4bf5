"""Unknown scale: the factor that a part was shrunk or enlarged by is found."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.correspondence import scale
from sherd.correspondence.labels.labeling import UNKNOWN_SCALE, Labeling, labeling_problem
from sherd.correspondence.question import Question
from sherd.correspondence.scale import (
    LARGEST_SIZE,
    SMALLEST_SIZE,
    estimated_scale,
    factors_about_one,
    factors_that_fit,
    length_ratio,
)
from sherd.results.advice import Doubts, OverlapDoubts
from sherd.results.status import Status
from sherd.surface.described import DescribedSurface, Known
from sherd.surface.samples import Samples
from sherd.surface.transformed import enlarged
from sherd.surface.working import WorkingSurface

# The draw of edges decides the fourth digit of a ratio.
DRAWS = 16


def true_problem(planted, factor: float, draw: int = 0):
    """The planted question about the piece made larger by `factor`, with its true labeling."""
    question = planted.question.with_part(enlarged(planted.question.part, factor))
    similarity = np.zeros((len(planted.labels), len(question.full.dense), 16), dtype=np.float32)
    problem = labeling_problem(question, similarity, np.random.default_rng(draw))
    count = len(planted.labels)
    return problem, Labeling(planted.labels, planted.rotations, np.zeros(count), 0.0)


@pytest.mark.parametrize("factor", [0.6, 1.0, 1.5])
def test_the_ratio_of_lengths_is_one_over_the_factor(planted, factor: float) -> None:
    found = [length_ratio(*true_problem(planted, factor, draw)) for draw in range(DRAWS)]
    ratios, spreads = np.array(found).T
    # paths that bend around the cut are longer on the piece: by up to one percent
    assert ratios.mean() * factor == pytest.approx(1.0, abs=0.01)
    assert spreads.max() < 0.02


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
    factors = factors_that_fit(question)
    found = estimated_scale(question, np.random.default_rng(0), factors)
    assert not found.at_bound
    assert found.rival is None
    assert found.factor * 0.6 == pytest.approx(1.0, abs=0.04)


def graded(monkeypatch, score, ratio=lambda _: 1.0) -> list[float]:
    """Trials give what these functions of the factor say; returns the factors as they are tried."""
    tried: list[float] = []

    def trial(how, question: Question, factor: float, seed: int) -> tuple[float, float]:
        tried.append(factor)
        return float(score(factor)), float(ratio(factor))

    monkeypatch.setattr(scale, "_trial", trial)
    return tried


def estimate(planted, factors=None, own: float = 1.0):
    factors = factors_that_fit(planted.question) if factors is None else factors
    return estimated_scale(planted.question, np.random.default_rng(0), factors, own=own)


def test_the_factor_is_read_off_a_parabola(planted, monkeypatch) -> None:
    """Similarity falls with the square of what is wrong, so between the factors none is lost."""
    true = 0.83
    tried = graded(monkeypatch, lambda factor: -(np.log(true / factor) ** 2))
    assert estimate(planted).factor == pytest.approx(true)
    assert (
        np.abs(np.log(np.array(tried[: len(factors_that_fit(planted.question))]) / true)).min()
        > 0.01
    )


def test_the_factor_is_corrected_beyond_what_labelings_see(planted, monkeypatch) -> None:
    """Where they see half of what is missing, one correction leaves a quarter of it."""
    true = 0.83
    tried = graded(
        monkeypatch,
        lambda factor: -abs(np.log(true / factor)),
        lambda factor: np.sqrt(true / factor),
    )
    found = estimate(planted)
    first = abs(np.log(true / tried[len(factors_that_fit(planted.question))]))
    assert first > 0.01
    assert abs(np.log(true / found.factor)) == pytest.approx(first / 4)


@pytest.mark.parametrize(("ratio", "end"), [(9.0, -1), (0.01, 0)])
@pytest.mark.parametrize("range_of", ["fitting", "about one"])
def test_no_scale_beyond_the_range_is_answered(
    planted, monkeypatch, ratio: float, end: int, range_of: str
) -> None:
    """Whatever ratio the labelings give."""
    fitting = range_of == "fitting"
    factors = factors_that_fit(planted.question) if fitting else factors_about_one()
    tried = graded(monkeypatch, lambda _: 1.0, lambda _: ratio)
    found = estimate(planted, factors)
    assert found.at_bound
    assert found.factor == pytest.approx(factors[end])
    assert max(tried) <= factors[-1] * (1 + 1e-12)
    assert min(tried) >= factors[0] * (1 - 1e-12)


def test_the_range_is_that_of_sizes_whatever_the_unit(planted) -> None:
    mesh, full = planted.question.part.mesh, planted.question.full
    for unit in (1e-3, 1.0, 25.4):
        other = mesh.with_vertices(mesh.vertices * unit)
        question = Question(
            full, DescribedSurface(WorkingSurface(other, other, None)), UNKNOWN_SCALE
        )
        sizes = factors_that_fit(question) * other.length / full.mesh.length
        assert sizes[[0, -1]] == pytest.approx([SMALLEST_SIZE, LARGEST_SIZE])
        assert (sizes[1:] / sizes[:-1]).max() < scale.STEP * (1 + 1e-12)


@pytest.mark.parametrize(("own", "expected"), [(0.5, 0.4), (1.4, 1.1)])
@pytest.mark.parametrize("lead", [0.02, -0.02])
def test_of_two_that_fit_as_well_the_nearer_is_taken_and_the_other_named(
    planted, monkeypatch, own: float, expected: float, lead: float
) -> None:
    def score(factor: float) -> float:
        return max(lead - np.log(factor / 0.4) ** 2, -(np.log(factor / 1.1) ** 2))

    graded(monkeypatch, score)
    found = estimate(planted, own=own)
    assert found.factor == pytest.approx(expected, rel=0.02)
    assert found.rival == pytest.approx(0.44 / expected, rel=0.02)


def test_what_fits_worse_is_no_rival(planted, monkeypatch) -> None:
    def score(factor: float) -> float:
        return max(-(np.log(factor / 0.4) ** 2), -(np.log(factor / 1.1) ** 2) - 0.05)

    graded(monkeypatch, score)
    found = estimate(planted, own=1.1)
    assert found.factor == pytest.approx(0.4, rel=0.02)
    assert found.rival is None


@pytest.mark.parametrize("doubts", [Doubts, OverlapDoubts])
def test_a_rival_or_a_bound_is_said_and_is_never_good(doubts) -> None:
    assert doubts().status is Status.GOOD
    for found in (doubts(scale_rival=2.345678), doubts(scale_bound=2.345678)):
        assert found.status is Status.DOUBTFUL
        assert "2.346; give" in found.advice
        assert "--scale FACTOR" in found.advice
    assert "fits about as well at another scale" in doubts(scale_rival=2.0).advice
    assert "stands at its bound" in doubts(scale_bound=2.0).advice
