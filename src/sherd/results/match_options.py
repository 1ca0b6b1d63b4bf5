"""MatchOptions: every parameter of match, by name."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, TypeAlias, TypedDict

import numpy as np
from numpy.typing import NDArray

from sherd.errors import OptionError
from sherd.limits import require_seed
from sherd.mesh.units import UNITS, Unit, unit_factor
from sherd.results.display import differences
from sherd.results.vertex_lists import named_vertices, vertex_pairs
from sherd.scan.either_side import SIDES, Side

__all__ = ["SCALES", "MatchKeywords", "MatchOptions", "Scale"]

Scale: TypeAlias = Literal["same", "unknown"]
SCALES: tuple[Scale, ...] = ("same", "unknown")


@dataclass(frozen=True, repr=False)
class MatchOptions:
    """Options of :func:`sherd.match`; the defaults need no tuning.

    Parameters
    ----------
    scale
        ``"same"``: both shapes have the same unit; ``"unknown"``: the part's scale is estimated,
        such that it has 0.01 to 1.3 times the area of the full shape; a number: lengths of the part
        are multiplied by it.
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
    part_unit, full_unit
        Units of the two shapes, ``"mm"``, ``"cm"``, ``"m"``, ``"in"`` or ``"ft"``: both or none.
        With ``scale="unknown"``, of two scales that fit about as well, the nearer to them is taken.

    Raises
    ------
    OptionError
        If a value is outside its range.

    Examples
    --------
    >>> MatchOptions(scale="unknown", ignore=(5, 3)).ignore
    (3, 5)
    """

    scale: Scale | float = "same"
    landmarks: tuple[tuple[int, int], ...] = ()
    ignore: tuple[int, ...] = ()
    side: Side = "either"
    seed: int = 0
    part_unit: Unit | None = None
    full_unit: Unit | None = None

    def __repr__(self) -> str:
        return differences(self)

    def __post_init__(self) -> None:
        self._check_scale()
        if self.side not in SIDES:
            raise OptionError(f'side is {self.side!r}, but "either" or "given" is needed')
        landmarks = vertex_pairs(self.landmarks, "landmarks")
        if len({part for part, _ in landmarks}) < len(landmarks):
            raise OptionError("landmarks name a vertex of the part twice")
        ignore = named_vertices(self.ignore, "ignore")
        clash = {part for part, _ in landmarks} & set(ignore)
        if clash:
            raise OptionError(f"vertex {min(clash)} of the part is a landmark and ignored")
        require_seed(self.seed)
        object.__setattr__(self, "landmarks", landmarks)
        object.__setattr__(self, "ignore", ignore)
        object.__setattr__(self, "seed", int(self.seed))

    def _check_scale(self) -> None:
        for name in ("part_unit", "full_unit"):
            unit = getattr(self, name)
            if unit is not None and unit not in UNITS:
                raise OptionError(f"{name} is {unit!r}, but must be one of {', '.join(UNITS)}")
        if (self.part_unit is None) != (self.full_unit is None):
            raise OptionError("part_unit and full_unit belong together; give both or none")
        if self.scale in SCALES:
            return
        if not _is_positive(self.scale):
            raise OptionError(
                f'scale is {self.scale!r}, but "same", "unknown" or a positive number is needed'
            )
        if self.part_unit is not None:
            raise OptionError("scale is a number and units are given as well; give one of them")
        object.__setattr__(self, "scale", float(self.scale))

    @property
    def factor(self) -> float:
        """What lengths of the part are multiplied by, as far as it is known: 1 if nothing is."""
        if self.part_unit is not None and self.full_unit is not None:
            return unit_factor(self.part_unit, self.full_unit)
        return self.scale if isinstance(self.scale, float) else 1.0


class MatchKeywords(TypedDict, total=False):
    """The fields of :class:`MatchOptions` as keywords of :func:`sherd.match`."""

    scale: Scale | float
    landmarks: Iterable[Iterable[int]] | NDArray[np.integer]
    ignore: Iterable[int] | NDArray[np.integer] | NDArray[np.bool_]
    side: Side
    seed: int
    part_unit: Unit | None
    full_unit: Unit | None


def _is_positive(value: object) -> bool:
    number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    return number and math.isfinite(float(value)) and float(value) > 0  # type: ignore[arg-type]


def _is_whole(value: object) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool)
