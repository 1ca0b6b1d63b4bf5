"""LocateOptions: every parameter of locate, by name."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias, TypedDict, get_args

from sherd.errors import OptionError
from sherd.limits import require_finite, require_seed, require_whole
from sherd.results.display import differences
from sherd.scan.either_side import SIDES, Side

__all__ = [
    "DESCRIPTORS",
    "METHODS",
    "SOLVERS",
    "DescriptorName",
    "LocateKeywords",
    "LocateOptions",
    "Method",
]

Method: TypeAlias = Literal["voting", "logistic", "exponential", "subspace", "full"]
Solver: TypeAlias = Literal["active-set", "augmented-lagrangian", "quadratic-program"]
DescriptorName: TypeAlias = Literal["shot", "hks", "wks"]
METHODS: tuple[Method, ...] = get_args(Method)
SOLVERS: tuple[Solver, ...] = get_args(Solver)
DESCRIPTORS: tuple[DescriptorName, ...] = get_args(DescriptorName)

_INTEGRAL_METHODS = METHODS[1:]
# Which methods an option speaks to, and its value there if it is not given. Others refuse it.
_SPEAKS_TO: dict[str, tuple[tuple[Method, ...], str | int]] = {
    "descriptor": (_INTEGRAL_METHODS, "shot"),
    "vocabulary_size": (_INTEGRAL_METHODS, 160),
    "solver": (("subspace",), "active-set"),
    "iterations": (("subspace", "full"), 5),
}

# The least and the most of each number, and why not more.
_LIMITS: dict[str, tuple[int, int, str]] = {
    "basis_size": (
        2,
        1000,
        "higher eigenvectors wave within a few edges of the mesh that is searched, and the time "
        "grows with the square of their number",
    ),
    "iterations": (1, 1000, "the alternation settles within tens"),
    "vocabulary_size": (
        2,
        2000,
        "more words than a few per hundred vertices each stand for one neighborhood only",
    ),
}
# Energies are dimensionless and of order 1, so that double precision loses what is 1e-12 of them.
LARGEST_WEIGHT = 1e12


@dataclass(frozen=True, kw_only=True, repr=False)
class LocateOptions:
    """Parameters of :func:`sherd.locate`; the defaults need no tuning.

    An option that the chosen method does not know is refused, so that nobody believes it had an
    effect; left open, it is None.

    Attributes
    ----------
    method
        ``"voting"``: soft matching of the part's samples, then a logistic membership (default, most
        accurate). The others match the integral of descriptors as the paper does:
        ``"logistic"`` and ``"exponential"`` obey the bounds by construction, ``"subspace"`` is the
        paper's problem in k coefficients, ``"full"`` its all-vertex predecessor.
    descriptor
        What the integral-matching methods integrate: ``"shot"`` (default), ``"hks"`` or ``"wks"``,
        as words of a soft vocabulary. Voting always uses rotation-searched SHOT.
    solver
        For ``"subspace"``: ``"active-set"`` (default), ``"augmented-lagrangian"`` or
        ``"quadratic-program"``.
    basis_size
        k, number of Laplace-Beltrami eigenvectors that carry the membership.
    regularity, smoothness, boundary, phase_width
        lambda_r, lambda_s, lambda_b and epsilon of the paper, dimensionless; None chooses. See
        :class:`sherd.energy.problem.EnergyWeights`.
    iterations
        For ``"subspace"`` and ``"full"``: alternations between membership and phase field, 5.
    vocabulary_size
        Number of words of the integral-matching methods, 160.
    side
        ``"either"``: where the part's faces may look inward, the other side is tried too;
        ``"given"``: the order of corners is believed.
    seed
        Of the random choices (the words of the vocabulary).

    Raises
    ------
    OptionError
        When constructed with a value out of range, or one that the method does not know.

    Examples
    --------
    >>> LocateOptions(method="subspace").solver
    'active-set'
    """

    method: Method = "voting"
    descriptor: DescriptorName | None = None
    solver: Solver | None = None
    basis_size: int = 100
    regularity: float | None = None
    smoothness: float | None = None
    boundary: float | None = None
    phase_width: float | None = None
    iterations: int | None = None
    vocabulary_size: int | None = None
    side: Side = "either"
    seed: int = 0

    def __repr__(self) -> str:
        return differences(self)

    def __post_init__(self) -> None:
        self._check_names()
        for name, (least, most, reason) in _LIMITS.items():
            if getattr(self, name) is not None:
                require_whole(name, getattr(self, name), least, most, reason)
        require_seed(self.seed)
        for name in ("regularity", "smoothness", "boundary", "phase_width"):
            weight = getattr(self, name)
            if weight is not None:
                require_finite(name, weight, 0, LARGEST_WEIGHT, "the other terms vanish beside it")
        for name, (methods, default) in _SPEAKS_TO.items():
            if self.method in methods:
                if getattr(self, name) is None:
                    object.__setattr__(self, name, default)
            elif getattr(self, name) is not None:
                raise OptionError(
                    f"{name} has no effect on method {self.method!r}, only on "
                    f"{', '.join(methods)}; leave it out or choose one of these"
                )

    def _check_names(self) -> None:
        allowed: dict[str, tuple[str | None, ...]] = {
            "method": METHODS,
            "descriptor": (*DESCRIPTORS, None),
            "solver": (*SOLVERS, None),
            "side": SIDES,
        }
        for name, values in allowed.items():
            if getattr(self, name) not in values:
                known = ", ".join(value for value in values if value)
                raise OptionError(f"{name} is {getattr(self, name)!r}, but must be one of {known}")


class LocateKeywords(TypedDict, total=False):
    """The fields of :class:`LocateOptions` as keywords of :func:`sherd.locate`."""

    method: Method
    descriptor: DescriptorName | None
    solver: Solver | None
    basis_size: int
    regularity: float | None
    smoothness: float | None
    boundary: float | None
    phase_width: float | None
    iterations: int | None
    vocabulary_size: int | None
    side: Side
    seed: int
