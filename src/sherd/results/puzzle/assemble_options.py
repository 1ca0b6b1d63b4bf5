"""AssembleOptions: every parameter of assemble, by name."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypedDict

from sherd.errors import OptionError
from sherd.limits import require_finite, require_seed
from sherd.results.display import differences
from sherd.scan.either_side import SIDES, Side

__all__ = ["TOLERANCE", "AssembleKeywords", "AssembleOptions"]

# In sqrt(area of the full shape), for rigid pieces: borders of broken things wear by less, and the
# surface around them does not wear at all. One and a half vertex spacings at 10,000 vertices.
TOLERANCE = 0.015
# Two meshes of one surface are off by 0.0004 on average where they are coarse, and by several times
# that here and there, so nothing is asked to fit more closely than this.
LEAST_TOLERANCE = 0.005


@dataclass(frozen=True, repr=False)
class AssembleOptions:
    """Options of :func:`sherd.assemble`; the defaults need no tuning.

    Parameters
    ----------
    may_overlap
        Whether pieces may lie on each other without limit, as scans of one region do. Otherwise
        only as far as sure pieces are found to.
    rigid
        Whether pieces may only be turned and shifted.
    tolerance
        For rigid pieces: points of a piece farther from the full shape than this, in its
        sqrt(area), count as worn and do not say where the piece lies. It is placed if it is off by
        a thirtieth of this and less, as a geometric mean, or by what its mesh and that of the full
        shape may be off by, and fits 2.65 times as closely as elsewhere. More for scans that are
        off as a whole; less than 0.005 counts as 0.005.
    side
        As in :class:`sherd.MatchOptions`.
    seed
        Seed of every random choice.

    Raises
    ------
    OptionError
        If a value is outside its range, or a tolerance is given for what is not rigid.

    Examples
    --------
    >>> AssembleOptions(may_overlap=True)
    AssembleOptions(may_overlap=True)
    """

    may_overlap: bool = False
    rigid: bool = False
    tolerance: float = TOLERANCE
    side: Side = "either"
    seed: int = 0

    def __repr__(self) -> str:
        return differences(self)

    @property
    def closeness(self) -> float:
        """The tolerance that counts: no mesh is exact to less than `LEAST_TOLERANCE`."""
        return max(self.tolerance, LEAST_TOLERANCE)

    def __post_init__(self) -> None:
        if self.side not in SIDES:
            raise OptionError(f'side is {self.side!r}, but "either" or "given" is needed')
        reason = "what is farther off than a tenth of sqrt(area) is not worn but elsewhere"
        require_finite("tolerance", self.tolerance, 1e-6, 0.1, reason)
        require_seed(self.seed)
        for name in ("may_overlap", "rigid"):
            object.__setattr__(self, name, bool(getattr(self, name)))
        object.__setattr__(self, "tolerance", float(self.tolerance))
        if self.tolerance != TOLERANCE and not self.rigid:
            raise OptionError(
                f"tolerance is {self.tolerance:g}, which is for rigid pieces: give rigid=True, or "
                "leave it out"
            )
        object.__setattr__(self, "seed", int(self.seed))


class AssembleKeywords(TypedDict, total=False):
    """The fields of :class:`AssembleOptions` as keywords of :func:`sherd.assemble`."""

    may_overlap: bool
    rigid: bool
    tolerance: float
    side: Side
    seed: int
