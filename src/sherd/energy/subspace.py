"""The founding paper: membership and phase field in the span of k eigenvectors (Algorithm 1)."""

from __future__ import annotations

import math

import numpy as np

from sherd.arrays import Floats
from sherd.energy.alternation import AlternatedRegion, alternate
from sherd.energy.mumford_shah import phase_quadratic, smoothness_matrix
from sherd.energy.problem import RegionProblem
from sherd.energy.quadratic import BoundedQuadratic, QuadraticSolution
from sherd.energy.solvers import solver_named
from sherd.errors import InputError
from sherd.spectral.basis import EigenBasis

__all__ = ["basis_rows", "membership_quadratic", "phase_field_quadratic", "subspace_region"]


# Relative to the mean curvature, so that a data term of rank d < k with little regularity still
# has one answer (of the many that are equally good, the one near the least norm); it moves the
# objective by about 1e-8 of itself. Below 1e-8 DAQP, which factorizes the matrix, gets lost in the
# nearly singular directions (4 of 120 programs); at 1e-7 none did.
RIDGE = 1e-7


def subspace_region(
    problem: RegionProblem,
    basis: EigenBasis,
    *,
    solver: str = "active-set",
    iterations: int = 10,
    tolerance: float = 1e-4,
) -> AlternatedRegion:
    """Membership and phase field by Algorithm 1 of the paper.

    Parameters
    ----------
    problem
        The energy on n vertices.
    basis
        First k eigenpairs of the same mesh.
    solver
        `"quadratic-program"`, `"augmented-lagrangian"` or `"active-set"`.
    iterations, tolerance
        When to stop, as in :func:`sherd.energy.alternation.alternate`.

    Raises
    ------
    OptionError
        If the solver is unknown or a number is out of range.
    InputError
        If the basis belongs to another mesh.
    """
    solve = solver_named(solver)
    rows = basis_rows(problem, basis)
    data = rows.T @ problem.weighted_descriptors

    def membership_step(rho: Floats, _: Floats | None) -> tuple[Floats, QuadraticSolution]:
        solution = solve(membership_quadratic(problem, rows, rho, data=data))
        return solution.values, solution

    def phase_step(u: Floats, _: Floats | None) -> tuple[Floats, QuadraticSolution]:
        solution = solve(phase_field_quadratic(problem, rows, u))
        return solution.values, solution

    return alternate(
        problem, membership_step, phase_step, iterations=iterations, tolerance=tolerance
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
    return BoundedQuadratic(
        matrix=_ridged(matrix),
        linear=-2.0 * (data @ problem.part_integral) - rows.T @ problem.weighted_evidence,
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
