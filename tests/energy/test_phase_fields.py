"""Step 2 in the subspace for many memberships: the linear system, the clip, what is kept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sherd.energy.all_vertices import full_phase_quadratic
from sherd.energy.batched_energy import subspace_phase_fields
from sherd.energy.mumford_shah import energy
from sherd.energy.structured import solve_structured
from sherd.energy.subspace import basis_rows, phase_field_quadratic

# The ridge of the subspace program, 1e-7 of the mean curvature, moves the minimizer by 2e-6.
RIDGE_EFFECT = 1e-5


def unbounded(problem, basis, u) -> np.ndarray:
    """The same minimizer by the program of the subspace, its bounds left out."""
    rows = basis_rows(problem, basis)
    program = phase_field_quadratic(problem, rows, u)
    return rows @ np.linalg.solve(program.matrix, -program.linear)


def test_minimizer_for_every_column(cap_problem, sphere_basis, bumpy_sphere) -> None:
    problem = cap_problem.with_weights(replace(cap_problem.weights, smoothness=3.0))
    x, y, _ = bumpy_sphere.vertices.T
    memberships = np.stack([0.5 + 0.3 * x, 0.5 + 0.2 * np.sin(3 * y)], axis=1)
    before = np.zeros_like(memberships)
    fields = subspace_phase_fields(problem, sphere_basis, memberships, before)
    assert (before == 0).all()
    for u, field in zip(memberships.T, fields.T, strict=True):
        wanted = unbounded(problem, sphere_basis, u)
        assert 0 < wanted.min() < 0.9
        assert wanted.max() < 1  # no bound is in the way
        assert field == pytest.approx(wanted, abs=RIDGE_EFFECT)


def test_overshoot_is_clipped(cap_problem, sphere_basis, cap) -> None:
    problem = cap_problem.with_weights(replace(cap_problem.weights, phase_width=0.05))
    wanted = unbounded(problem, sphere_basis, cap)
    assert wanted.max() > 1.01
    before = np.zeros((len(cap), 1))
    field = subspace_phase_fields(problem, sphere_basis, cap[:, None], before)[:, 0]
    assert field == pytest.approx(np.clip(wanted, 0, 1), abs=RIDGE_EFFECT)


def test_a_better_field_is_kept(cap_problem, sphere_basis, cap) -> None:
    """The minimizer over all vertices is better than any in the subspace, rho = 1 is worse."""
    best = np.clip(solve_structured(full_phase_quadratic(cap_problem, cap)).values, 0, 1)
    flat = np.ones_like(best)
    fields = subspace_phase_fields(
        cap_problem, sphere_basis, np.stack([cap, cap], axis=1), np.stack([best, flat], axis=1)
    )
    assert (fields[:, 0] == best).all()
    totals = [energy(cap_problem, cap, field).total for field in (best, fields[:, 1], flat)]
    assert totals[0] < totals[1] < totals[2]
