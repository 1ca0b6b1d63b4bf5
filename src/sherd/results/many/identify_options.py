"""IdentifyOptions: every parameter of identify, by name."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypedDict

import numpy as np
from numpy.typing import NDArray

from sherd.limits import require_whole
from sherd.mesh.units import Unit
from sherd.results.display import differences
from sherd.results.match_options import MatchOptions, Scale
from sherd.scan.either_side import Side

__all__ = ["IdentifyKeywords", "IdentifyOptions"]

# Evidence rarely has the right shape third; the second costs as much as the first.
MATCHES = 2
MOST_MATCHES = 100


@dataclass(frozen=True, repr=False)
class IdentifyOptions:
    """Options of :func:`sherd.identify`; the defaults need no tuning.

    Parameters
    ----------
    scale, ignore, side, seed, part_unit, full_unit
        As in :class:`sherd.MatchOptions`; all full shapes have one unit.
    matches
        So many full shapes are matched with the part at most, the likeliest first. The second is
        only if the first is doubtful or leads by little.

    Raises
    ------
    OptionError
        If a value is outside its range.

    Examples
    --------
    >>> IdentifyOptions(matches=3)
    IdentifyOptions(matches=3)
    """

    scale: Scale | float = "same"
    ignore: tuple[int, ...] = ()
    side: Side = "either"
    seed: int = 0
    part_unit: Unit | None = None
    full_unit: Unit | None = None
    matches: int = MATCHES

    def __post_init__(self) -> None:
        checked = self.match_options
        reason = "each costs as much as a match"
        require_whole("matches", self.matches, 1, MOST_MATCHES, reason)
        for name in ("scale", "ignore", "seed"):
            object.__setattr__(self, name, getattr(checked, name))
        object.__setattr__(self, "matches", int(self.matches))

    def __repr__(self) -> str:
        return differences(self)

    @property
    def match_options(self) -> MatchOptions:
        """The options of each match."""
        return MatchOptions(
            scale=self.scale,
            ignore=self.ignore,
            side=self.side,
            seed=self.seed,
            part_unit=self.part_unit,
            full_unit=self.full_unit,
        )


class IdentifyKeywords(TypedDict, total=False):
    """The fields of :class:`IdentifyOptions` as keywords of :func:`sherd.identify`."""

    scale: Scale | float
    ignore: Iterable[int] | NDArray[np.integer] | NDArray[np.bool_]
    side: Side
    seed: int
    part_unit: Unit | None
    full_unit: Unit | None
    matches: int
