"""Solvers of all-vertex quadratic programs, whose matrix `S + V V'` is never formed densely.

Both share one kernel, the Woodbury solution of a bordered system:

- a primal-dual active set, exact when its sets repeat, warm-started along a continuation that
  lowers a multiple of S;
- an interior point method, slower and safe, used where the active sets cycle.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse

from sherd.arrays import Floats, Ints
from sherd.energy.convergence import Convergence
from sherd.energy.quadratic import QuadraticSolution, StructuredQuadratic, certified
from sherd.spectral.operators import factorized

__all__ = ["active_sets", "interior_point", "solve_structured"]


# A set that has not settled after this many changes is cycling: settled runs took 4 to 15.
MOST_SET_CHANGES = 30
# Continuation in the smoothness, coarse to true. A hundredfold smoothness leaves few vertices at
# their bounds, which the active set finds from a cold start; factors of about 3 keep it warm.
CONTINUATION = (100.0, 30.0, 10.0, 3.0, 1.0)
# Distance kept from the boundary of the feasible set in an interior point step.
STEP_BACK = 0.995


def solve_structured(
    problem: StructuredQuadratic, start: Floats | None = None
) -> QuadraticSolution:
    """The optimum: active sets from `start`, then with continuation, then an interior point.

    Parameters
    ----------
    problem
        The program.
    start
        (n,) membership whose bounds are the first guess of the active sets; none if None.

    Returns
    -------
    QuadraticSolution
        `rows_used` counts the vertices at a bound; `iterations` sum over everything tried.
    """
    spent = 0
    if start is not None:
        solution = active_sets(problem, start)
        spent += solution.iterations
        if solution.status is Convergence.CONVERGED:
            return solution
    guess = np.full(len(problem.linear), 0.5)
    for factor in CONTINUATION:
        eased = replace(problem, sparse_matrix=sparse.csr_array(factor * problem.sparse_matrix))
        solution = active_sets(eased, guess)
        spent += solution.iterations
        guess = np.clip(solution.values, 0.0, 1.0)
    if solution.status is not Convergence.CONVERGED:
        rough = interior_point(problem)
        spent += rough.iterations
        # the interior point ends near the bounds, the active set on them
        solution = active_sets(problem, rough.values, multipliers=rough.multipliers)
        spent += solution.iterations
        if solution.status is not Convergence.CONVERGED:
            solution = rough
    return replace(solution, iterations=spent)


def active_sets(
    problem: StructuredQuadratic, start: Floats, *, multipliers: Floats | None = None
) -> QuadraticSolution:
    """The optimum by the primal-dual active set method, if its sets settle.

    A vertex is held at 1 where `u - 1 + y / c > 0`, at 0 where `u + y / c < 0`, y the multiplier
    and c the diagonal of S, and free elsewhere; one bordered system gives the next u and y.

    References
    ----------
    Hintermueller, Ito, Kunisch, *The primal-dual active set strategy as a semismooth Newton
    method*, 2002, algorithm 1, with an equality and a low-rank term added.
    """
    scale = problem.sparse_matrix.diagonal()
    scale = scale + np.einsum("nd,nd->n", problem.low_rank, problem.low_rank)
    u = np.array(start)
    y = np.zeros_like(u) if multipliers is None else np.array(multipliers)
    side = _sides(u, y, scale)
    status, spent = Convergence.STALLED, 0
    while spent < MOST_SET_CHANGES:
        spent += 1
        u, y = _on_sets(problem, side)
        next_side = _sides(u, y, scale)
        if (next_side == side).all():
            status = Convergence.CONVERGED
            break
        if not (next_side == 0).any():
            break
        side = next_side
    at_bounds = int(np.count_nonzero(y))
    return certified(problem, u, y, iterations=spent, rows_used=at_bounds, status=status)


def interior_point(
    problem: StructuredQuadratic, *, tolerance: float = 1e-9, iterations: int = 80
) -> QuadraticSolution:
    """The optimum by Mehrotra's predictor-corrector method; each step one sparse factorization.

    References
    ----------
    Nocedal and Wright, *Numerical Optimization*, 2006, section 16.6, algorithm 16.4.
    """
    count = len(problem.linear)
    level = 0.5
    if problem.equality is not None:
        level = min(max(problem.target / float(problem.equality.sum()), 0.01), 0.99)
    u, nu = np.full(count, level), 0.0
    size = float(np.abs(problem.slope(u)).mean()) + 1e-300
    low, high = np.full(count, size), np.full(count, size)
    status, spent = Convergence.ITERATION_LIMIT, 0
    reference = float(np.abs(problem.linear).max())
    while spent < iterations:
        spent += 1
        residual = problem.slope(u) - low + high
        defect = 0.0
        if problem.equality is not None:
            residual = residual + nu * problem.equality
            defect = float(problem.equality @ u) - problem.target
        mu = float(low @ u + high @ (1 - u)) / (2 * count)
        small = tolerance * reference
        if mu <= small and np.abs(residual).max() <= small:
            status = Convergence.CONVERGED
            break
        kernel = _Bordered(problem, np.arange(count), low / u + high / (1 - u))
        pair_low, pair_high = low * u, high * (1 - u)
        corrections = (np.zeros(count), np.zeros(count))
        aim = 0.0
        for attempt in range(2):
            push = (aim - pair_low - corrections[0]) / u - (aim - pair_high - corrections[1]) / (
                1 - u
            )
            du, dnu = kernel.solve(-residual + push, -defect)
            dlow = (aim - pair_low - corrections[0] - low * du) / u
            dhigh = (aim - pair_high - corrections[1] + high * du) / (1 - u)
            primal = min(_longest(u, du), _longest(1 - u, -du))
            dual = min(_longest(low, dlow), _longest(high, dhigh))
            if attempt == 0:
                after = (low + dual * dlow) @ (u + primal * du)
                after += (high + dual * dhigh) @ (1 - u - primal * du)
                aim = mu * (float(after) / (2 * count) / mu) ** 3
                corrections = (dlow * du, -dhigh * du)
        step = min(1.0, STEP_BACK * primal), min(1.0, STEP_BACK * dual)
        u, nu = u + step[0] * du, nu + step[1] * dnu
        low, high = low + step[1] * dlow, high + step[1] * dhigh
    y = high - low
    at_bounds = int(np.count_nonzero(y))
    return certified(problem, u, y, iterations=spent, rows_used=at_bounds, status=status)


class _Bordered:
    """Solves `(S_FF + diag + V_F V_F') x + nu a_F = r`, `a_F x = t` for the free vertices F."""

    def __init__(self, problem: StructuredQuadratic, free: Ints, diagonal: Floats | None) -> None:
        block = problem.sparse_matrix
        if len(free) < block.shape[0]:
            block = block[free][:, free]
        if diagonal is not None:
            block = block + sparse.diags_array(diagonal)
        factor = factorized(sparse.csc_array(block))
        border = problem.low_rank[free]
        self._rank = border.shape[1]
        if problem.equality is not None:
            border = np.column_stack([border, problem.equality[free]])
        self._border, self._factor = border, factor
        self._inverse_border = factor.solve(border) if border.shape[1] else border
        core = border.T @ self._inverse_border
        core[np.arange(self._rank), np.arange(self._rank)] += 1.0
        self._core = core

    def solve(self, right: Floats, target: float) -> tuple[Floats, float]:
        """Solution x and multiplier nu; `target` is the value of `a_F x`."""
        plain = self._factor.solve(right)
        if self._border.shape[1] == 0:
            return plain, 0.0
        wanted = self._border.T @ plain
        if self._border.shape[1] > self._rank:
            wanted[-1] -= target
        weights = np.linalg.solve(self._core, wanted)
        x: Floats = plain - self._inverse_border @ weights
        return x, float(weights[-1]) if self._border.shape[1] > self._rank else 0.0


def _on_sets(problem: StructuredQuadratic, side: Ints) -> tuple[Floats, Floats]:
    """Minimizer with the vertices of side +1 and -1 held at 1 and 0, and the multipliers."""
    u = (side > 0).astype(np.float64)
    free = np.flatnonzero(side == 0)
    nu = 0.0
    if len(free):
        target = 0.0
        if problem.equality is not None:
            target = problem.target - float(problem.equality @ u)
        kernel = _Bordered(problem, free, None)
        u[free], nu = kernel.solve(-problem.slope(u)[free], target)
    y = -problem.slope(u)
    if problem.equality is not None:
        y -= nu * problem.equality
    y[free] = 0.0
    return u, y


def _sides(u: Floats, y: Floats, scale: Floats) -> Ints:
    shifted = u + y / scale
    # rounding must not move a vertex that sits on its bound with a multiplier of zero
    return (shifted > 1 + 1e-12).astype(np.int64) - (shifted < -1e-12).astype(np.int64)


def _longest(values: Floats, change: Floats) -> float:
    """Largest step in (0, 1 / STEP_BACK] that keeps `values + step * change` not negative."""
    falling = change < 0
    if not falling.any():
        return 1.0 / STEP_BACK
    return min(1.0 / STEP_BACK, float((-values[falling] / change[falling]).min()))
