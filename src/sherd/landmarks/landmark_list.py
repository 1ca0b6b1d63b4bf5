"""Landmarks: named points in space, as a file of markups holds them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from sherd.arrays import Bools, Floats, FrozenState, frozen
from sherd.errors import InputError

__all__ = ["SPACES", "Landmarks", "Space"]

# Which way the first two axes of a patient's coordinates run: left and posterior, or right and
# anterior. Between both x and y change their signs.
Space: TypeAlias = Literal["LPS", "RAS"]
SPACES: tuple[Space, ...] = get_args(Space)
FLIP = np.array([-1.0, -1.0, 1.0])


@dataclass(frozen=True, eq=False, repr=False)
class Landmarks(FrozenState):
    """Named points.

    Parameters
    ----------
    names
        (p,) unlike each other.
    positions
        (p, 3) in the unit of the file, NaN where a point has no position.
    space
        What the file says of its axes; None if it says nothing.
    source
        What messages call them: the file's name.

    Raises
    ------
    InputError
        If names are missing or repeated, or the numbers do not fit them.

    Examples
    --------
    >>> nose = Landmarks(["nose"], [[1, 2, 3]], space="RAS")
    >>> nose.in_space("LPS").positions.tolist()
    [[-1.0, -2.0, 3.0]]
    """

    names: tuple[str, ...]
    positions: Floats
    space: Space | None = None
    source: str = "landmarks"

    def __init__(
        self,
        names: Sequence[str],
        positions: ArrayLike,
        *,
        space: Space | None = None,
        source: str = "landmarks",
    ) -> None:
        given = tuple(str(name) for name in names)
        array = np.array(positions, dtype=np.float64).reshape(-1, 3)
        if len(given) != len(array):
            raise InputError(f"{source}: {len(given)} names, but {len(array)} positions")
        if not given:
            raise InputError(f"{source}: holds no landmark")
        if "" in given:
            raise InputError(f"{source}: landmark {given.index('') + 1} has no name; give it one")
        repeated = next((name for name in given if given.count(name) > 1), None)
        if repeated is not None:
            raise InputError(f"{source}: landmark {repeated!r} is there twice; rename one")
        unclear = np.isnan(array).any(axis=1) & ~np.isnan(array).all(axis=1) | np.isinf(array).any(
            1
        )
        if unclear.any():
            name = given[int(np.argmax(unclear))]
            raise InputError(f"{source}: landmark {name!r} has a coordinate that is not finite")
        if space is not None and space not in SPACES:
            raise InputError(f"{source}: space is {space!r}, but one of {SPACES} is needed")
        for field, value in (
            ("names", given), ("positions", frozen(array)), ("space", space), ("source", source),
        ):  # fmt: skip
            object.__setattr__(self, field, value)

    def __len__(self) -> int:
        return len(self.names)

    def __repr__(self) -> str:
        lacking = int((~self.known).sum())
        without = f", {lacking} without position" if lacking else ""
        return f"Landmarks({self.source!r}, {len(self)} points{without})"

    @property
    def known(self) -> Bools:
        """(p,) bool, whether a point has a position."""
        return np.asarray(np.isfinite(self.positions).all(axis=1))

    def in_space(self, space: Space) -> Landmarks:
        """The same points, with the axes that `space` names.

        Raises
        ------
        InputError
            If it is not known how the axes run now.
        """
        if self.space is None:
            raise InputError(f"{self.source}: does not say whether it is LPS or RAS")
        return self if space == self.space else self.flipped()

    def flipped(self) -> Landmarks:
        """The same points in the other of both spaces: x and y with the other sign."""
        other: dict[Space | None, Space | None] = {"LPS": "RAS", "RAS": "LPS", None: None}
        return Landmarks(
            self.names, self.positions * FLIP, space=other[self.space], source=self.source
        )
