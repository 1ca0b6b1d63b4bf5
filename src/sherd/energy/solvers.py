"""Three solvers of the subspace problem: quadratic program, augmented Lagrangian, active set.

All three take a :class:`BoundedQuadratic` and return a :class:`QuadraticSolution` whose residuals
are computed alike, so they can be compared on the same problem. The witnesses of the optional
extra (PIQP, Clarabel) are in :mod:`sherd.benchmark.paper.witness`.
"""

from __future__ import annotations

from collections.abc import Callable

import daqp
import numpy as np
from scipy import linalg

from sherd.arrays import Bools, Floats, Ints
from sherd.energy.convergence import Convergence
from sherd.energy.quadratic import BoundedQuadratic, QuadraticSolution, certified
from sherd.errors import OptionError

__all__ = [
    "SOLVERS",
    "active_set",
    "augmented_lagrangian",
    "quadratic_program",
    "solver_named",
]


# Feasibility asked of the library. Memberships are read to 1e-6 at best.
ROW_TOLERANCE = 1e-9
# The usual pair: unless violation falls to a quarter, the penalty grows tenfold (Nocedal and Wright
# 2006, framework 17.3). Multipliers concentrate on few rows, which an area-weighted penalty of
# fixed size reaches only slowly.
SUFFICIENT_PROGRESS, PENALTY_GROWTH = 0.25, 10.0
EQUALITY_ROW, INEQUALITY_ROW, ACTIVE_ROW = 5, 0, 1  # daqp's row kinds


def quadratic_program(problem: BoundedQuadratic) -> QuadraticSolution:
    """The optimum by a general solver that is given every bound row at once.

    DAQP, a dual active-set method; `iterations` are its pivots.

    References
    ----------
    Arnstrom, Bemporad, Axehill, *A dual active-set solver for embedded quadratic programming
    using recursive LDL' updates*, 2022.
    """
    every = np.arange(len(problem.rows))
    point, multipliers, iterations, status = _daqp(problem, every, None)
    return certified(
        problem,
        point,
        multipliers,
        iterations=iterations,
        rows_used=len(every),
        status=status,
    )


