"""Bounds by construction: membership = sigmoid(basis @ coefficients), truly k-dimensional.

The membership is `u = 1 / (1 + exp(-(Phi alpha + c)))`. It lies in (0, 1) whatever alpha is, so
no bound row is left; the shift c is the one root of `integral u = s`, found exactly for every
alpha, so no constraint is left either and alpha in R^k is free. With `w = u (1 - u)` and g the
gradient of the energy in u, implicit differentiation of the area gives::

    dE / d alpha = Phi' ( w * (g - a mu) ),      mu = (g . w) / (a . w)

Many starts are minimized together, so that the products with Phi and P are matrix products.
The energy is not convex in alpha: this is wanted. The relaxed quadratic program averages over
symmetric twins; the sigmoid settles on one of them, and the energy ranks the answers.

Examples
--------
>>> import numpy as np
>>> from sherd.mesh.triangle_mesh import TriangleMesh
>>> from sherd.energy.problem import region_problem
>>> from sherd.spectral.basis import eigenbasis
>>> grid = np.stack(np.meshgrid(np.arange(12.0), np.arange(12.0)), -1).reshape(-1, 2)
>>> vertices = np.column_stack([grid, np.zeros(144)])
>>> corner = np.array([i for i in range(132) if i % 12 < 11])
>>> faces = np.concatenate([
...     np.column_stack([corner, corner + 1, corner + 13]),
...     np.column_stack([corner, corner + 13, corner + 12]),
... ])
>>> full = TriangleMesh(vertices, faces)
>>> truth = (grid[:, 0] < 4).astype(float)
>>> descriptors = np.column_stack([np.ones(144), grid / 11])
>>> a = full.vertex_areas
>>> problem = region_problem(full, full_descriptors=descriptors,
...                          part_integral=descriptors.T @ (a * truth), part_area=a @ truth)
>>> starts = np.stack([truth[::-1], np.roll(truth, 3)])  # (starts, n), each a guess in [0, 1]
>>> best = logistic_regions(problem, eigenbasis(full, 12), starts)[0]
>>> best.status.succeeded, bool(a @ np.abs(best.membership - truth) < 0.1 * (a @ truth))
(True, True)

References
----------
Hurtado-Jauregui, *Piece-wise partial matching of non-rigid shapes*, section 7 (the idea, without
formulas). The derivation above is our own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sherd.arrays import Floats, Ints
from sherd.energy.batched_energy import BatchedEnergy, subspace_phase_fields
from sherd.energy.convergence import Convergence
from sherd.energy.descent import ColumnMinima, Objective, minimize_columns
from sherd.energy.mumford_shah import EnergyTerms, energy
from sherd.energy.problem import RegionProblem
from sherd.errors import InputError, OptionError
from sherd.spectral.basis import EigenBasis

__all__ = [
    "LogisticOptions",
    "LogisticRegion",
    "area_shift",
    "checked_starts",
    "distinct_columns",
    "logistic_regions",
]


# A start is read as log-odds of a membership squeezed into [SOFTEST, 1 - SOFTEST]; a smaller value
# starts on the flat tails of the sigmoid, where the gradient is gone.
SOFTEST = 0.1
# Two memberships that share this much of their union (soft IoU) are the same answer.
SAME_REGION = 0.8


@dataclass(frozen=True)
class LogisticOptions:
    """How hard to search.

    Attributes
    ----------
    search_evaluations
        Energy evaluations for every start, with rho = 1 and no crispness, in float32.
    survivors
        Distinct regions of least energy that go on after the search.
    crispness
        Continuation: one round per entry, each with this weight on `4 / s integral u (1 - u)`
        and with the phase field of the round before.
    round_evaluations
        Energy evaluations per round.
    tolerance
        Gradient norm at which a region has converged, in energy per unit of coefficient.

    Raises
    ------
    OptionError
        If a value is out of range.
    """

    search_evaluations: int = 30
    survivors: int = 6
    crispness: tuple[float, ...] = (0.0, 0.02, 0.05)
    round_evaluations: int = 60
    tolerance: float = 1e-4

    def __post_init__(self) -> None:
        for name in ("search_evaluations", "survivors", "round_evaluations"):
            if getattr(self, name) < 1:
                raise OptionError(f"{name} is {getattr(self, name)}, but at least 1 is needed")
        if not self.crispness or not all(math.isfinite(c) and c >= 0 for c in self.crispness):
            raise OptionError(f"crispness is {self.crispness}, but numbers >= 0 are needed")
        if not (math.isfinite(self.tolerance) and self.tolerance > 0):
            raise OptionError(f"tolerance is {self.tolerance}, but it must be positive")


@dataclass(frozen=True, eq=False)
class LogisticRegion:
    """One local minimum.

    Attributes
    ----------
    membership
        u, (n,) in [0, 1]; its integral is the part's area to rounding.
    phase_field
        rho, (n,) in [0, 1].
    membership_coefficients
        alpha, (k,): `u = sigmoid(eigenvectors @ alpha * sqrt(area))`, the shift included in the
        constant eigenvector where the basis has one.
    energy
        By terms, without the crispness.
    status
        Why the last round stopped.
    evaluations
        Energy evaluations spent on this region, all rounds.
    gradient_norm
        Norm of the gradient in alpha at the end.
    start
        Row of `initial` that led here.
    """

    membership: Floats
    phase_field: Floats
    membership_coefficients: Floats
    energy: EnergyTerms
    status: Convergence
    evaluations: int
    gradient_norm: float
    start: int


def logistic_regions(
    problem: RegionProblem,
    basis: EigenBasis,
    initial: ArrayLike,
    *,
    options: LogisticOptions | None = None,
) -> list[LogisticRegion]:
    """Distinct local minima of the energy over sigmoid memberships, least energy first.

    Parameters
    ----------
    problem
        The energy on n vertices.
    basis
        First k eigenpairs of the same mesh.
    initial
        (starts, n) float in [0, 1], for example geodesic balls of the part's area around
        farthest-point seeds.
    options
        Effort; the defaults of :class:`LogisticOptions` if None.

    Returns
    -------
    list of LogisticRegion
        At most `options.survivors`, sorted by total energy, no two with soft IoU above 0.8.

    Raises
    ------
    InputError
        If `initial` has the wrong shape, no row, or values outside [0, 1].

    Notes
    -----
    An evaluation costs 4 n (k + d) operations per start, all in matrix products. The search runs
    in float32, the rounds in float64.
    """
    options = options or LogisticOptions()
    starts = checked_starts(initial, problem.vertex_count)
    flat = np.ones_like(starts.T)
    chosen, points, used, memberships = _searched(problem, basis, starts, flat, options)
    polish = _SigmoidEnergy(problem, basis, np.float64)
    fields = flat[:, chosen]
    for crispness in options.crispness:
        fields = subspace_phase_fields(problem, basis, memberships, fields)
        found = polish.minimize(
            points, fields, crispness, options.round_evaluations, options.tolerance
        )
        points, used = found.points, used + found.evaluations
        memberships = polish.memberships(points, np.arange(len(chosen)))
    regions = [
        LogisticRegion(
            membership=memberships[:, column].copy(),
            phase_field=fields[:, column].copy(),
            membership_coefficients=polish.with_shift(points, column),
            energy=energy(problem, memberships[:, column], fields[:, column]),
            status=found.status(column),
            evaluations=int(used[column]),
            gradient_norm=float(found.gradient_norms[column]),
            start=int(chosen[column]),
        )
        for column in range(len(chosen))
    ]
    totals = np.array([region.energy.total for region in regions])
    return [regions[index] for index in distinct_columns(problem, memberships, totals)]


def _searched(
    problem: RegionProblem,
    basis: EigenBasis,
    starts: Floats,
    flat: Floats,
    options: LogisticOptions,
) -> tuple[Ints, Floats, Ints, Floats]:
    """The starts that survive: rows (c,), coefficients (k, c), evaluations, memberships (n, c)."""
    search = _SigmoidEnergy(problem, basis, np.float32)
    found = search.minimize(
        search.coefficients(starts), flat, 0.0, options.search_evaluations, options.tolerance
    )
    memberships = search.memberships(found.points, np.arange(len(starts)))
    chosen = distinct_columns(problem, memberships, found.values)[: options.survivors]
    return (
        chosen,
        found.points[:, chosen],
        found.evaluations[chosen],
        np.asarray(memberships[:, chosen], dtype=np.float64),
    )


def area_shift(
    scores: NDArray[Any], areas: NDArray[Any], area: float, guess: NDArray[Any]
) -> NDArray[Any]:
    """Shift c (s,) of each column with `areas . sigmoid(scores + c) = area`.

    Safeguarded Newton: a step that leaves the bracket becomes a bisection. Relative accuracy
    1e-6 in float32 and 1e-12 in float64.
    """
    exact = 1e-12 if scores.dtype == np.float64 else 2e-6
    shift = guess.astype(scores.dtype)
    # below and above these the sigmoids of all vertices are 0 or 1 to rounding
    low, high = -scores.max(axis=0) - 60.0, -scores.min(axis=0) + 60.0
    for _ in range(100):
        u = _sigmoid(scores + shift)
        excess = areas @ u - area
        if (np.abs(excess) <= exact * area).all():
            break
        high = np.where(excess > 0, shift, high)
        low = np.where(excess < 0, shift, low)
        slope = areas @ (u * (1 - u))
        # a Newton step of more than 1e6 would leave the bracket anyway
        usable = slope * 1e6 > np.abs(excess)
        step = np.divide(excess, slope, out=np.full_like(excess, np.inf), where=usable)
        newton = shift - step
        inside = (newton > low) & (newton < high)
        shift = np.where(inside, newton, 0.5 * (low + high)).astype(scores.dtype)
    return shift


class _SigmoidEnergy:
    """The energy as a function of coefficients (k, c); remembers shift and phase per column."""

    def __init__(self, problem: RegionProblem, basis: EigenBasis, dtype: Any) -> None:
        self._problem = problem
        self._energy = BatchedEnergy(problem, dtype)
        # eigenvectors times sqrt(area) have mean square 1, so a coefficient is of order 1
        self._scale = math.sqrt(problem.area)
        self._vectors = np.ascontiguousarray(basis.eigenvectors, dtype=dtype)
        self._basis = basis
        self._areas = problem.vertex_areas.astype(dtype)
        self._shift = np.zeros(0, dtype=dtype)

    def coefficients(self, starts: Floats) -> Floats:
        """Projection of the log-odds of (starts, n) memberships, (k, starts)."""
        squeezed = np.clip(starts, SOFTEST, 1 - SOFTEST)
        odds = np.log(squeezed / (1 - squeezed))
        return self._basis.project(odds.T) / self._scale

    def memberships(self, points: Floats, columns: Ints) -> NDArray[Any]:
        scores = self._vectors @ (self._scale * points).astype(self._vectors.dtype)
        guess = self._shift[columns]
        self._shift[columns] = area_shift(scores, self._areas, self._problem.part_area, guess)
        return _sigmoid(scores + self._shift[columns])

    def objective(self, fields: Floats, crispness: float) -> Objective:
        """Values and gradients in the coefficients, for phase fields (n, c) held fixed."""
        edge_weights = self._energy.edge_weights(fields)
        if len(self._shift) != fields.shape[1]:
            self._shift = np.zeros(fields.shape[1], dtype=self._vectors.dtype)

        def evaluate(trial: Floats, columns: Ints) -> tuple[Floats, Floats]:
            u = self.memberships(trial, columns)
            values, g = self._energy(u, edge_weights[:, columns], crispness)
            w = u * (1 - u)
            level = (g * w).sum(axis=0) / np.maximum(self._areas @ w, 1e-30)
            slopes = self._vectors.T @ (w * (g - self._areas[:, None] * level))
            return values, self._scale * slopes.astype(np.float64)

        return evaluate

    def minimize(
        self, points: Floats, fields: Floats, crispness: float, evaluations: int, tolerance: float
    ) -> ColumnMinima:
        return minimize_columns(
            self.objective(fields, crispness), points, evaluations=evaluations, tolerance=tolerance
        )

    def with_shift(self, points: Floats, column: int) -> Floats:
        """Coefficients (k,) with the shift moved onto the constant function's projection."""
        ones = self._basis.project(np.ones(self._problem.vertex_count)) / self._scale
        return points[:, column] + float(self._shift[column]) * ones


