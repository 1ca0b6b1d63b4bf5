"""The founding paper: membership and phase field in the span of k eigenvectors (Algorithm 1)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sherd.arrays import Floats
from sherd.energy.convergence import Convergence
from sherd.energy.mumford_shah import (
    EnergyTerms,
    energy,
    phase_quadratic,
    smoothness_matrix,
)
from sherd.energy.problem import RegionProblem
from sherd.energy.quadratic import BoundedQuadratic, QuadraticSolution
from sherd.energy.solvers import solver_named
from sherd.errors import InputError, OptionError
from sherd.spectral.basis import EigenBasis

__all__ = [
    "SubspaceRegion",
    "basis_rows",
    "membership_quadratic",
    "phase_field_quadratic",
    "subspace_region",
]


# Relative to the mean curvature, so that a data term of rank d < k with little regularity still
# has one answer (of the many that are equally good, the one near the least norm); it moves the
# objective by about 1e-8 of itself. Below 1e-8 DAQP, which factorizes the matrix, gets lost in the
# nearly singular directions (4 of 120 programs); at 1e-7 none did.
RIDGE = 1e-7


@dataclass(frozen=True, eq=False)
class SubspaceRegion:
    """What Algorithm 1 returns, with its history.

    Attributes
    ----------
    membership
        u, (n,), clipped to [0, 1]; the solver's own violation is in `membership_solution`.
    phase_field
        rho, (n,), clipped to [0, 1].
    membership_coefficients, phase_coefficients
        alpha, beta, (k,), of eigenvectors times sqrt(area).
    energy
        By terms, of the clipped functions.
    history
        Total energy after every membership step and every phase step, unclipped functions.
    iterations
        Alternations done.
    status
        CONVERGED when an alternation lowered the energy by less than the tolerance.
    membership_solution, phase_solution
        The last solutions of the two steps.
    """

    membership: Floats
    phase_field: Floats
    membership_coefficients: Floats
    phase_coefficients: Floats
    energy: EnergyTerms
    history: tuple[float, ...]
    iterations: int
    status: Convergence
    membership_solution: QuadraticSolution
    phase_solution: QuadraticSolution


def subspace_region(
    problem: RegionProblem,
    basis: EigenBasis,
    *,
    solver: str = "active-set",
    iterations: int = 10,
    tolerance: float = 1e-4,
) -> SubspaceRegion:
    """Membership and phase field by Algorithm 1 of the paper.

    Alternates the two convex programs, starting with rho = 1, until the energy falls by less
    than `tolerance` of itself.

    Parameters
    ----------
    problem
        The energy on n vertices.
    basis
        First k eigenpairs of the same mesh.
    solver
        `"quadratic-program"`, `"augmented-lagrangian"` or `"active-set"`.
    iterations
        Alternations at most.
    tolerance
        Relative decrease at which to stop.

    Raises
    ------
    OptionError
        If the solver is unknown or a number is out of range.
    InputError
        If the basis belongs to another mesh.
    """
    solve = solver_named(solver)
    if iterations < 1:
        raise OptionError(f"iterations is {iterations}, but at least 1 is needed")
    if not tolerance >= 0:
        raise OptionError(f"tolerance is {tolerance}, but a number >= 0 is needed")
    rows = basis_rows(problem, basis)
    data = rows.T @ problem.weighted_descriptors
    rho = np.ones(problem.vertex_count)
    history: list[float] = []
    status = Convergence.ITERATION_LIMIT
    for spent in range(1, iterations + 1):
        membership = solve(membership_quadratic(problem, rows, rho, data=data))
        u = membership.values
        history.append(energy(problem, u, rho).total)
        phase = solve(phase_field_quadratic(problem, rows, u))
        rho = phase.values
        history.append(energy(problem, u, rho).total)
        if spent > 1 and history[-3] - history[-1] <= tolerance * abs(history[-3]):
            status = Convergence.CONVERGED
            break
    failed = [s for s in (membership, phase) if s.status is not Convergence.CONVERGED]
    u, rho = np.clip(u, 0.0, 1.0), np.clip(rho, 0.0, 1.0)
    return SubspaceRegion(
        membership=u,
        phase_field=rho,
        membership_coefficients=membership.point,
        phase_coefficients=phase.point,
        energy=energy(problem, u, rho),
        history=tuple(history),
        iterations=spent,
        status=failed[0].status if failed else status,
        membership_solution=membership,
        phase_solution=phase,
    )


def membership_quadratic(
    problem: RegionProblem, rows: Floats, rho: Floats, *, data: Floats | None = None
) -> BoundedQuadratic:
    """Step 1, paper equation 14 with its lost factor: the program for alpha with rho fixed.

    Parameters
    ----------
    problem
        The energy.
    rows
        (n, k), eigenvectors times sqrt(area).
    rho
        (n,) phase field.
    data
        `rows' A P / |q|`, (k, d), if at hand; it does not change during an alternation.
    """
    weights = problem.weights
    if data is None:
        data = rows.T @ problem.weighted_descriptors
    factor = weights.regularity * weights.smoothness
    matrix = 2.0 * (data @ data.T) + factor * (rows.T @ (smoothness_matrix(problem, rho) @ rows))
    gain = problem.vertex_areas * problem.evidence / problem.part_area
    return BoundedQuadratic(
        matrix=_ridged(matrix),
        linear=-2.0 * (data @ problem.part_integral) - rows.T @ gain,
        rows=rows,
        row_weights=problem.vertex_areas / problem.area,
        equality=rows.T @ problem.vertex_areas,
        target=problem.part_area,
    )


def phase_field_quadratic(problem: RegionProblem, rows: Floats, u: Floats) -> BoundedQuadratic:
    """Step 2, paper equation 19 with its lost plus signs: the program for beta with u fixed."""
    sparse_matrix, linear, _ = phase_quadratic(problem, u)
    return BoundedQuadratic(
        matrix=_ridged(2.0 * (rows.T @ (sparse_matrix @ rows))),
        linear=rows.T @ linear,
        rows=rows,
        row_weights=problem.vertex_areas / problem.area,
    )


def basis_rows(problem: RegionProblem, basis: EigenBasis) -> Floats:
    """Eigenvectors times sqrt(area), (n, k): mean square 1, so values and coefficients compare.

    Raises
    ------
    InputError
        If the basis belongs to another mesh.
    """
    if len(basis.eigenvectors) != problem.vertex_count:
        raise InputError(
            f"the basis has {len(basis.eigenvectors)} vertices, the problem {problem.vertex_count}"
        )
    rows: Floats = np.ascontiguousarray(basis.eigenvectors * math.sqrt(problem.area))
    return rows


def _ridged(matrix: Floats) -> Floats:
    ridge = RIDGE * float(np.trace(matrix)) / len(matrix)
    return 0.5 * (matrix + matrix.T) + ridge * np.eye(len(matrix))