def active_set(problem: BoundedQuadratic, *, rounds: int = 60) -> QuadraticSolution:
    """The same optimum by column generation: start without bound rows, add violated ones.

    The dual of a bound row is a column, hence the name. Each round solves the quadratic program
    with the rows gathered so far (DAQP) and looks once at all n values. The objective cannot
    fall from round to round, and an answer that violates nothing is the optimum of the whole.
    `iterations` are rounds.

    Parameters
    ----------
    problem
        The program.
    rounds
        Rounds at most; beyond, the status is ITERATION_LIMIT and the answer violates bounds by
        `primal_residual`.

    Notes
    -----
    Of each round's violated rows the worst k are taken, and beyond them an even sample by
    rank: neighboring vertices have nearly the same row, and a sample reaches every overshoot.
    """
    size = problem.rows.shape[1]
    chosen = np.empty(0, dtype=np.int64)
    multipliers = np.zeros(len(problem.rows))
    status = Convergence.ITERATION_LIMIT
    spent = 0
    while spent < rounds:
        spent += 1
        point, multipliers, _, inner = _daqp(problem, chosen, multipliers[chosen])
        if inner is not Convergence.CONVERGED:
            status = inner
            break
        values = problem.rows @ point
        violation = np.maximum(values - 1.0, -values)
        violated = np.flatnonzero(violation > ROW_TOLERANCE)
        violated = np.setdiff1d(violated, chosen, assume_unique=True)
        if len(violated) == 0:
            status = Convergence.CONVERGED
            break
        order = violated[np.argsort(-violation[violated], kind="stable")]
        stride = max(1, (len(order) - size) // size)
        added = np.concatenate([order[:size], order[size::stride]])
        chosen = np.union1d(chosen, added)
    return certified(
        problem, point, multipliers, iterations=spent, rows_used=len(chosen), status=status
    )


def augmented_lagrangian(
    problem: BoundedQuadratic, *, tolerance: float = 1e-5, iterations: int = 200
) -> QuadraticSolution:
    """The paper's second solver: bounds and area by multipliers, free minimization between.

    Minimizes `f(x) + nu (e.x - t) + mu/2 (e.x - t)^2 + mu/2 sum_i w_i (max(0, v_i - 1 + y_i)^2
    + max(0, z_i - v_i)^2)` with `v = rows x` by semismooth Newton, then `y += v - 1` and
    `z -= v`, both cut at 0. With area weights w the penalty's Hessian is mu times a part of the
    identity, so one mu serves all modes.

    Parameters
    ----------
    problem
        The program.
    tolerance
        Largest violation of a bound and of the equality, and dual residual, at convergence.
    iterations
        Newton steps at most, over all multiplier updates.

    References
    ----------
    Hurtado-Jauregui, section 6, figures 6 and 7, names the method without formulas; Nocedal and
    Wright, *Numerical Optimization*, 2006, section 17.4.
    """
    state = _Lagrangian(problem)
    point = np.zeros(len(problem.linear))
    status, spent = Convergence.ITERATION_LIMIT, 0
    while spent < iterations:
        point, steps = state.minimize(point, tolerance, iterations - spent)
        spent += steps
        violation = state.update(point)
        if violation <= tolerance:
            status = Convergence.CONVERGED
            break
    return certified(
        problem,
        point,
        state.multipliers(),
        iterations=spent,
        rows_used=len(problem.rows),
        status=status,
    )


SOLVERS: dict[str, Callable[[BoundedQuadratic], QuadraticSolution]] = {
    "quadratic-program": quadratic_program,
    "augmented-lagrangian": augmented_lagrangian,
    "active-set": active_set,
}


def solver_named(name: str) -> Callable[[BoundedQuadratic], QuadraticSolution]:
    """The solver of that name.

    Raises
    ------
    OptionError
        If there is none; the message lists the names.
    """
    if name not in SOLVERS:
        raise OptionError(f"solver {name!r} is unknown; choose one of {', '.join(SOLVERS)}")
    return SOLVERS[name]


def _daqp(
    problem: BoundedQuadratic, chosen: Ints, guess: Floats | None
) -> tuple[Floats, Floats, int, Convergence]:
    """Point, multipliers (n,), pivots and status with the bound rows `chosen` only.

    `guess` (len(chosen),): multipliers to start from; they halve the pivots.
    """
    rows = problem.rows[chosen]
    upper, lower = np.ones(len(chosen)), np.zeros(len(chosen))
    kinds = np.full(len(chosen), INEQUALITY_ROW, dtype=np.int32)
    if problem.equality is not None:
        # the equality is first; its row is scaled like a bound row, of order 1
        rows = np.vstack([problem.equality / problem.target, rows])
        upper, lower = np.append(1.0, upper), np.append(1.0, lower)
        kinds = np.append(np.int32(EQUALITY_ROW), kinds).astype(np.int32)
    warm = {}
    if guess is not None and guess.any():
        # the equality is always held, so its entry does not matter
        warm = {"dual_start": np.concatenate([np.zeros(len(rows) - len(guess)), guess])}
    point, _, flag, info = daqp.solve(
        np.ascontiguousarray(problem.matrix),
        np.ascontiguousarray(problem.linear),
        np.ascontiguousarray(rows),
        upper,
        lower,
        kinds,
        primal_tol=ROW_TOLERANCE,
        iter_limit=100_000,
        **warm,
    )
    if flag != 1 and warm:  # a guess that misleads it
        return _daqp(problem, chosen, None)
    multipliers = np.zeros(len(problem.rows))
    found = np.asarray(info["lam"], dtype=np.float64)
    multipliers[chosen] = found[len(found) - len(chosen) :]
    status = Convergence.CONVERGED if flag == 1 else Convergence.NUMERICAL
    return np.asarray(point, dtype=np.float64), multipliers, int(info["iterations"]), status


class _Lagrangian:
    """Multipliers and penalty of one program; y, z are multipliers over mu w."""

    def __init__(self, problem: BoundedQuadratic) -> None:
        self._problem = problem
        count, size = problem.rows.shape
        self._upper, self._lower = np.zeros(count), np.zeros(count)
        self._nu, self._violation = 0.0, np.inf
        # ten times the mean curvature of f: bounds then win over f within a few updates, and the
        # condition number stays within ten times that of f
        self._mu: float = 10.0 * float(np.trace(problem.matrix)) / size

    def minimize(self, point: Floats, tolerance: float, limit: int) -> tuple[Floats, int]:
        """Semismooth Newton with backtracking on the augmented function; steps spent."""
        problem = self._problem
        scale = tolerance * float(np.abs(problem.linear).max())
        value, slope, pushed = self._evaluate(point)
        for spent in range(limit):
            if np.abs(slope).max() <= scale:
                return point, max(spent, 1)
            rows = problem.rows[pushed]
            curvature = problem.matrix + self._mu * (
                rows.T @ (problem.row_weights[pushed, None] * rows)
            )
            if problem.equality is not None:
                curvature += self._mu_equality() * np.outer(problem.equality, problem.equality)
            direction = -linalg.solve(curvature, slope, assume_a="pos")
            descent, step = float(slope @ direction), 1.0
            while True:
                trial = self._evaluate(point + step * direction)
                if trial[0] <= value + 1e-4 * step * descent or step < 1e-9:
                    break
                step *= 0.5
            point = point + step * direction
            value, slope, pushed = trial
            if step < 1e-9:  # rounding: no further decrease can be seen
                return point, spent + 1
        return point, max(limit, 1)

    def update(self, point: Floats) -> float:
        """Move the multipliers, then the penalty if they moved too little; largest violation."""
        problem = self._problem
        values = problem.rows @ point
        violation = max(float(values.max() - 1.0), float(-values.min()), 0.0)
        self._upper = np.maximum(0.0, self._upper + values - 1.0)
        self._lower = np.maximum(0.0, self._lower - values)
        if problem.equality is not None:
            excess = float(problem.equality @ point) - problem.target
            self._nu += self._mu_equality() * excess
            violation = max(violation, abs(excess) / abs(problem.target))
        if violation > SUFFICIENT_PROGRESS * self._violation:
            self._mu *= PENALTY_GROWTH
            self._upper /= PENALTY_GROWTH
            self._lower /= PENALTY_GROWTH
        self._violation = violation
        return violation

    def multipliers(self) -> Floats:
        """Multipliers of the bound rows, (n,)."""
        weighted = self._mu * self._problem.row_weights
        found: Floats = weighted * (self._upper - self._lower)
        return found

    def _mu_equality(self) -> float:
        # the area is a single strong row: in units of its target it gets the weight of all bounds
        return float(self._mu / self._problem.target**2)

    def _evaluate(self, point: Floats) -> tuple[float, Floats, Bools]:
        problem, mu = self._problem, self._mu
        values = problem.rows @ point
        above = np.maximum(0.0, self._upper + values - 1.0)
        below = np.maximum(0.0, self._lower - values)
        weighted = problem.row_weights
        value = problem.value(point) + 0.5 * mu * float(weighted @ (above**2 + below**2))
        slope = problem.slope(point) + mu * (problem.rows.T @ (weighted * (above - below)))
        if problem.equality is not None:
            excess = float(problem.equality @ point) - problem.target
            mu_equality = self._mu_equality()
            value += self._nu * excess + 0.5 * mu_equality * excess**2
            slope = slope + (self._nu + mu_equality * excess) * problem.equality
        return value, slope, (above > 0) | (below > 0)
