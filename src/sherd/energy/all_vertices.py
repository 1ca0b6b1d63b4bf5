"""The all-vertex baseline of Pokrass et al.: membership and phase field free at every vertex."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from sherd.arrays import Floats
from sherd.energy.convergence import Convergence
from sherd.energy.mumford_shah import EnergyTerms, energy, phase_quadratic, smoothness_matrix
from sherd.energy.problem import RegionProblem
from sherd.energy.quadratic import QuadraticSolution
from sherd.energy.structured import StructuredQuadratic, solve_structured
from sherd.errors import OptionError

__all__ = ["FullRegion", "full_membership_quadratic", "full_phase_quadratic", "full_region"]


# Relative to the mean diagonal: makes the smoothness invertible on constants, and moves the
# objective by less than the solver's tolerance.
RIDGE = 1e-9


@dataclass(frozen=True, eq=False)
class FullRegion:
    """The baseline's answer.

    Attributes
    ----------
    membership
        u, (n,) in [0, 1].
    phase_field
        rho, (n,) in [0, 1].
    energy
        By terms.
    history
        Total energy after every membership step and every phase step.
    iterations
        Alternations done.
    status
        CONVERGED when an alternation lowered the energy by less than the tolerance.
    membership_solution, phase_solution
        The last solutions of the two steps.
    """

    membership: Floats
    phase_field: Floats
    energy: EnergyTerms
    history: tuple[float, ...]
    iterations: int
    status: Convergence
    membership_solution: QuadraticSolution
    phase_solution: QuadraticSolution


def full_region(
    problem: RegionProblem, *, iterations: int = 10, tolerance: float = 1e-4
) -> FullRegion:
    """Membership and phase field by alternation over all n vertices, starting with rho = 1.

    Parameters
    ----------
    problem
        The energy on n vertices.
    iterations
        Alternations at most.
    tolerance
        Relative decrease of the energy at which to stop.

    Raises
    ------
    OptionError
        If a number is out of range.

    References
    ----------
    Pokrass, Bronstein, Bronstein, *Partial shape matching without point-wise correspondence*,
    2013, as restated in equations 6, 7, 13 and 18 of the founding paper.
    """
    if iterations < 1:
        raise OptionError(f"iterations is {iterations}, but at least 1 is needed")
    if not (math.isfinite(tolerance) and tolerance >= 0):
        raise OptionError(f"tolerance is {tolerance}, but a number >= 0 is needed")
    start, rho = None, np.ones(problem.vertex_count)
    history: list[float] = []
    status, spent = Convergence.ITERATION_LIMIT, 0
    while spent < iterations:
        spent += 1
        membership = solve_structured(full_membership_quadratic(problem, rho), start)
        u = start = np.clip(membership.values, 0.0, 1.0)
        history.append(energy(problem, u, rho).total)
        phase = solve_structured(full_phase_quadratic(problem, u), rho)
        rho = np.clip(phase.values, 0.0, 1.0)
        history.append(energy(problem, u, rho).total)
        if spent > 1 and history[-3] - history[-1] <= tolerance * abs(history[-3]):
            status = Convergence.CONVERGED
            break
    failed = [s for s in (membership, phase) if s.status is not Convergence.CONVERGED]
    return FullRegion(
        membership=u,
        phase_field=rho,
        energy=energy(problem, u, rho),
        history=tuple(history),
        iterations=spent,
        status=failed[0].status if failed else status,
        membership_solution=membership,
        phase_solution=phase,
    )


def full_membership_quadratic(problem: RegionProblem, rho: Floats) -> StructuredQuadratic:
    """Step 1 over all vertices, paper equation 13 with its lost factor."""
    weights = problem.weights
    smooth = weights.regularity * weights.smoothness * smoothness_matrix(problem, rho)
    gain = problem.vertex_areas * problem.evidence / problem.part_area
    low_rank = math.sqrt(2.0) * problem.weighted_descriptors
    mean = (float(smooth.diagonal().sum()) + float((low_rank**2).sum())) / problem.vertex_count
    ridge = RIDGE * mean * sparse.eye_array(problem.vertex_count)
    return StructuredQuadratic(
        sparse_matrix=sparse.csr_array(smooth + ridge),
        low_rank=low_rank,
        linear=-2.0 * problem.data_linear - gain,
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
