"""The loop over the two steps, and that the steps' programs are the energy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sherd.energy.all_vertices import full_membership_quadratic, full_phase_quadratic, full_region
from sherd.energy.alternation import alternate
from sherd.energy.convergence import Convergence
from sherd.energy.mumford_shah import energy
from sherd.energy.quadratic import QuadraticSolution, certified
from sherd.energy.subspace import (
    basis_rows,
    membership_quadratic,
    phase_field_quadratic,
    subspace_region,
)
from sherd.errors import OptionError


def solution(problem, status: Convergence = Convergence.CONVERGED) -> QuadraticSolution:
    zeros = np.zeros(problem.vertex_count)
    program = full_phase_quadratic(problem, zeros)
    return certified(program, zeros, zeros, iterations=1, rows_used=0, status=status)


def test_each_step_is_given_the_other_function_and_its_own(cap_problem) -> None:
    count = cap_problem.vertex_count
    seen = []

    def membership_step(rho, before):
        seen.append((rho[0], None if before is None else before[0]))
        return np.full(count, 1.5), solution(cap_problem)

    def phase_step(u, before):
        seen.append((u[0], before[0]))
        return np.full(count, -0.5), solution(cap_problem)

    region = alternate(cap_problem, membership_step, phase_step, iterations=5, tolerance=0.0)
    assert seen[:4] == [(1.0, None), (1.5, 1.0), (-0.5, 1.5), (1.5, -0.5)]
    # the second alternation changes nothing, which is a decrease by 0
    assert region.iterations == 2
    assert region.status is Convergence.CONVERGED
    raw, clipped = np.full(count, 1.5), np.ones(count)
    assert region.history[0] == energy(cap_problem, raw, np.ones(count)).total
    assert region.history[1] == energy(cap_problem, raw, np.full(count, -0.5)).total
    assert len(region.history) == 4
    assert (region.membership == 1).all()
    assert (region.phase_field == 0).all()
    assert region.energy == energy(cap_problem, clipped, np.zeros(count))


def test_a_step_that_failed_is_told(cap_problem) -> None:
    """Though the energy has come to rest; of two failures, that of the membership."""
    ones = np.ones(cap_problem.vertex_count)
    good = solution(cap_problem)
    stalled = solution(cap_problem, Convergence.STALLED)
    numerical = solution(cap_problem, Convergence.NUMERICAL)
    for first, second, wanted in (
        (good, good, Convergence.CONVERGED),
        (good, numerical, Convergence.NUMERICAL),
        (stalled, good, Convergence.STALLED),
        (stalled, numerical, Convergence.STALLED),
    ):
        region = alternate(
            cap_problem,
            lambda _rho, _before, first=first: (ones, first),
            lambda _u, _before, second=second: (ones, second),
            iterations=3,
            tolerance=0.0,
        )
        assert region.status is wanted
        assert region.membership_solution is first
        assert region.phase_solution is second


def test_the_limit_of_alternations_and_the_tolerance(cap_problem, sphere_basis) -> None:
    for solve in (full_region, lambda *a, **b: subspace_region(*a, sphere_basis, **b)):
        short = solve(cap_problem, iterations=1)
        assert short.status is Convergence.ITERATION_LIMIT
        assert (short.iterations, len(short.history)) == (1, 2)
        coarse, fine = (solve(cap_problem, tolerance=tolerance) for tolerance in (0.5, 1e-3))
        assert coarse.status is fine.status is Convergence.CONVERGED
        assert coarse.iterations == 2 < fine.iterations
        with pytest.raises(OptionError, match="iterations"):
            solve(cap_problem, iterations=0)
        for tolerance in (np.nan, np.inf, -1.0):
            with pytest.raises(OptionError, match="tolerance"):
                solve(cap_problem, tolerance=tolerance)


def test_the_subspace_goes_on_with_the_solvers_own_values(cap_problem, sphere_basis) -> None:
    """Clipping inside the alternation would leave the subspace, and the descent with it."""
    region = subspace_region(cap_problem, sphere_basis, solver="augmented-lagrangian", iterations=1)
    raw = region.membership_solution.values
    assert np.clip(raw, 0, 1).tolist() == region.membership.tolist() != raw.tolist()
    rho = np.ones(cap_problem.vertex_count)
    assert region.history[0] == energy(cap_problem, raw, rho).total
    rho = region.phase_solution.values
    assert region.history[1] == energy(cap_problem, raw, rho).total


def test_the_programs_are_the_energy(cap_problem, sphere_basis) -> None:
    """Differences of the objective are differences of the energy, but for the small ridge."""
    problem = cap_problem.with_evidence(np.linspace(-1, 1, cap_problem.vertex_count))
    problem = problem.with_weights(replace(problem.weights, regularity=0.5))
    rows = basis_rows(problem, sphere_basis)
    first, second = np.random.default_rng(0).normal(size=(2, 60)) / 8
    u, rho = (rows @ first, rows @ second)

    def of_membership(point: np.ndarray) -> float:
        return energy(problem, rows @ point, rho).total

    def of_phase(point: np.ndarray) -> float:
        return energy(problem, u, rows @ point).total / problem.weights.regularity

    for narrow, whole, total in (
        (
            membership_quadratic(problem, rows, rho),
            full_membership_quadratic(problem, rho),
            of_membership,
        ),
        (phase_field_quadratic(problem, rows, u), full_phase_quadratic(problem, u), of_phase),
    ):
        wanted = total(first) - total(second)
        assert narrow.value(first) - narrow.value(second) == pytest.approx(wanted, rel=1e-5)
        found = whole.value(rows @ first) - whole.value(rows @ second)
        assert found == pytest.approx(wanted, rel=1e-5)
