"""Names of array types, rows in blocks, read-only arrays, and frozen objects as bytes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Bools",
    "Bytes",
    "Floats",
    "FrozenState",
    "Ints",
    "Singles",
    "blocks_of_rows",
    "field_state",
    "frozen",
]

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]
Bytes = NDArray[np.uint8]

_Kind = TypeVar("_Kind", bound=np.generic)


def blocks_of_rows(count: int, size: int) -> list[slice]:
    """Slices that make up the rows 0 to `count`, of `size` rows each but the last.

    Examples
    --------
    >>> blocks_of_rows(5, 3)
    [slice(0, 3, None), slice(3, 5, None)]
    """
    return [slice(start, min(start + size, count)) for start in range(0, count, size)]


def frozen(array: NDArray[_Kind]) -> NDArray[_Kind]:
    """A read-only, contiguous view of `array`, or of a copy if it is not contiguous.

    Examples
    --------
    >>> frozen(np.arange(3)).flags.writeable
    False
    """
    view = np.ascontiguousarray(array).view()
    view.flags.writeable = False
    return view


def field_state(instance: Any) -> dict[str, Any]:
    """The fields of a dataclass object, without what it has computed from them and kept."""
    return {each.name: getattr(instance, each.name) for each in fields(instance)}


class FrozenState:
    """Base of frozen dataclasses: pickled and copied by their fields alone, read-only again after.

    Values that were computed on first use stay behind. Numpy gives back arrays that can be
    written to, and read-only mappings cannot be pickled at all.
    """

    def __getstate__(self) -> dict[str, Any]:
        return {name: _open(value) for name, value in field_state(self).items()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, value in state.items():
            # a frozen dataclass sets its own fields this way
            object.__setattr__(self, name, _closed(value))


def _open(value: Any) -> Any:
    return dict(value) if isinstance(value, Mapping) else value


def _closed(value: Any) -> Any:
    if isinstance(value, Mapping):
        return MappingProxyType({key: _closed(entry) for key, entry in value.items()})
    return frozen(value) if isinstance(value, np.ndarray) else value
