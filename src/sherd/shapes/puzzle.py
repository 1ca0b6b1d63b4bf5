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

__all__ = ["puzzle_balls", "puzzle_pieces"]

# Halvings of the interval that a border lies in: to a thousandth of the length.
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
    _require(posed, overlap)
    _, distances = farthest_point_sample(Geodesics(full), len(posed), start=start)
    areas = full.vertex_areas
    pieces = []
    for number, pose in enumerate(posed):
        others = np.delete(distances, number, axis=0).min(axis=0)
        level = others - distances[number]
        if overlap > 0:
            level = _with_area(full, level, (1 + overlap) * float(areas @ (level > 0)))
        pieces.append(cut_by_level(whole(pose, full), level))
    return tuple(pieces)


def puzzle_balls(
    full: TriangleMesh,
    posed: Sequence[TriangleMesh],
    *,
    start: int = 0,
    overlap: float = 0.5,
) -> tuple[Fragment, ...]:
    """One piece of the whole for each pose, all of one area: balls about points that lie far apart.

    Parameters
    ----------
    full, posed, start
        As of :func:`puzzle_pieces`.
    overlap
        The areas on the full shape add up to so much more than its own. Some places may be in no
        piece.

    Raises
    ------
    InputError, OptionError
        As :func:`puzzle_pieces`.

    Examples
    --------
    >>> from sherd.shapes.creature import creature
    >>> full = creature(5000)
    >>> pieces = puzzle_balls(full, [creature(5000, pose="walk"), full])
    >>> [round(float(full.vertex_areas @ piece.region / full.area), 2) for piece in pieces]
    [0.75, 0.75]
    """
    _require(posed, overlap)
    _, distances = farthest_point_sample(Geodesics(full), len(posed), start=start)
    area = min((1 + overlap) / len(posed), 1.0) * full.area
    return tuple(
        cut_by_level(whole(pose, full), _with_area(full, -away, area))
        for pose, away in zip(posed, distances, strict=True)
    )


def _require(posed: Sequence[TriangleMesh], overlap: float) -> None:
    if len(posed) < 2:
        raise InputError(f"{len(posed)} poses were given, but a puzzle has at least two pieces")
    if not 0 <= overlap < 1:
        raise OptionError(f"overlap is {overlap}, but a share from 0 to below 1 is needed")


def _with_area(full: TriangleMesh, level: Floats, wanted: float) -> Floats:
    """A level (n,), raised so that the area where it is positive is as wanted, or a little more."""
    low, high = 0.0, float(-level.min())
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        enough = float(full.vertex_areas @ (level + middle > 0)) >= wanted
        low, high = (low, middle) if enough else (middle, high)
    raised: Floats = level + high
    return raised
