"""The legend of a picture: a color bar with numbers, or swatches with names."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import ImageDraw, ImageFont

from sherd.drawing.colors import CATEGORY_COLORS, MASK_COLORS, color_table
from sherd.drawing.exhibit import Layer

__all__ = ["draw_legend", "ticks"]

Color = tuple[int, int, int, int]


def ticks(low: float, high: float, *, most: int = 6) -> list[float]:
    """Round numbers in [low, high], at most about `most` of them.

    Examples
    --------
    >>> ticks(0.0, 1.0)
    [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]
    """
    raw = (high - low) / (most - 1)
    power = 10.0 ** np.floor(np.log10(raw))
    step = power * next(nice for nice in (1, 2, 2.5, 5, 10) if nice * power >= raw * (1 - 1e-9))
    first, last = np.ceil(low / step - 1e-9), np.floor(high / step + 1e-9)
    return [float(f"{index * step:.12g}") + 0.0 for index in np.arange(first, last + 1)]


def draw_legend(
    draw: ImageDraw.ImageDraw,
    layer: Layer | None,
    beside: Layer | None,
    *,
    box: tuple[int, int, int],
    unit: float,
    inks: tuple[Color, Color],
) -> None:
    """Draw the legend of `layer` into `box` (left, top, width), `unit` pixels per point.

    `beside` is the layer of the other shape; of the same name it may have kinds that `layer` lacks.
    """
    if layer is None:
        return
    ink, gray = inks
    left, top, width = box
    small = ImageFont.load_default(size=max(8.0, round(20 * unit)))
    heading = layer.name + (f" [{layer.unit}]" if layer.unit else "")
    middle = left + width // 2
    if layer.kind == "scalar":
        _draw_bar(draw, layer, box=box, unit=unit, ink=gray)
        draw.text((middle, top + 62 * unit), heading, fill=ink, font=small, anchor="mm")
        return
    if layer.kind == "color":
        words = layer.description or heading
        draw.text((middle, top + 12 * unit), words, fill=ink, font=small, anchor="mm")
        return
    values = [layer.values]
    if beside is not None and (beside.name, beside.kind) == (layer.name, layer.kind):
        values.append(beside.values)
    entries = _entries(layer, np.unique(np.concatenate(values)))
    widths = [30 * unit + draw.textlength(name, font=small) + 36 * unit for name, _ in entries]
    place = middle - sum(widths) / 2
    for (name, color), extent in zip(entries, widths, strict=True):
        square = (place, top, place + 22 * unit, top + 22 * unit)
        draw.rounded_rectangle(square, radius=4 * unit, fill=(*color, 255))
        draw.text((place + 32 * unit, top + 11 * unit), name, fill=gray, font=small, anchor="lm")
        place += extent
    draw.text((middle, top + 50 * unit), heading, fill=ink, font=small, anchor="mm")


def _entries(layer: Layer, values: NDArray[Any]) -> list[tuple[str, tuple[int, int, int]]]:
    if layer.kind == "mask":
        return [("outside", MASK_COLORS[0]), ("inside", MASK_COLORS[1])]
    present = [int(value) for value in values if value >= 0][:8]
    palette = layer.palette or CATEGORY_COLORS
    names = [layer.labels[k] if k < len(layer.labels) else str(k) for k in present]
    return [(name, palette[k % len(palette)]) for name, k in zip(names, present, strict=True)]


def _draw_bar(
    draw: ImageDraw.ImageDraw, layer: Layer, *, box: tuple[int, int, int], unit: float, ink: Color
) -> None:
    left, top, width = box
    low, high = layer.limits
    table = color_table(layer.color_map)
    for column in range(width):
        red, green, blue = table[round(column * (len(table) - 1) / (width - 1))].tolist()
        draw.line(
            (left + column, top, left + column, top + 18 * unit), fill=(red, green, blue, 255)
        )
    font = ImageFont.load_default(size=max(8.0, round(18 * unit)))
    for value in ticks(low, high):
        place = left + (value - low) / (high - low) * (width - 1)
        draw.line(
            (place, top + 18 * unit, place, top + 24 * unit), fill=ink, width=max(1, round(unit))
        )
        draw.text((place, top + 36 * unit), f"{value:g}", fill=ink, font=font, anchor="mm")
