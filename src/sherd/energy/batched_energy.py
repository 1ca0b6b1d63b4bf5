"""The energy of many memberships at once, with its gradient: products over (n, c) blocks."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from sherd.arrays import Floats
from sherd.energy.problem import RegionProblem

__all__ = ["BatchedEnergy"]

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
        difference, spread = _edge_operators(problem)
        self._difference = difference.astype(dtype)
        self._difference_transposed = sparse.csr_array(self._difference.T)
        self._spread = spread.astype(dtype)
        self._spread_transposed = sparse.csr_array(self._spread.T)
        gain = problem.vertex_areas * problem.evidence / problem.part_area
        self._gain = gain.astype(dtype)[:, None] if problem.evidence.any() else None

    def edge_weights(self, phase_fields: Reals) -> Reals:
        """Edge weights w (e, c) of phase fields (n, c)."""
        weights: Reals = self._spread @ np.asarray(phase_fields**2, dtype=self.dtype)
        return weights

    def gradient_weights(self, memberships: Reals) -> Reals:
        """Diagonals of S(u), (n, c)."""
        jumps = self._difference @ memberships
        return np.asarray(self._spread_transposed @ jumps**2)

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
            jumps = self._difference @ memberships
            flux = edge_weights * jumps
            values += 0.5 * factor * (flux * jumps).sum(axis=0, dtype=np.float64)
            slopes += self.dtype.type(factor) * (self._difference_transposed @ flux)
        if crispness > 0:
            scaled = self.dtype.type(4.0 * crispness / area) * self.areas
            values += (scaled * memberships * (1 - memberships)).sum(axis=0, dtype=np.float64)
            slopes += scaled * (1 - 2 * memberships)
        if self._gain is not None:
            values -= (self._gain * memberships).sum(axis=0, dtype=np.float64)
            slopes -= self._gain
        return values, slopes


def _edge_operators(problem: RegionProblem) -> tuple[sparse.csr_array, sparse.csr_array]:
    """Differences along edges (e, n), and M (e, n) with `w = M rho^2`."""
    faces, count = problem.faces, problem.vertex_count
    first, second = faces[:, [1, 2, 0]].ravel(), faces[:, [2, 0, 1]].ravel()
    keys = np.minimum(first, second) * count + np.maximum(first, second)
    unique, edge_of = np.unique(keys, return_inverse=True)
    rows = np.repeat(np.arange(len(unique)), 2)
    ends = np.stack([unique // count, unique % count], axis=1).ravel()
    signs = np.tile([1.0, -1.0], len(unique))
    difference = sparse.coo_array((signs, (rows, ends)), shape=(len(unique), count))
    thirds = np.repeat(problem.corner_weights.ravel() / 3.0, 3)
    corners = np.repeat(faces, 3, axis=0).ravel()  # every corner of the face feeds its three edges
    spread = sparse.coo_array(
        (thirds, (np.repeat(edge_of, 3), corners)), shape=(len(unique), count)
    )
    return sparse.csr_array(difference), sparse.csr_array(spread)
