"""The alternation over membership and phase field, whatever space the two steps work in."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sherd.arrays import Floats
from sherd.energy.convergence import Convergence
from sherd.energy.mumford_shah import EnergyTerms, energy
from sherd.energy.problem import RegionProblem
from sherd.energy.quadratic import QuadraticSolution
from sherd.errors import OptionError

__all__ = ["AlternatedRegion", "AlternationStep", "alternate"]

# Called with the other function (n,), held fixed, and this step's own function so far (None before
# the first membership); returns the next one (n,) and the solution it was made from.
AlternationStep = Callable[[Floats, Floats | None], tuple[Floats, QuadraticSolution]]


@dataclass(frozen=True, eq=False)
class AlternatedRegion:
    """Where an alternation ended, with its history.

    Attributes
    ----------
    membership
        u, (n,), clipped to [0, 1]; the solver's own violation is in `membership_solution`.
    phase_field
        rho, (n,), clipped to [0, 1].
    energy
        By terms, of the clipped functions.
    history
        Total energy after every membership step and every phase step, of the functions that the
        steps returned.
    iterations
        Alternations done.
    status
        CONVERGED when an alternation lowered the energy by less than the tolerance.
    membership_solution, phase_solution
        The last solutions of the two steps; `point` holds the coefficients (k,) in a subspace.
    """

    membership: Floats
    phase_field: Floats
    energy: EnergyTerms
    history: tuple[float, ...]
    iterations: int
    status: Convergence
    membership_solution: QuadraticSolution
    phase_solution: QuadraticSolution


def alternate(
    problem: RegionProblem,
    membership_step: AlternationStep,
    phase_step: AlternationStep,
    *,
    iterations: int,
    tolerance: float,
) -> AlternatedRegion:
    """Lower the energy in u and in rho by turns, starting with rho = 1.

    Parameters
    ----------
    problem
        The energy on n vertices.
    membership_step
        The membership for a phase field held fixed.
    phase_step
        The phase field for a membership held fixed.
    iterations
        Alternations at most.
    tolerance
        Relative decrease of the energy at which to stop.

    Raises
    ------
    OptionError
        If a number is out of range.
    """
    if iterations < 1:
        raise OptionError(f"iterations is {iterations}, but at least 1 is needed")
    if not (math.isfinite(tolerance) and tolerance >= 0):
        raise OptionError(f"tolerance is {tolerance}, but a finite number >= 0 is needed")
    before: Floats | None = None
    rho: Floats = np.ones(problem.vertex_count)
    history: list[float] = []
    status = Convergence.ITERATION_LIMIT
    for spent in range(1, iterations + 1):
        u, membership = membership_step(rho, before)
        before = u
        history.append(energy(problem, u, rho).total)
        rho, phase = phase_step(u, rho)
        history.append(energy(problem, u, rho).total)
        if spent > 1 and history[-3] - history[-1] <= tolerance * abs(history[-3]):
            status = Convergence.CONVERGED
            break
    failed = [s for s in (membership, phase) if s.status is not Convergence.CONVERGED]
    u, rho = np.clip(u, 0.0, 1.0), np.clip(rho, 0.0, 1.0)
    return AlternatedRegion(
        membership=u,
        phase_field=rho,
        energy=energy(problem, u, rho),
        history=tuple(history),
        iterations=spent,
        status=failed[0].status if failed else status,
        membership_solution=membership,
        phase_solution=phase,
    )