def _sigmoid(scores: NDArray[Any]) -> NDArray[Any]:
    # exp(-|x|) cannot overflow
    decay = np.exp(-np.abs(scores))
    result: NDArray[Any] = np.where(scores >= 0, 1.0, decay).astype(scores.dtype) / (1 + decay)
    return result


def distinct_columns(problem: RegionProblem, memberships: NDArray[Any], values: Floats) -> Ints:
    """Columns by ascending value, without those that repeat a better one."""
    weighted = problem.vertex_areas[:, None] * memberships
    kept: list[int] = []
    for column in np.argsort(values, kind="stable"):
        u = memberships[:, column]
        same = False
        for other in kept:
            shared = float(np.minimum(weighted[:, other], weighted[:, column]).sum())
            union = float(weighted[:, other].sum() + problem.vertex_areas @ u) - shared
            same = same or shared > SAME_REGION * union
        if not same:
            kept.append(int(column))
    return np.array(kept, dtype=np.int64)


def checked_starts(initial: ArrayLike, count: int) -> Floats:
    """`initial` as (starts, n) float in [0, 1], or InputError."""
    starts = np.asarray(initial, dtype=np.float64)
    if starts.ndim != 2 or starts.shape[1] != count or len(starts) == 0:
        raise InputError(f"initial has shape {starts.shape}, but (starts, {count}) is needed")
    if not ((starts >= 0) & (starts <= 1)).all():
        raise InputError("initial holds values outside [0, 1], but these are memberships")
    return starts
