"""MatchOptions: every parameter of match, by name."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from sherd.errors import OptionError
from sherd.limits import require_seed
from sherd.scan.either_side import SIDES, Side

__all__ = ["SCALES", "MatchOptions", "Scale"]

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
        Vertices of the part to leave out: clothing, support, clutter.
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
        landmarks = tuple((int(part), int(full)) for part, full in self.landmarks)
        if len({part for part, _ in landmarks}) < len(landmarks):
            raise OptionError("landmarks name a vertex of the part twice")
        ignore = tuple(sorted({int(vertex) for vertex in self.ignore}))
        if min([vertex for pair in landmarks for vertex in pair] + list(ignore), default=0) < 0:
            raise OptionError("landmarks and ignore count vertices from 0")
        clash = {part for part, _ in landmarks} & set(ignore)
        if clash:
            raise OptionError(f"vertex {min(clash)} of the part is a landmark and ignored")
        require_seed(self.seed)
        object.__setattr__(self, "landmarks", landmarks)
        object.__setattr__(self, "ignore", ignore)
