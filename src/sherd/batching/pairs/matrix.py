"""Matrices of a collection, shape by shape: as CSV, and as a picture."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from itertools import combinations

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from sherd.arrays import Floats
from sherd.batching.ledger.rows import PairRow
from sherd.batching.pairs.task import pair_name
from sherd.drawing.colors import UNKNOWN, color_table
from sherd.drawing.picture import png_bytes

__all__ = ["likeness_matrix", "matrix_csv", "matrix_picture", "shared_matrix"]

# Cells of a few shapes are large enough for numbers, those of a hundred still one by one.
CELLS = (8, 56)
PICTURE = 900
LABELS = 150
SMALLEST_LABELED = 12
SMALLEST_NUMBERED = 30
INK = (27, 32, 39)


def shared_matrix(names: Sequence[str], rows: Sequence[PairRow]) -> Floats:
    """(k, k) share of the area of row's shape that the column's has too; NaN is unknown.

    A pair that is not alike enough to be asked shares nothing.
    """
    matrix = np.eye(len(names))
    for i, j, row in _placed(names, rows, matrix):
        if row.status == "foreign":
            matrix[i, j] = matrix[j, i] = 0.0
        elif row.shared_of_first is not None and row.shared_of_second is not None:
            matrix[i, j], matrix[j, i] = row.shared_of_first, row.shared_of_second
    return matrix


def likeness_matrix(names: Sequence[str], rows: Sequence[PairRow]) -> Floats:
    """(k, k) symmetric likeness; NaN is unknown."""
    matrix = np.eye(len(names))
    for i, j, row in _placed(names, rows, matrix):
        if row.likeness is not None:
            matrix[i, j] = matrix[j, i] = row.likeness
    return matrix


def matrix_csv(names: Sequence[str], matrix: Floats) -> str:
    """A row and a column for each shape; unknown is empty."""
    stream = io.StringIO()
    table = csv.writer(stream, lineterminator="\n")
    table.writerow(["shape", *names])
    for name, values in zip(names, matrix, strict=True):
        table.writerow([name, *("" if np.isnan(value) else f"{value:.4g}" for value in values)])
    return stream.getvalue()


def matrix_picture(names: Sequence[str], shared: Floats, likeness: Floats) -> bytes:
    """PNG of both matrices side by side, from 0 (light) to 1 (dark); unknown is gray."""
    cell = int(np.clip(PICTURE // max(1, len(names)), *CELLS))
    side = cell * len(names)
    width, height = LABELS + side + 20, side + 90
    image = Image.new("RGBA", (2 * width, height), "white")
    titles = ("Share of the row's area that the column's shape has too", "Likeness")
    for k, (title, matrix) in enumerate(zip(titles, (shared, likeness), strict=True)):
        _draw(image, (k * width, 50), cell, names, matrix)
        ImageDraw.Draw(image).text(
            (k * width + LABELS, 16), title, fill=INK, font=ImageFont.load_default(15)
        )
    return png_bytes(image)


def _draw(
    image: Image.Image, corner: tuple[int, int], cell: int, names: Sequence[str], matrix: Floats
) -> None:
    table = color_table("ember")
    steps = np.nan_to_num(np.clip(matrix, 0, 1)) * (len(table) - 1)
    colors = np.where(np.isnan(matrix)[..., None], UNKNOWN, table[np.round(steps).astype(int)])
    cells = np.kron(colors.astype(np.uint8), np.ones((cell, cell, 1), dtype=np.uint8))
    x, y = corner[0] + LABELS, corner[1]
    image.paste(Image.fromarray(cells), (x, y))
    draw = ImageDraw.Draw(image)
    font = ImageFont.load_default(min(13, max(9, cell - 4)))
    for i, name in enumerate(names if cell >= SMALLEST_LABELED else ()):
        place = (x - 6, y + (i + 0.5) * cell)
        draw.text(place, name[-22:], fill=INK, font=font, anchor="rm")
        for j, value in enumerate(matrix[i] if cell >= SMALLEST_NUMBERED else ()):
            middle = (x + (j + 0.5) * cell, y + (i + 0.5) * cell)
            said = "?" if np.isnan(value) else f"{100 * value:.0f}"
            draw.text(middle, said, fill=INK, font=font, anchor="mm")


def _placed(
    names: Sequence[str], rows: Sequence[PairRow], matrix: Floats
) -> list[tuple[int, int, PairRow]]:
    """Rows with the places of their shapes; the matrix is made unknown off its diagonal."""
    matrix[~np.eye(len(names), dtype=bool)] = np.nan
    places = {pair_name(names[i], names[j]): (i, j) for i, j in combinations(range(len(names)), 2)}
    return [(*places[row.name], row) for row in rows if row.name in places]
