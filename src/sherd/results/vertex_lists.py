"""Vertices that a user names: whole numbers, or a mask; anything else is refused."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from sherd.errors import OptionError

__all__ = ["VertexList", "named_vertices", "vertex_pairs"]


class VertexList(tuple[int, ...]):
    """Vertices, and how many there were to choose from if they were named by a mask.

    Examples
    --------
    >>> named_vertices([False, True, True], "ignore").mask_length
    3
    """

    mask_length: int | None = None


def named_vertices(given: Any, option: str) -> VertexList:
    """Vertices in ascending order, each once, from whole numbers or a mask (n,) bool.

    Raises
    ------
    OptionError
        If an entry is neither, is negative, or `given` is no list.

    Examples
    --------
    >>> named_vertices((5, 3, 5), "ignore")
    (3, 5)
    """
    if isinstance(given, VertexList):
        return given
    entries = _entries(given, option, "vertices of the part, or a mask with one bool for each")
    if entries and all(isinstance(entry, bool | np.bool_) for entry in entries):
        vertices = VertexList(np.flatnonzero(entries).tolist())
        vertices.mask_length = len(entries)
        return vertices
    return VertexList(sorted({_vertex(entry, option) for entry in entries}))


def vertex_pairs(given: Any, option: str) -> tuple[tuple[int, int], ...]:
    """Pairs (vertex of the part, vertex of the full shape) of whole numbers.

    Raises
    ------
    OptionError
        If an entry is no pair of vertices.
    """
    wanted = "pairs (vertex of the part, vertex of the full shape)"
    pairs = []
    for entry in _entries(given, option, wanted):
        pair = _entries(entry, option, wanted)
        if len(pair) != 2:
            raise OptionError(f"{option} has an entry of {len(pair)} values, but takes {wanted}")
        pairs.append((_vertex(pair[0], option), _vertex(pair[1], option)))
    return tuple(pairs)


def _entries(given: Any, option: str, wanted: str) -> list[Any]:
    if isinstance(given, str | bytes | dict) or not isinstance(given, Iterable):
        raise OptionError(f"{option} is {given!r:.60}, but takes {wanted}")
    if isinstance(given, np.ndarray) and given.ndim == 0:
        raise OptionError(f"{option} is one value, but takes {wanted}")
    return list(given)


def _vertex(entry: Any, option: str) -> int:
    if isinstance(entry, bool | np.bool_) or not isinstance(entry, int | np.integer):
        raise OptionError(f"{option} names {entry!r:.60}, but a vertex is a whole number")
    if entry < 0:
        raise OptionError(f"{option} names vertex {entry}, but vertices count from 0")
    return int(entry)
