"""L-BFGS on many columns at once: one evaluation serves every start, so products are BLAS-3."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.energy.convergence import Convergence

__all__ = ["ColumnMinima", "Objective", "minimize_columns"]

Objective = Callable[[Floats, Ints], tuple[Floats, Floats]]

# Nocedal and Wright 2006, section 3.1: the usual constant of sufficient decrease.
SUFFICIENT_DECREASE = 1e-4
# A column is also done when its quasi-Newton model promises less than this share of its value: the
# energy only ranks regions, which differ by percents.
NEGLIGIBLE_DECREASE = 1e-4
# 2^-20 of a step: below float32 resolution of the variables, nothing further can be gained.
MOST_HALVINGS = 20


@dataclass(frozen=True, eq=False)
class ColumnMinima:
    """Where the descent of each column ended.

    Attributes
    ----------
    points
        (k, c) float.
    values
        (c,) float, objective there.
    gradient_norms
        (c,) float, Euclidean norm of the gradient there.
    evaluations
        (c,) int, evaluations spent on the column.
    converged
        (c,) bool, gradient norm within the tolerance, or half the quasi-Newton decrement below
        1e-4 of the value.
    stalled
        (c,) bool, no step lowered the value any more.
    """

    points: Floats
    values: Floats
    gradient_norms: Floats
    evaluations: Ints
    converged: Bools
    stalled: Bools

    def status(self, column: int) -> Convergence:
        """Why the descent of a column ended."""
        if self.converged[column]:
            return Convergence.CONVERGED
        return Convergence.STALLED if self.stalled[column] else Convergence.ITERATION_LIMIT


def minimize_columns(
    objective: Objective,
    start: Floats,
    *,
    evaluations: int,
    tolerance: float,
    memory: int = 10,
) -> ColumnMinima:
    """Local minimum of every column of `start`, each descending on its own.

    Parameters
    ----------
    objective
        Called with points (k, a) and the indices (a,) of the columns they belong to; returns
        values (a,) and gradients (k, a), float64.
    start
        (k, c) float.
    evaluations
        Evaluations per column at most.
    tolerance
        A column is done when its gradient norm is at most this, or nothing is left to gain.
    memory
        Correction pairs kept per column.

    Notes
    -----
    Backtracking by halving with the sufficient decrease condition; a pair enters the memory
    only if its curvature is positive. A column that is done costs nothing more.

    References
    ----------
    Nocedal and Wright, *Numerical Optimization*, 2006, algorithm 7.4.
    """
    size, count = start.shape
    every = np.arange(count)
    points = np.array(start, dtype=np.float64)
    values, slopes = objective(points, every)
    history = _History(size, count, memory)
    direction = -slopes / np.maximum(np.linalg.norm(slopes, axis=0), 1.0)
    step, halvings = np.ones(count), np.zeros(count, dtype=np.int64)
    used = np.ones(count, dtype=np.int64)
    converged = np.linalg.norm(slopes, axis=0) <= tolerance
    stalled = np.zeros(count, dtype=bool)
    while True:
        active = np.flatnonzero(~converged & ~stalled & (used < evaluations))
        if len(active) == 0:
            break
        trial = points[:, active] + step[active] * direction[:, active]
        found, found_slopes = objective(trial, active)
        used[active] += 1
        descent = (slopes[:, active] * direction[:, active]).sum(axis=0)
        # NaN compares false, so a step into overflow is halved like any other bad step
        good = found <= values[active] + SUFFICIENT_DECREASE * step[active] * descent
        taken, missed = active[good], active[~good]
        history.add(
            trial[:, good] - points[:, taken], found_slopes[:, good] - slopes[:, taken], taken
        )
        points[:, taken], values[taken] = trial[:, good], found[good]
        slopes[:, taken] = found_slopes[:, good]
        direction[:, taken] = history.direction(slopes[:, taken], taken)
        step[taken], halvings[taken] = 1.0, 0
        promised = -0.5 * (slopes[:, taken] * direction[:, taken]).sum(axis=0)
        negligible = promised <= NEGLIGIBLE_DECREASE * np.abs(values[taken])
        # the model means nothing before the memory has seen the curvature
        converged[taken] = negligible & (used[taken] > memory)
        converged[taken] |= np.linalg.norm(slopes[:, taken], axis=0) <= tolerance
        step[missed] *= 0.5
        halvings[missed] += 1
        stalled[missed] = halvings[missed] > MOST_HALVINGS
    norms = np.linalg.norm(slopes, axis=0)
    return ColumnMinima(points, values, norms, used, converged, stalled)


class _History:
    """The last correction pairs of every column, (memory, k, c), newest last."""

    def __init__(self, size: int, count: int, memory: int) -> None:
        self._steps = np.zeros((memory, size, count))
        self._changes = np.zeros((memory, size, count))
        self._inverse_curvature = np.zeros((memory, count))  # 0 marks an empty place

    def add(self, steps: Floats, changes: Floats, columns: Ints) -> None:
        curvature = (steps * changes).sum(axis=0)
        floor = 1e-10 * np.linalg.norm(steps, axis=0) * np.linalg.norm(changes, axis=0)
        keep = curvature > floor
        chosen = columns[keep]
        for store, new in (
            (self._steps, steps[:, keep]),
            (self._changes, changes[:, keep]),
            (self._inverse_curvature, 1.0 / curvature[keep]),
        ):
            store[:-1, ..., chosen] = store[1:, ..., chosen]
            store[-1, ..., chosen] = np.moveaxis(new, -1, 0)

    def direction(self, slopes: Floats, columns: Ints) -> Floats:
        steps, changes = self._steps[..., columns], self._changes[..., columns]
        inverse = self._inverse_curvature[:, columns]
        result = -slopes
        shares = np.zeros_like(inverse)
        for index in range(len(steps) - 1, -1, -1):
            shares[index] = inverse[index] * (steps[index] * result).sum(axis=0)
            result = result - shares[index] * changes[index]
        length = (changes[-1] ** 2).sum(axis=0)
        scale = np.ones(len(columns))
        np.divide(1.0, inverse[-1] * length, out=scale, where=inverse[-1] * length > 0)
        empty = inverse[-1] == 0
        scale[empty] = 1.0 / np.maximum(np.linalg.norm(slopes[:, empty], axis=0), 1.0)
        result = scale * result
        for index in range(len(steps)):
            share = inverse[index] * (changes[index] * result).sum(axis=0)
            result = result + (shares[index] - share) * steps[index]
        return result
