from __future__ import annotations

import numpy as np
import pytest

from sherd.energy.convergence import Convergence
from sherd.energy.descent import minimize_columns
from sherd.energy.exponential import _ExponentialEnergy, exponential_regions
from sherd.energy.logistic import (
    LogisticOptions,
    _SigmoidEnergy,
    area_shift,
    logistic_regions,
)
from sherd.energy.problem import EnergyWeights
from sherd.errors import InputError, OptionError


@pytest.fixture
def starts(bumpy_sphere) -> np.ndarray:
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    return (bumpy_sphere.vertices @ axes.T > 0.4).T.astype(float)


def slope_of_remainder(objective, point: np.ndarray, factor: float) -> float:
    direction = np.random.default_rng(1).standard_normal(len(point))
    column = np.array([0])
    value, gradient = objective(point[:, None], column)
    slope = factor * float(gradient[:, 0] @ direction)
    steps = np.array([1e-3, 1e-4, 1e-5])
    rest = [
        abs(objective((point + h * direction)[:, None], column)[0][0] - value[0] - h * slope)
        for h in steps
    ]
    return float(np.polyfit(np.log(steps), np.log(rest), 1)[0])


def test_sigmoid_gradient(cap_problem, sphere_basis) -> None:
    problem = cap_problem.with_evidence(np.linspace(0, 1, cap_problem.vertex_count))
    energy = _SigmoidEnergy(problem, sphere_basis, np.float64)
    fields = np.random.default_rng(2).random((problem.vertex_count, 1))
    objective = energy.objective(fields, 0.1)
    point = np.random.default_rng(0).standard_normal(60)
    assert slope_of_remainder(objective, point, 1.0) > 1.95
    assert slope_of_remainder(objective, point, 1.01) < 1.5


def test_exponential_gradient(cap_problem, sphere_basis) -> None:
    energy = _ExponentialEnergy(cap_problem, sphere_basis, 1)
    energy.prepare(np.random.default_rng(2).random((cap_problem.vertex_count, 1)), 0.1)
    point = 0.3 * np.random.default_rng(0).standard_normal(60)
    energy.update(point[:, None])
    assert slope_of_remainder(energy, point, 1.0) > 1.95
    assert slope_of_remainder(energy, point, 1.01) < 1.5


def test_shift_meets_the_area_even_where_the_sigmoid_is_flat() -> None:
    rng = np.random.default_rng(0)
    areas = rng.random(500)
    for width in (1e-3, 1.0, 300.0):
        scores = width * rng.standard_normal((500, 3))
        for share in (1e-3, 0.5, 0.999):
            shift = area_shift(scores, areas, share * areas.sum(), np.zeros(3))
            u = 1 / (1 + np.exp(-np.clip(scores + shift, -700, 700)))
            assert areas @ u == pytest.approx(share * areas.sum(), rel=1e-9)


def test_logistic_finds_the_cap_from_any_start(cap_problem, sphere_basis, starts, cap) -> None:
    regions = logistic_regions(cap_problem, sphere_basis, starts)
    best = regions[0]
    areas, area = cap_problem.vertex_areas, cap_problem.part_area
    assert areas @ np.abs(best.membership - cap) < 0.2 * area
    assert areas @ best.membership == pytest.approx(area, rel=1e-9)
    assert ((best.membership >= 0) & (best.membership <= 1)).all()
    rebuilt = sphere_basis.eigenvectors @ best.membership_coefficients
    rebuilt = 1 / (1 + np.exp(-rebuilt * np.sqrt(areas.sum())))
    assert np.abs(rebuilt - best.membership).max() < 1e-6
    totals = [region.energy.total for region in regions]
    assert totals == sorted(totals)


def test_crispness_makes_it_crisp(cap_problem, sphere_basis, starts) -> None:
    def softness(crispness: tuple[float, ...]) -> float:
        options = LogisticOptions(crispness=crispness, round_evaluations=100)
        u = logistic_regions(cap_problem, sphere_basis, starts, options=options)[0].membership
        return float(4 * cap_problem.vertex_areas @ (u * (1 - u)) / cap_problem.part_area)

    assert softness((0.0, 0.05, 0.2)) < 0.6 * softness((0.0,))


