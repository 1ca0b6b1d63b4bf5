"""LocateOptions: every parameter of locate, by name."""

from __future__ import annotations

import math
from dataclasses import dataclass

from sherd.errors import OptionError

__all__ = ["DESCRIPTORS", "METHODS", "SOLVERS", "LocateOptions"]

METHODS = ("voting", "logistic", "exponential", "subspace", "full")
SOLVERS = ("active-set", "augmented-lagrangian", "quadratic-program")
DESCRIPTORS = ("shot", "hks", "wks")


@dataclass(frozen=True, kw_only=True)
class LocateOptions:
    """Parameters of :func:`sherd.locate`; the defaults need no tuning.

    Attributes
    ----------
    method
        ``"voting"``: soft matching of the part's samples, then a logistic membership (default, most
        accurate). The others match the integral of descriptors as the paper does:
        ``"logistic"`` and ``"exponential"`` obey the bounds by construction, ``"subspace"`` is the
        paper's problem in k coefficients, ``"full"`` its all-vertex predecessor.
    descriptor
        What the integral-matching methods integrate: ``"shot"``, ``"hks"`` or ``"wks"``, as words
        of a soft vocabulary. Voting always uses rotation-searched SHOT.
    solver
        For ``"subspace"``: ``"active-set"``, ``"augmented-lagrangian"`` or ``"quadratic-program"``.
    basis_size
        k, number of Laplace-Beltrami eigenvectors that carry the membership.
    regularity, smoothness, boundary, phase_width
        lambda_r, lambda_s, lambda_b and epsilon of the paper, dimensionless; None chooses. See
        :class:`sherd.energy.problem.EnergyWeights`.
    iterations
        Alternations between membership and phase field.
    vocabulary_size
        Number of words of the integral-matching methods.
    seed
        Of the random choices (the words of the vocabulary).

    Raises
    ------
    OptionError
        When constructed with a value out of range.
    """

    method: str = "voting"
    descriptor: str = "shot"
    solver: str = "active-set"
    basis_size: int = 100
    regularity: float | None = None
    smoothness: float | None = None
    boundary: float | None = None
    phase_width: float | None = None
    iterations: int = 5
    vocabulary_size: int = 160
    seed: int = 0

    def __post_init__(self) -> None:
        for name, allowed in (
            ("method", METHODS),
            ("descriptor", DESCRIPTORS),
            ("solver", SOLVERS),
        ):
            if getattr(self, name) not in allowed:
                raise OptionError(
                    f"{name} is {getattr(self, name)!r}, but must be one of {', '.join(allowed)}"
                )
        for name, least in (("basis_size", 2), ("iterations", 1), ("vocabulary_size", 2)):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int) or value < least:
                raise OptionError(f"{name} is {value!r}, but a whole number >= {least} is needed")
        if isinstance(self.seed, bool) or not isinstance(self.seed, int) or self.seed < 0:
            raise OptionError(f"seed is {self.seed!r}, but a whole number >= 0 is needed")
        for name in ("regularity", "smoothness", "boundary", "phase_width"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value >= 0):
                raise OptionError(f"{name} is {value}, but a finite number >= 0 is needed")
