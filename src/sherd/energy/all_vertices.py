"""The all-vertex baseline of Pokrass et al.: membership and phase field free at every vertex."""

from __future__ import annotations

import math

import numpy as np
from scipy import sparse

from sherd.arrays import Floats
from sherd.energy.alternation import AlternatedRegion, alternate
from sherd.energy.mumford_shah import phase_quadratic, smoothness_matrix
from sherd.energy.problem import RegionProblem
from sherd.energy.quadratic import QuadraticSolution, StructuredQuadratic
from sherd.energy.structured import solve_structured

__all__ = ["full_membership_quadratic", "full_phase_quadratic", "full_region"]


# Relative to the mean diagonal: makes the smoothness invertible on constants, and moves the
# objective by less than the solver's tolerance.
RIDGE = 1e-9


def full_region(
    problem: RegionProblem, *, iterations: int = 10, tolerance: float = 1e-4
) -> AlternatedRegion:
    """Membership and phase field by alternation over all n vertices, starting with rho = 1.

    Parameters
    ----------
    problem
        The energy on n vertices.
    iterations, tolerance
        When to stop, as in :func:`sherd.energy.alternation.alternate`.

    Raises
    ------
    OptionError
        If a number is out of range.

    References
    ----------
    Pokrass, Bronstein, Bronstein, *Partial shape matching without point-wise correspondence*,
    2013, as restated in equations 6, 7, 13 and 18 of the founding paper.
    """

    def membership_step(rho: Floats, before: Floats | None) -> tuple[Floats, QuadraticSolution]:
        solution = solve_structured(full_membership_quadratic(problem, rho), before)
        return np.clip(solution.values, 0.0, 1.0), solution

    def phase_step(u: Floats, before: Floats | None) -> tuple[Floats, QuadraticSolution]:
        solution = solve_structured(full_phase_quadratic(problem, u), before)
        return np.clip(solution.values, 0.0, 1.0), solution

    return alternate(
        problem, membership_step, phase_step, iterations=iterations, tolerance=tolerance
    )


def full_membership_quadratic(problem: RegionProblem, rho: Floats) -> StructuredQuadratic:
    """Step 1 over all vertices, paper equation 13 with its lost factor."""
    weights = problem.weights
    smooth = weights.regularity * weights.smoothness * smoothness_matrix(problem, rho)
    low_rank = math.sqrt(2.0) * problem.weighted_descriptors
    mean = (float(smooth.diagonal().sum()) + float((low_rank**2).sum())) / problem.vertex_count
    ridge = RIDGE * mean * sparse.eye_array(problem.vertex_count)
    return StructuredQuadratic(
        sparse_matrix=sparse.csr_array(smooth + ridge),
        low_rank=low_rank,
        linear=-2.0 * problem.data_linear - problem.weighted_evidence,
        equality=problem.vertex_areas,
        target=problem.part_area,
    )


def full_phase_quadratic(problem: RegionProblem, u: Floats) -> StructuredQuadratic:
    """Step 2 over all vertices, paper equation 18 with its lost plus signs."""
    matrix, linear, _ = phase_quadratic(problem, u)
    return StructuredQuadratic(
        sparse_matrix=sparse.csr_array(2.0 * matrix),
        low_rank=np.zeros((problem.vertex_count, 0)),
        linear=linear,
    )
