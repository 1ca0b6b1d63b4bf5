"""Pieces laid out in tidy rows, each turned as it stands on the whole, as one mesh to look at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sherd.arrays import Floats, Ints
from sherd.drawing.alignment import rotation_to_full
from sherd.drawing.camera import best_view, upward
from sherd.drawing.exhibit import Exhibit, Partner
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["PieceRow", "ShownPiece", "piece_row", "resized"]

# Between neighbors, as a share of the largest extent of a piece.
SPACE = 0.12
# In lengths, beside the reference. What is smaller is not seen, and beside what is larger others
# are not: a row is three or four pieces wide. It has another unit, or is of something else.
SMALLEST, LARGEST = 0.02, 4.0
# Rows are broken so that all together are about as wide as high times this: half a page.
ASPECT = 1.2


@dataclass(frozen=True, eq=False)
class ShownPiece:
    """One piece and its points on the full shape; None if it is refused."""

    mesh: TriangleMesh
    partner: Partner | None


@dataclass(frozen=True, eq=False)
class PieceRow:
    """All pieces as one mesh.

    Attributes
    ----------
    mesh
        Of the pieces one after the other, in the order given.
    owner
        (n,) the piece of each vertex.
    numbers
        (n,) its number in its own piece.
    """

    mesh: TriangleMesh
    owner: Ints
    numbers: Ints


def _resized_by(piece: TriangleMesh, reference: float) -> float:
    """By what a piece is drawn larger; mostly 1.

    What would hide others, or not be seen, is as large as the reference; both in sqrt(area).
    """
    fits = SMALLEST * reference <= piece.length <= LARGEST * reference
    return 1.0 if fits else reference / piece.length


def resized(pieces: Sequence[TriangleMesh], reference: float) -> dict[int, float]:
    """By number, of the pieces that are drawn in another size, how many times as wide they are."""
    factors = [_resized_by(piece, reference) for piece in pieces]
    return {number: 1 / factor for number, factor in enumerate(factors) if factor != 1}


def piece_row(
    full: TriangleMesh, pieces: Sequence[ShownPiece], reference: float | None = None
) -> PieceRow:
    """Lay the pieces out beside each other, in the order given, as one looks at the full shape.

    In their sizes, but for those that cannot be seen beside the reference (sqrt(area); the full
    shape if None), see :func:`resized`.
    """
    reference = full.length if reference is None else reference
    view = best_view(full, np.ones(full.vertex_count, dtype=bool), upward(full)).rotation
    seen = [_turned(full, piece) @ view.T * _resized_by(piece.mesh, reference) for piece in pieces]
    low = [points.min(axis=0) for points in seen]
    size = np.array([points.max(axis=0) - least for points, least in zip(seen, low, strict=True)])
    space = SPACE * float(size.max())
    corners = _corners(size[:, :2] + space)
    places = []
    for points, least, (x, y), extent in zip(seen, low, corners, size, strict=True):
        # each stands on the line of its row, all in one depth
        start = np.array([x, y, -0.5 * extent[2]])
        places.append((points - least + start) @ view)
    counts = [len(points) for points in places]
    starts = np.cumsum([0, *counts[:-1]])
    faces = [piece.mesh.faces + start for piece, start in zip(pieces, starts, strict=True)]
    return PieceRow(
        mesh=TriangleMesh(np.concatenate(places), np.concatenate(faces), name="pieces"),
        owner=np.repeat(np.arange(len(pieces)), counts),
        numbers=np.concatenate([np.arange(count) for count in counts]),
    )


def _turned(full: TriangleMesh, piece: ShownPiece) -> Floats:
    """The piece's vertices, turned toward its place."""
    if piece.partner is None:
        return np.array(piece.mesh.vertices)
    scene = Exhibit(piece.mesh.name, full, piece.mesh, partner=piece.partner)
    turned: Floats = piece.mesh.vertices @ rotation_to_full(scene).T
    return turned


def _corners(size: Floats) -> list[tuple[float, float]]:
    """The lower left corner of each box (k, 2), in rows from the top."""
    wide = max(float(size[:, 0].max()), float(np.sqrt(ASPECT * size.prod(axis=1).sum())))
    rows: list[list[int]] = [[]]
    for k, width in enumerate(size[:, 0].tolist()):
        if rows[-1] and float(size[rows[-1], 0].sum()) + width > wide:
            rows.append([])
        rows[-1].append(k)
    found: list[tuple[float, float]] = []
    bottom = 0.0
    for row in rows:
        bottom -= float(size[row, 1].max())
        lefts = np.cumsum([0.0, *size[row[:-1], 0]]).tolist()
        found += [(left, bottom) for left in lefts]
    return found