def test_evidence_pulls(cap_problem, sphere_basis, starts, bumpy_sphere) -> None:
    """With the data term silenced by a constant descriptor, evidence alone places the region."""
    side = bumpy_sphere.vertices[:, 0]
    problem = cap_problem.with_evidence(side).with_weights(EnergyWeights(regularity=0.001))
    problem = problem.with_descriptors(np.ones((len(side), 1)), [problem.part_area])
    best = logistic_regions(problem, sphere_basis, starts)[0]
    assert best.membership[side.argmax()] > 0.95
    assert best.membership[side.argmin()] < 0.05


def test_same_input_same_bits(cap_problem, sphere_basis, starts) -> None:
    first, second = (logistic_regions(cap_problem, sphere_basis, starts)[0] for _ in range(2))
    assert np.array_equal(first.membership, second.membership)


def test_exponential_keeps_its_upper_rows(cap_problem, sphere_basis, starts, cap) -> None:
    best = exponential_regions(cap_problem, sphere_basis, starts)[0]
    areas, area = cap_problem.vertex_areas, cap_problem.part_area
    assert areas @ np.abs(best.membership - cap) < 0.3 * area
    assert best.bound_violation < 0.01
    heights = sphere_basis.eigenvectors @ best.membership_coefficients * np.sqrt(areas.sum())
    rebuilt = np.minimum(np.exp(-heights - best.shift), 1.0)
    assert np.abs(rebuilt - best.membership).max() < 1e-12
    hurried = LogisticOptions(round_evaluations=2, crispness=(0.0,))
    short = exponential_regions(cap_problem, sphere_basis, starts, options=hurried)[0]
    assert short.status is Convergence.ITERATION_LIMIT
    assert areas @ best.membership == pytest.approx(area, rel=1e-3)


def test_statuses_and_refusals(cap_problem, sphere_basis, starts) -> None:
    hurried = LogisticOptions(search_evaluations=1, crispness=(0.0,), round_evaluations=1)
    regions = logistic_regions(cap_problem, sphere_basis, starts, options=hurried)
    assert {region.status for region in regions} == {Convergence.ITERATION_LIMIT}
    with pytest.raises(InputError, match=r"\(starts, 642\)"):
        logistic_regions(cap_problem, sphere_basis, starts[:, :5])
    with pytest.raises(InputError, match=r"outside \[0, 1\]"):
        logistic_regions(cap_problem, sphere_basis, 2 * starts)
    with pytest.raises(OptionError, match="survivors"):
        LogisticOptions(survivors=0)
    with pytest.raises(OptionError, match="crispness"):
        LogisticOptions(crispness=())


def test_columns_descend_on_their_own() -> None:
    """Rosenbrock valleys of different depth end at (1, 1), each at its own pace."""
    strength = np.array([1.0, 10.0, 100.0])

    def valleys(points: np.ndarray, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        x, y = points
        b = strength[columns]
        values = (1 - x) ** 2 + b * (y - x**2) ** 2
        slope_x = -2 * (1 - x) - 4 * b * x * (y - x**2)
        return values, np.stack([slope_x, 2 * b * (y - x**2)])

    start = np.array([[-1.2, -1.2, -1.2], [1.0, 1.0, 1.0]])
    found = minimize_columns(valleys, start, evaluations=200, tolerance=1e-8)
    assert found.converged.all()
    assert np.abs(found.points - 1).max() < 1e-6
    assert found.evaluations[0] < found.evaluations[2] < 200
    assert [found.status(column) for column in range(3)] == [Convergence.CONVERGED] * 3
    short = minimize_columns(valleys, start, evaluations=5, tolerance=1e-8)
    assert not short.converged.any()
    assert short.status(0) is Convergence.ITERATION_LIMIT


def test_a_column_without_a_way_down_stalls() -> None:
    """Every step along a gradient of the wrong sign rises."""

    def uphill(points: np.ndarray, _: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return (points**2).sum(axis=0), -2 * points

    found = minimize_columns(uphill, np.ones((2, 1)), evaluations=200, tolerance=1e-8)
    assert found.status(0) is Convergence.STALLED
    assert (found.points == 1).all()
