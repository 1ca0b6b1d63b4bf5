from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

from sherd.energy.all_vertices import full_membership_quadratic, full_phase_quadratic, full_region
from sherd.energy.convergence import Convergence
from sherd.energy.quadratic import BoundedQuadratic, StructuredQuadratic, certified
from sherd.energy.solvers import quadratic_program
from sherd.energy.structured import active_sets, interior_point, solve_structured
from sherd.energy.subspace import subspace_region
from sherd.spectral.basis import eigenbasis


def random_structured(seed: int, count: int = 60, rank: int = 4) -> StructuredQuadratic:
    rng = np.random.default_rng(seed)
    chain = sparse.diags_array([2.001, -1.0, -1.0], offsets=[0, 1, -1], shape=(count, count))
    return StructuredQuadratic(
        sparse_matrix=sparse.csr_array(0.1 * chain),
        low_rank=rng.standard_normal((count, rank)) / np.sqrt(count),
        linear=rng.standard_normal(count),
        equality=rng.random(count) + 0.5,
        target=0.3 * count,
    )


def dense(problem: StructuredQuadratic) -> BoundedQuadratic:
    count = len(problem.linear)
    return BoundedQuadratic(
        matrix=problem.sparse_matrix.toarray() + problem.low_rank @ problem.low_rank.T,
        linear=problem.linear,
        rows=np.eye(count),
        row_weights=np.full(count, 1 / count),
        equality=problem.equality,
        target=problem.target,
    )


@pytest.mark.parametrize("seed", range(6))
def test_structured_solvers_reach_the_optimum(seed: int) -> None:
    problem = random_structured(seed)
    reference = quadratic_program(dense(problem))
    held = np.count_nonzero(np.abs(reference.values - 0.5) > 0.5 - 1e-9)
    assert 0 < held < 60
    assert solve_structured(problem).rows_used == held
    for solve in (interior_point, solve_structured):
        solution = solve(problem)
        assert solution.status is Convergence.CONVERGED
        assert solution.objective == pytest.approx(reference.objective, rel=1e-7)
        assert np.abs(solution.values - reference.values).max() < 1e-4
        assert max(solution.primal_residual, solution.dual_residual) < 1e-7
        assert solution.duality_gap < 1e-7


def test_both_programs_are_certified_alike() -> None:
    """At a point that is no optimum, so that every residual is seen, with and without equality."""
    rng = np.random.default_rng(7)
    for equality in (True, False):
        structured = random_structured(3)
        if not equality:
            structured = replace(structured, equality=None)
        u, y = 2 * rng.random(60) - 0.5, np.where(rng.random(60) < 0.5, 0, rng.normal(size=60))
        first, second = (
            certified(problem, u, y, iterations=1, rows_used=2, status=Convergence.STALLED)
            for problem in (structured, dense(structured))
        )
        for name in ("objective", "primal_residual", "dual_residual", "duality_gap"):
            assert getattr(first, name) > 0.1
            assert getattr(first, name) == pytest.approx(getattr(second, name), rel=1e-10)
        nu = first.equality_multiplier
        assert nu == pytest.approx(second.equality_multiplier, rel=1e-10, nan_ok=True)
        assert np.isnan(nu) == (not equality)
        assert (first.values == u).all()
        assert (first.multipliers == y).all()
        assert first.rows_used == second.rows_used == 2
    for entry in (4.0, -3.0):
        u = np.full(60, 0.5)
        u[7] = entry
        solution = certified(
            replace(structured, equality=None),
            u,
            np.zeros(60),
            iterations=1,
            rows_used=0,
            status=Convergence.STALLED,
        )
        assert solution.primal_residual == 3.0


def test_without_bounds_in_the_way_it_is_a_linear_system() -> None:
    problem = StructuredQuadratic(
        sparse_matrix=sparse.csr_array(sparse.diags_array([2.0, 4.0, 8.0])),
        low_rank=np.zeros((3, 0)),
        linear=-np.array([1.0, 1.0, 1.0]),
    )
    solution = active_sets(problem, np.full(3, 0.5))
    assert solution.values == pytest.approx([0.5, 0.25, 0.125])
    assert solution.iterations == 1


def test_baseline_descends_and_the_subspace_tends_to_it(cap_problem, bumpy_sphere, cap) -> None:
    region = full_region(cap_problem)
    assert region.status is Convergence.CONVERGED
    history = np.array(region.history)
    assert (np.diff(history) <= 1e-8 * history[:-1]).all()
    areas = cap_problem.vertex_areas
    assert areas @ np.abs(region.membership - cap) < 0.2 * cap_problem.part_area
    for quadratic, solution in (
        (full_membership_quadratic(cap_problem, region.phase_field), region.membership_solution),
        (full_phase_quadratic(cap_problem, region.membership), region.phase_solution),
    ):
        assert quadratic.value(solution.values) == pytest.approx(solution.objective, rel=1e-3)
        assert solution.dual_residual < 1e-8
    basis = eigenbasis(bumpy_sphere, 320)
    errors = []
    for size in (15, 80, 320):
        subspace = subspace_region(cap_problem, basis.truncated(size))
        errors.append(areas @ np.abs(subspace.membership - region.membership) / areas.sum())
    assert errors[0] > 2 * errors[1] > 4 * errors[2]
    assert errors[2] < 0.01
