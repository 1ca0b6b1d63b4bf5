"""Step 2 of the alternation in the span of a basis: the phase field for given memberships."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Floats
from sherd.energy.mumford_shah import gradient_weight
from sherd.energy.problem import RegionProblem
from sherd.spectral.basis import EigenBasis

__all__ = ["subspace_phase_fields"]


def subspace_phase_fields(
    problem: RegionProblem, basis: EigenBasis, memberships: Floats, before: Floats
) -> Floats:
    """Phase fields (n, c) in the span of the basis, clipped to [0, 1], for memberships (n, c).

    Minimizes paper equation 19 without its bounds, a k x k linear system per column, and clips.
    A column whose clipped answer has a higher energy than `before` (n, c) keeps `before`, so an
    alternation never rises. The bounds are rarely active: the unconstrained minimizer over all
    vertices obeys them by the maximum principle, and truncation overshoots by little.

    Notes
    -----
    Cost n k^2 per column; nothing of size n x n.
    """
    weights = problem.weights
    phi = basis.eigenvectors
    pull = weights.boundary / (4 * weights.phase_width) * problem.vertex_areas / problem.part_area
    stiff = weights.boundary * weights.phase_width * (phi.T @ (problem.stiffness @ phi))
    fixed = stiff + phi.T @ (pull[:, None] * phi)
    target = phi.T @ pull
    result = before.copy()
    for column in range(memberships.shape[1]):
        spring = 0.5 * weights.smoothness * gradient_weight(problem, memberships[:, column])
        matrix = fixed + phi.T @ (spring[:, None] * phi)
        field = np.clip(phi @ np.linalg.solve(matrix, target), 0.0, 1.0)
        if _phase_energy(problem, field, spring) <= _phase_energy(
            problem, before[:, column], spring
        ):
            result[:, column] = field
    return result


def _phase_energy(problem: RegionProblem, field: Floats, spring: Floats) -> float:
    weights = problem.weights
    gap = float(problem.vertex_areas @ (1 - field) ** 2) / problem.part_area
    slope = float(field @ (problem.stiffness @ field))
    width = weights.phase_width
    return float(spring @ field**2) + weights.boundary * (width * slope + gap / (4 * width))
