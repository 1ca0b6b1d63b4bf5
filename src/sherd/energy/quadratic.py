"""The quadratic programs in the subspace and over all vertices; a solution proves itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from sherd.arrays import Floats
from sherd.energy.convergence import Convergence

__all__ = ["BoundedQuadratic", "QuadraticSolution", "StructuredQuadratic", "certified"]


@dataclass(frozen=True, eq=False)
class BoundedQuadratic:
    """Minimize `x'M x / 2 + l.x` subject to `0 <= rows x <= 1` and, if given, `e.x = target`.

    Attributes
    ----------
    matrix
        M, (k, k) symmetric positive definite.
    linear
        l, (k,).
    rows
        (n, k): the functions' values at the vertices.
    row_weights
        (n,) positive, summing to 1: what a violation at each row counts in a penalty, here
        vertex areas over total area.
    equality
        e, (k,), or None.
    target
        Value of `e.x`; unused without `equality`.
    """

    matrix: Floats
    linear: Floats
    rows: Floats
    row_weights: Floats
    equality: Floats | None = None
    target: float = 0.0

    def value(self, point: Floats) -> float:
        """Objective at `point` (k,)."""
        return float(0.5 * point @ (self.matrix @ point) + self.linear @ point)

    def slope(self, point: Floats) -> Floats:
        """Gradient (k,) of the objective."""
        product: Floats = self.matrix @ point
        return product + self.linear

    def row_values(self, point: Floats) -> Floats:
        """`rows x`, (n,), what the bounds hold."""
        values: Floats = self.rows @ point
        return values

    def row_slope(self, multipliers: Floats) -> Floats:
        """`rows' multipliers`, (k,), for multipliers (n,) most of which are 0."""
        active = np.flatnonzero(multipliers)
        slope: Floats = self.rows[active].T @ multipliers[active]
        return slope


@dataclass(frozen=True, eq=False)
class StructuredQuadratic:
    """Minimize `u' (S + V V') u / 2 + h.u` subject to `0 <= u <= 1` and, if given, `a.u = s`.

    Attributes
    ----------
    sparse_matrix
        S, (n, n) sparse, symmetric positive definite.
    low_rank
        V, (n, d); d may be 0.
    linear
        h, (n,).
    equality
        a, (n,) positive, or None.
    target
        s; unused without `equality`.
    """

    sparse_matrix: sparse.csr_array
    low_rank: Floats
    linear: Floats
    equality: Floats | None = None
    target: float = 0.0

    def value(self, point: Floats) -> float:
        """Objective at `point` (n,)."""
        return float(0.5 * point @ (self.slope(point) + self.linear))

    def slope(self, point: Floats) -> Floats:
        """Gradient (n,) of the objective."""
        product: Floats = self.sparse_matrix @ point + self.low_rank @ (self.low_rank.T @ point)
        return product + self.linear

    def row_values(self, point: Floats) -> Floats:
        """The point itself: each entry is bounded."""
        return point

    def row_slope(self, multipliers: Floats) -> Floats:
        """The multipliers themselves."""
        return multipliers


@dataclass(frozen=True, eq=False)
class QuadraticSolution:
    """An answer with its optimality conditions.

    Attributes
    ----------
    point
        x, (k,).
    values
        (n,), rows x.
    multipliers
        (n,), positive where the upper bound holds x back, negative where the lower one does.
    equality_multiplier
        nu of `M x + l + rows' multipliers + nu e = 0`; NaN without equality.
    objective
        `x'M x / 2 + l.x`.
    primal_residual
        Largest violation of a bound, or of the equality relative to its target.
    dual_residual
        Largest entry of `M x + l + rows' multipliers + nu e`, relative to the largest of l.
    duality_gap
        `|x'M x + l.x + sum of positive multipliers + nu target|` relative to `1 + |objective|`.
    iterations
        Of the solver, in its own measure.
    rows_used
        Bound rows the solver ever looked at as constraints.
    status
        Why it stopped.
    """

    point: Floats
    values: Floats
    multipliers: Floats
    equality_multiplier: float
    objective: float
    primal_residual: float
    dual_residual: float
    duality_gap: float
    iterations: int
    rows_used: int
    status: Convergence


def certified(
    problem: BoundedQuadratic | StructuredQuadratic,
    point: Floats,
    multipliers: Floats,
    *,
    iterations: int,
    rows_used: int,
    status: Convergence,
) -> QuadraticSolution:
    """The answer with residuals computed here, not taken from the solver.

    Parameters
    ----------
    problem
        What was solved.
    point, multipliers
        (k,) and (n,), the solver's. The multiplier of the equality is the one that leaves the
        smallest residual, by least squares.
    """
    values = problem.row_values(point)
    slope = problem.slope(point)
    stationarity = slope + problem.row_slope(multipliers)
    primal = max(float(values.max() - 1.0), float(-values.min()), 0.0)
    nu, offset = np.nan, 0.0
    if problem.equality is not None:
        e = problem.equality
        nu = -float(e @ stationarity) / float(e @ e)
        stationarity = stationarity + nu * e
        primal = max(primal, abs(float(e @ point) - problem.target) / abs(problem.target))
        offset = nu * problem.target
    objective = problem.value(point)
    gap = float(point @ slope) + float(np.maximum(multipliers, 0.0).sum()) + offset
    return QuadraticSolution(
        point=point,
        values=values,
        multipliers=multipliers,
        equality_multiplier=nu,
        objective=objective,
        primal_residual=primal,
        dual_residual=float(np.abs(stationarity).max() / np.abs(problem.linear).max()),
        duality_gap=abs(gap) / (1.0 + abs(objective)),
        iterations=iterations,
        rows_used=rows_used,
        status=status,
    )
