"""Puzzles with one right answer: a whole cut into pieces, each piece in a pose of its own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sherd.arrays import Floats
from sherd.errors import InputError, OptionError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes.fragment import Fragment, cut_by_level, whole
from sherd.spectral.geodesics import Geodesics
from sherd.spectral.sampling import farthest_point_sample

__all__ = ["puzzle_pieces"]

# Halvings of the interval that the width of an overlap lies in: to a thousandth of the length.
HALVINGS = 10


def puzzle_pieces(
    full: TriangleMesh,
    posed: Sequence[TriangleMesh],
    *,
    start: int = 0,
    overlap: float = 0.0,
) -> tuple[Fragment, ...]:
    """One piece of the whole for each pose: the cells of points that lie far apart.

    Parameters
    ----------
    full
        The whole.
    posed
        The whole in the pose of each piece: the same faces. As many as there shall be pieces.
    start
        Vertex that the first cell is about; the others follow from it.
    overlap
        Share of its area that each piece reaches beyond its cell; 0: pieces meet, and share
        nothing but their borders.

    Returns
    -------
    tuple of Fragment
        Whose `truth` is exact. Their areas on the full shape add up to its own if `overlap` is 0.

    Raises
    ------
    InputError
        If there are fewer than two poses, or one has other faces.
    OptionError
        If `overlap` is not within 0 and 1.

    Examples
    --------
    >>> from sherd.shapes.creature import creature
    >>> full = creature(5000)
    >>> pieces = puzzle_pieces(full, [creature(5000, pose="walk"), full])
    >>> round(float(sum(piece.region.mean() for piece in pieces)), 1)
    1.0
    """
    count = len(posed)
    if count < 2:
        raise InputError(f"{count} poses were given, but a puzzle has at least two pieces")
    if not 0 <= overlap < 1:
        raise OptionError(f"overlap is {overlap}, but a share from 0 to below 1 is needed")
    _, distances = farthest_point_sample(Geodesics(full), count, start=start)
    pieces = []
    for number, pose in enumerate(posed):
        others = np.delete(distances, number, axis=0).min(axis=0)
        level = others - distances[number]
        level = level + _reach(full, level, overlap)
        pieces.append(cut_by_level(whole(pose, full), level))
    return tuple(pieces)


def _reach(full: TriangleMesh, level: Floats, overlap: float) -> float:
    """What is added to `level` so that the area where it is positive grows by a share."""
    if overlap == 0:
        return 0.0
    areas = full.vertex_areas
    wanted = (1 + overlap) * float(areas @ (level > 0))
    low, high = 0.0, float(-level.min())
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        enough = float(areas @ (level + middle > 0)) >= wanted
        low, high = (low, middle) if enough else (middle, high)
    return high
