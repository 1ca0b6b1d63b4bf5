"""FitOptions: every parameter of fit, by name."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypedDict, get_args

from sherd.errors import OptionError
from sherd.limits import require_finite
from sherd.results.display import differences

__all__ = ["SIZINGS", "FitKeywords", "FitOptions", "Sizing"]

Sizing = Literal["local", "individual", "none"]
SIZINGS: tuple[Sizing, ...] = get_args(Sizing)


@dataclass(frozen=True, repr=False)
class FitOptions:
    """Options of :func:`sherd.fit`; the defaults need no tuning.

    Parameters
    ----------
    sizing
        ``"local"``: the full shape is sized where the pieces ask for more than a pose may stretch;
        ``"individual"``: it is another individual, and how much larger the pieces are as a whole is
        believed as it is; ``"none"``: it is the same body, which bends only.
    near
        What counts as near in :attr:`sherd.Fit.chance`, in sqrt(area of the full shape).
    merge
        Whether to complete the scan: see :attr:`sherd.Fit.completion`.

    Raises
    ------
    OptionError
        If a value is outside its range.

    Examples
    --------
    >>> FitOptions(sizing="none")
    FitOptions(sizing='none')
    """

    sizing: Sizing = "local"
    near: float = 0.02
    merge: bool = False

    def __repr__(self) -> str:
        return differences(self)

    def __post_init__(self) -> None:
        if self.sizing not in SIZINGS:
            raise OptionError(
                f'sizing is {self.sizing!r}, but "local", "individual" or "none" is needed'
            )
        reason = "chances were measured for distances from 0.005 to 0.1 sqrt(area)"
        require_finite("near", self.near, 0.005, 0.1, reason)
        object.__setattr__(self, "near", float(self.near))
        object.__setattr__(self, "merge", bool(self.merge))


class FitKeywords(TypedDict, total=False):
    """The fields of :class:`FitOptions` as keywords of :func:`sherd.fit`."""

    sizing: Sizing
    near: float
    merge: bool
