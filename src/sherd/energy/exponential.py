"""The paper's exponential parametrization: membership = exp(-(basis @ coefficients)).

`u = exp(-(Phi alpha + c))` is positive whatever alpha is, and `c = log(integral exp(-Phi alpha) /
s)` meets the area exactly, so k unknowns are free. It is not below 1 by construction: the n
upper rows `Phi alpha + c >= 0` remain, here by multipliers. The sigmoid of
:mod:`sherd.energy.logistic` needs none of this and is what `sherd` uses by default; the
exponential is kept because the paper names it, and for comparison.

References
----------
Hurtado-Jauregui, *Piece-wise partial matching of non-rigid shapes*, section 7.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from sherd.arrays import Floats, Ints
from sherd.energy.batched_energy import BatchedEnergy, subspace_phase_fields
from sherd.energy.descent import minimize_columns
from sherd.energy.logistic import (
    LogisticOptions,
    LogisticRegion,
    checked_starts,
    distinct_columns,
)
from sherd.energy.mumford_shah import energy
from sherd.energy.problem import RegionProblem
from sherd.spectral.basis import EigenBasis

__all__ = ["ExponentialRegion", "exponential_regions"]


# A start is read as the logarithm of a membership that is nowhere below this: exp(-3).
SMALLEST = 0.05
# Multiplier updates per round, and the growth of the penalty between them. Four updates at a
# tenfold penalty each brought the violation from 0.3 to below 1e-3 on balls and limbs.
UPDATES, GROWTH = 4, 10.0


@dataclass(frozen=True, eq=False)
class ExponentialRegion(LogisticRegion):
    """One local minimum, as :class:`LogisticRegion` describes it, and what the exponential adds.

    Here `membership` is clipped at 1, `membership_coefficients` are without the shift, and
    `gradient_norm` is that of the augmented energy.

    Attributes
    ----------
    shift
        c.
    bound_violation
        Largest `u - 1` before clipping.
    """

    shift: float
    bound_violation: float


def exponential_regions(
    problem: RegionProblem,
    basis: EigenBasis,
    initial: ArrayLike,
    *,
    options: LogisticOptions | None = None,
) -> list[ExponentialRegion]:
    """Distinct local minima over exponential memberships, least energy first.

    Parameters, errors and order are those of :func:`sherd.energy.logistic.logistic_regions`.
    """
    options = options or LogisticOptions()
    starts = checked_starts(initial, problem.vertex_count)
    search = _ExponentialEnergy(problem, basis, len(starts))
    points = search.coefficients(starts)
    fields = np.ones_like(starts.T)
    every = np.arange(len(starts))
    used = np.zeros(len(starts), dtype=np.int64)
    per_round = [(0.0, options.search_evaluations)]
    per_round += [(crispness, options.round_evaluations) for crispness in options.crispness]
    for number, (crispness, evaluations) in enumerate(per_round):
        search.prepare(fields, crispness)
        for _ in range(UPDATES):
            found = minimize_columns(
                search, points, evaluations=evaluations, tolerance=options.tolerance
            )
            points, used = found.points, used + found.evaluations
            search.update(points)
        u = search.memberships(points)
        if number == 0:
            kept = distinct_columns(problem, np.minimum(u, 1.0), found.values)
            kept = kept[: options.survivors]
            search = search.restricted(kept)
            points, fields, used, every = points[:, kept], fields[:, kept], used[kept], every[kept]
            u = u[:, kept]
        fields = subspace_phase_fields(problem, basis, np.minimum(u, 1.0), fields)
    clipped = np.minimum(u, 1.0)
    regions = [
        ExponentialRegion(
            membership=clipped[:, column].copy(),
            phase_field=fields[:, column].copy(),
            membership_coefficients=points[:, column].copy(),
            shift=float(search.shifts(points)[column]),
            bound_violation=max(0.0, float(u[:, column].max()) - 1.0),
            energy=energy(problem, clipped[:, column], fields[:, column]),
            status=found.status(column),
            evaluations=int(used[column]),
            gradient_norm=float(found.gradient_norms[column]),
            start=int(every[column]),
        )
        for column in range(points.shape[1])
    ]
    totals = np.array([region.energy.total for region in regions])
    return [regions[index] for index in distinct_columns(problem, clipped, totals)]


class _ExponentialEnergy:
    """Augmented energy of coefficients (k, c), with multipliers of the upper rows per column."""

    def __init__(self, problem: RegionProblem, basis: EigenBasis, count: int) -> None:
        self._problem, self._basis = problem, basis
        self._energy = BatchedEnergy(problem)
        self._scale = math.sqrt(problem.area)
        self._vectors = np.ascontiguousarray(basis.eigenvectors * self._scale)
        self._weights = (problem.vertex_areas / problem.part_area)[:, None]
        self._y = np.zeros((problem.vertex_count, count))
        # the energy is of order 1 and so is a violation; the growth does the rest
        self._mu = 1.0

    def restricted(self, columns: Ints) -> _ExponentialEnergy:
        """The same energy for these columns only, multipliers kept."""
        result = _ExponentialEnergy(self._problem, self._basis, len(columns))
        result._y, result._mu = self._y[:, columns], self._mu
        return result

    def prepare(self, fields: Floats, crispness: float) -> None:
        """Fix phase fields and crispness for the calls that follow."""
        self._edge_weights, self._crispness = self._energy.edge_weights(fields), crispness

    def coefficients(self, starts: Floats) -> Floats:
        return self._basis.project(-np.log(np.clip(starts, SMALLEST, 1.0)).T) / self._scale

    def shifts(self, points: Floats) -> Floats:
        return self._shifted(points)[1]

    def memberships(self, points: Floats) -> Floats:
        result: Floats = np.exp(-self._shifted(points)[0])
        return result

    def update(self, points: Floats) -> None:
        """Multipliers of `Phi alpha + c >= 0`, then a stronger penalty."""
        heights, _ = self._shifted(points)
        self._y = np.maximum(0.0, self._y - heights)
        if self._mu < GROWTH**UPDATES:
            self._mu *= GROWTH
            self._y /= GROWTH

    def __call__(self, points: Floats, columns: Ints) -> tuple[Floats, Floats]:
        heights, _ = self._shifted(points)
        u = np.exp(-heights)
        values, g = self._energy(u, self._edge_weights[:, columns], self._crispness)
        pushed = np.maximum(0.0, self._y[:, columns] - heights)
        values = values + 0.5 * self._mu * (self._weights * pushed**2).sum(axis=0)
        by_height = -u * g - self._mu * self._weights * pushed
        # c falls by the membership-weighted mean of a change of Phi alpha
        by_height -= self._weights * u * by_height.sum(axis=0)
        slopes: Floats = self._vectors.T @ by_height
        return values, slopes

    def _shifted(self, points: Floats) -> tuple[Floats, Floats]:
        scores = self._vectors @ points
        lowest = scores.min(axis=0)
        mass = (self._weights * np.exp(lowest - scores)).sum(axis=0)
        shift = np.log(mass) - lowest
        return scores + shift, shift
