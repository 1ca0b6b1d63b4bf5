"""Many memberships (n, c) at once: their energy with its gradient, and their phase fields."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sherd.arrays import Floats
from sherd.energy.mumford_shah import gradient_weight
from sherd.energy.problem import RegionProblem
from sherd.spectral.basis import EigenBasis

__all__ = ["BatchedEnergy", "subspace_phase_fields"]

Reals = NDArray[Any]  # float32 or float64, as the batch was made


class BatchedEnergy:
    """Energy of the columns of (n, c) memberships for fixed phase fields.

    The integral of rho^2 |grad u|^2 is written over edges, `sum_e w_e(rho) (u_i - u_j)^2`, with
    `w = M rho^2` linear in rho^2; this equals u' K(rho) u of :mod:`sherd.energy.mumford_shah`.

    Parameters
    ----------
    problem
        The energy.
    dtype
        float32 halves the time; its rounding, about 1e-6 of the energy, is harmless in a search
        that is polished in float64.
    """

    def __init__(self, problem: RegionProblem, dtype: Any = np.float64) -> None:
        self.problem = problem
        self.dtype = np.dtype(dtype)
        self.areas = problem.vertex_areas.astype(dtype)[:, None]
        self._descriptors = problem.weighted_descriptors.astype(dtype)
        self._integral = problem.part_integral.astype(dtype)[:, None]
        self._edges = problem.edges.of_type(dtype)
        gain = problem.weighted_evidence.astype(dtype)[:, None]
        self._gain = gain if problem.evidence.any() else None

    def edge_weights(self, phase_fields: Reals) -> Reals:
        """Edge weights w (e, c) of phase fields (n, c)."""
        weights: Reals = self._edges.spread @ np.asarray(phase_fields**2, dtype=self.dtype)
        return weights

    def gradient_weights(self, memberships: Reals) -> Reals:
        """Diagonals of S(u), (n, c)."""
        jumps = self._edges.difference @ memberships
        return np.asarray(self._edges.spread_transposed @ jumps**2)

    def __call__(
        self, memberships: Reals, edge_weights: Reals, crispness: float
    ) -> tuple[Floats, Reals]:
        """Values (c,) without the boundary term, and gradients (n, c) in the memberships.

        `crispness` times `4 / s * integral u (1 - u)` is added: at most `crispness * 1` for a part
        whose membership is 1/2 everywhere it is not 0, and zero for a crisp region.
        """
        weights, area = self.problem.weights, self.problem.part_area
        residuals = self._descriptors.T @ memberships - self._integral
        values = (residuals**2).sum(axis=0, dtype=np.float64)
        slopes = self._descriptors @ (2.0 * residuals).astype(self.dtype)
        factor = weights.regularity * weights.smoothness
        if factor > 0:
            jumps = self._edges.difference @ memberships
            flux = edge_weights * jumps
            values += 0.5 * factor * (flux * jumps).sum(axis=0, dtype=np.float64)
            slopes += self.dtype.type(factor) * (self._edges.difference_transposed @ flux)
        if crispness > 0:
            scaled = self.dtype.type(4.0 * crispness / area) * self.areas
            values += (scaled * memberships * (1 - memberships)).sum(axis=0, dtype=np.float64)
            slopes += scaled * (1 - 2 * memberships)
        if self._gain is not None:
            values -= (self._gain * memberships).sum(axis=0, dtype=np.float64)
            slopes -= self._gain
        return values, slopes


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
