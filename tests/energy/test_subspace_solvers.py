from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from sherd.energy.convergence import Convergence
from sherd.energy.mumford_shah import data_term
from sherd.energy.problem import EnergyWeights
from sherd.energy.quadratic import BoundedQuadratic
from sherd.energy.solvers import SOLVERS, active_set, augmented_lagrangian, quadratic_program
from sherd.energy.subspace import subspace_region
from sherd.errors import InputError, OptionError
from sherd.spectral.basis import eigenbasis


def random_program(seed: int, size: int = 12, count: int = 200) -> BoundedQuadratic:
    rng = np.random.default_rng(seed)
    rows = rng.standard_normal((count, size)) / np.sqrt(size)
    rows[:, 0] = 1.0  # the constant function, as in an eigenbasis: the program is feasible
    root = rng.standard_normal((size, size))
    weights = rng.random(count) + 0.1
    weights /= weights.sum()
    return BoundedQuadratic(
        matrix=root @ root.T + 0.1 * np.eye(size),
        linear=5 * rng.standard_normal(size),
        rows=rows,
        row_weights=weights,
        equality=rows.T @ weights,
        target=float(rng.uniform(0.1, 0.9)),
    )


@pytest.mark.parametrize("name", SOLVERS)
def test_known_answer_in_one_dimension(name: str) -> None:
    """min (x - 3)^2 / 2 with 0 <= x <= 1 and 0 <= x / 2 <= 1: x = 1, multiplier 2."""
    program = BoundedQuadratic(
        matrix=np.eye(1),
        linear=np.array([-3.0]),
        rows=np.array([[1.0], [0.5]]),
        row_weights=np.array([0.5, 0.5]),
    )
    solution = SOLVERS[name](program)
    assert solution.point == pytest.approx([1.0], abs=1e-4)
    assert solution.multipliers == pytest.approx([2.0, 0.0], abs=1e-3)
    assert np.isnan(solution.equality_multiplier)


@pytest.mark.parametrize("name", SOLVERS)
def test_known_answer_with_area(name: str) -> None:
    """min |x - (2, -1, 0)|^2 / 2 in the unit cube with mean 1/2: (1, 0, 1/2), nu = -3/2 * ..."""
    program = BoundedQuadratic(
        matrix=np.eye(3),
        linear=np.array([-2.0, 1.0, 0.0]),
        rows=np.eye(3),
        row_weights=np.full(3, 1 / 3),
        equality=np.full(3, 1 / 3),
        target=0.5,
    )
    solution = SOLVERS[name](program)
    assert solution.point == pytest.approx([1.0, 0.0, 0.5], abs=1e-4)
    # stationarity of the free third entry: 1/2 + nu / 3 = 0
    assert solution.equality_multiplier == pytest.approx(-1.5, abs=1e-3)
    assert solution.multipliers == pytest.approx([1.5, -0.5, 0.0], abs=1e-3)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000))
def test_solvers_agree_and_prove_it(seed: int) -> None:
    program = random_program(seed)
    reference = quadratic_program(program)
    assert reference.status is Convergence.CONVERGED
    for residual in ("primal_residual", "dual_residual", "duality_gap"):
        assert getattr(reference, residual) < 1e-8
    generated = active_set(program)
    assert generated.objective == pytest.approx(reference.objective, rel=1e-6, abs=1e-9)
    assert generated.rows_used < len(program.rows)
    assert max(generated.primal_residual, generated.dual_residual, generated.duality_gap) < 1e-8
    lagrangian = augmented_lagrangian(program)
    assert lagrangian.status is Convergence.CONVERGED
    assert np.abs(lagrangian.values - reference.values).mean() < 1e-3
    assert max(lagrangian.primal_residual, lagrangian.dual_residual) < 1e-4


def test_against_a_solver_of_another_kind() -> None:
    program = random_program(5, size=4, count=20)
    constraints = [
        {"type": "ineq", "fun": lambda x: program.rows @ x},
        {"type": "ineq", "fun": lambda x: 1 - program.rows @ x},
        {"type": "eq", "fun": lambda x: program.equality @ x - program.target},
    ]
    start = np.array([program.target, 0, 0, 0])
    witness = minimize(
        program.value, start, constraints=constraints, method="SLSQP", options={"ftol": 1e-14}
    )
    assert active_set(program).objective == pytest.approx(witness.fun, rel=1e-6)


def test_column_generation_reports_when_it_may_not_finish() -> None:
    program = random_program(1, size=30, count=3000)
    short = active_set(program, rounds=1)
    assert short.status is Convergence.ITERATION_LIMIT
    assert short.primal_residual > 1e-3
    assert "more iterations" in short.status.advice
    hurried = augmented_lagrangian(program, iterations=2)
    assert hurried.status is Convergence.ITERATION_LIMIT


@pytest.mark.parametrize("name", SOLVERS)
def test_alternation_descends_and_finds_the_cap(name, cap_problem, sphere_basis, cap) -> None:
    region = subspace_region(cap_problem, sphere_basis, solver=name)
    assert region.status is Convergence.CONVERGED
    history = np.array(region.history)
    assert (np.diff(history) <= 1e-6 * history[:-1]).all()
    areas = cap_problem.vertex_areas
    assert areas @ region.membership == pytest.approx(cap_problem.part_area, rel=1e-3)
    assert areas @ np.abs(region.membership - cap) < 0.4 * cap_problem.part_area
    assert ((region.phase_field >= 0) & (region.phase_field <= 1)).all()
    # the phase field opens where the membership jumps, and nowhere else
    rim = region.phase_field.argmin()
    assert 0.1 < region.membership[rim] < 0.9


def test_limit_of_no_regularity(cap_problem, sphere_basis) -> None:
    """As lambda_r tends to 0 the data residual falls to that of the pure data problem.

    The membership itself is not unique there (12 descriptors, 60 coefficients): only the
    residual and the objective have a limit.
    """
    residuals = []
    for regularity in (1e-1, 1e-3, 1e-5, 0.0):
        weights = EnergyWeights(regularity=regularity, phase_width=0.3)
        problem = cap_problem.with_weights(weights)
        region = subspace_region(problem, sphere_basis, iterations=1)
        residuals.append(data_term(problem, region.membership_solution.values))
    assert (np.diff(residuals) <= 1e-7).all()
    assert residuals[0] > 5 * residuals[-1]
    assert residuals[2] == pytest.approx(residuals[-1], rel=0.02)


def test_wrong_questions(cap_problem, sphere_basis, bumpy_sphere) -> None:
    with pytest.raises(OptionError, match="active-set"):
        subspace_region(cap_problem, sphere_basis, solver="simplex")
    small, _ = bumpy_sphere.submesh(np.arange(bumpy_sphere.face_count) < 100)
    with pytest.raises(InputError, match="642"):
        subspace_region(cap_problem, eigenbasis(small, 5))
