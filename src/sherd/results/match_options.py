"""MatchOptions: every parameter of match, by name."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, TypeAlias, TypedDict

import numpy as np
from numpy.typing import NDArray

from sherd.errors import OptionError
from sherd.results.vertex_lists import named_vertices, vertex_pairs
from sherd.scan.either_side import SIDES, Side

__all__ = ["SCALES", "MatchKeywords", "MatchOptions", "Scale"]

Scale: TypeAlias = Literal["same", "unknown"]
SCALES: tuple[Scale, ...] = ("same", "unknown")


@dataclass(frozen=True)
class MatchOptions:
    """Options of :func:`sherd.match`; the defaults need no tuning.

    Parameters
    ----------
    scale
        ``"same"``: both shapes have the same unit; ``"unknown"``: the part's scale is estimated
        within [1/2, 2] of the full shape's.
    landmarks
        Pairs (vertex of the part, vertex of the full shape) that belong together.
    ignore
        Vertices of the part to leave out: clothing, support, clutter; by number, or as a mask with
        one bool for each vertex of the part. Stored as numbers in ascending order.
    side
        ``"either"``: where the part's faces may look inward, or the answer is doubtful and the part
        open, the other side is tried too; ``"given"``: the order of corners is believed.
    seed
        Seed of every random choice.

    Raises
    ------
    OptionError
        If a value is outside its range.

    Examples
    --------
    >>> MatchOptions(scale="unknown", ignore=(5, 3)).ignore
    (3, 5)
    """

    scale: Scale = "same"
    landmarks: tuple[tuple[int, int], ...] = ()
    ignore: tuple[int, ...] = ()
    side: Side = "either"
    seed: int = 0

    def __post_init__(self) -> None:
        if self.scale not in SCALES:
            raise OptionError(f'scale is {self.scale!r}, but "same" or "unknown" is needed')
        if self.side not in SIDES:
            raise OptionError(f'side is {self.side!r}, but "either" or "given" is needed')
        landmarks = vertex_pairs(self.landmarks, "landmarks")
        if len({part for part, _ in landmarks}) < len(landmarks):
            raise OptionError("landmarks name a vertex of the part twice")
        ignore = named_vertices(self.ignore, "ignore")
        clash = {part for part, _ in landmarks} & set(ignore)
        if clash:
            raise OptionError(f"vertex {min(clash)} of the part is a landmark and ignored")
        if not _is_whole(self.seed) or self.seed < 0:
            raise OptionError(f"seed is {self.seed!r}, but a whole number >= 0 is needed")
        object.__setattr__(self, "landmarks", landmarks)
        object.__setattr__(self, "ignore", ignore)
        object.__setattr__(self, "seed", int(self.seed))


class MatchKeywords(TypedDict, total=False):
    """The fields of :class:`MatchOptions` as keywords of :func:`sherd.match`."""

    scale: Scale
    landmarks: Iterable[Iterable[int]] | NDArray[np.integer]
    ignore: Iterable[int] | NDArray[np.integer] | NDArray[np.bool_]
    side: Side
    seed: int


def _is_whole(value: object) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool)
