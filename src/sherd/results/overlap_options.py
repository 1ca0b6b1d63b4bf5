"""OverlapOptions: every parameter of overlap, by name."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypedDict

import numpy as np
from numpy.typing import NDArray

from sherd.errors import OptionError
from sherd.limits import require_finite, require_seed
from sherd.results.display import differences
from sherd.results.match_options import SCALES, Scale
from sherd.results.vertex_lists import named_vertices, vertex_pairs

__all__ = ["STRAIN", "OverlapKeywords", "OverlapOptions"]

# A right surface strains by 0.02 to 0.15 on average and by up to half in the creases of joints, a
# limb of another species by as much; where a limb is laid on what it does not belong to it tears.
STRAIN = 0.6
LEAST_STRAIN, MOST_STRAIN = 0.01, 2.0


@dataclass(frozen=True, repr=False)
class OverlapOptions:
    """Options of :func:`sherd.overlap`; the defaults need no tuning.

    Parameters
    ----------
    scale
        ``"same"``: both shapes have the same unit; ``"unknown"``: the second's scale is estimated
        within [1/2, 2] of the first's; a number: lengths of the second are multiplied by it.
    strain
        How alike is enough: the accepted strain. Where the elastic surface is strained by more, the
        shapes are not said to share it. 0.1 is a tenth of the length.
    landmarks
        Pairs (vertex of the first, vertex of the second) that belong together.
    ignore_first, ignore_second
        Vertices to leave out, by number or as a mask with one bool for each vertex.
    seed
        Seed of every random choice.

    Raises
    ------
    OptionError
        If a value is outside its range.

    Examples
    --------
    >>> OverlapOptions(ignore_first=(5, 3)).ignore_first
    (3, 5)
    """

    scale: Scale | float = "same"
    strain: float = STRAIN
    landmarks: tuple[tuple[int, int], ...] = ()
    ignore_first: tuple[int, ...] = ()
    ignore_second: tuple[int, ...] = ()
    seed: int = 0

    def __repr__(self) -> str:
        return differences(self)

    def __post_init__(self) -> None:
        if self.scale not in SCALES:
            number = isinstance(self.scale, int | float | np.number)
            if isinstance(self.scale, bool) or not number or not _is_positive(self.scale):
                raise OptionError(
                    f'scale is {self.scale!r}, but "same", "unknown" or a positive number is needed'
                )
            object.__setattr__(self, "scale", float(self.scale))
        reason = "0.1 is a tenth of the length; nothing that strains by more is alike"
        require_finite("strain", self.strain, LEAST_STRAIN, MOST_STRAIN, reason)
        require_seed(self.seed)
        landmarks = vertex_pairs(self.landmarks, "landmarks")
        ignored = []
        for side, name in enumerate(("first", "second")):
            named = [pair[side] for pair in landmarks]
            if len(set(named)) < len(named):
                raise OptionError(f"landmarks name a vertex of the {name} shape twice")
            ignored.append(named_vertices(getattr(self, f"ignore_{name}"), f"ignore_{name}"))
            clash = set(named) & set(ignored[-1])
            if clash:
                raise OptionError(
                    f"vertex {min(clash)} of the {name} shape is a landmark and ignored"
                )
        object.__setattr__(self, "landmarks", landmarks)
        object.__setattr__(self, "ignore_first", ignored[0])
        object.__setattr__(self, "ignore_second", ignored[1])
        object.__setattr__(self, "strain", float(self.strain))
        object.__setattr__(self, "seed", int(self.seed))

    @property
    def factor(self) -> float:
        """What lengths of the second are multiplied by, as far as it is known: 1 if nothing is."""
        return self.scale if isinstance(self.scale, float) else 1.0


class OverlapKeywords(TypedDict, total=False):
    """The fields of :class:`OverlapOptions` as keywords of :func:`sherd.overlap`."""

    scale: Scale | float
    strain: float
    landmarks: Iterable[Iterable[int]] | NDArray[np.integer]
    ignore_first: Iterable[int] | NDArray[np.integer] | NDArray[np.bool_]
    ignore_second: Iterable[int] | NDArray[np.integer] | NDArray[np.bool_]
    seed: int


def _is_positive(value: object) -> bool:
    return math.isfinite(float(value)) and float(value) > 0  # type: ignore[arg-type]
