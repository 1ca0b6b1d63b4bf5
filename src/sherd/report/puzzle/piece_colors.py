"""Colors of pieces that people tell apart, color-blind ones too as far as a dozen colors allow."""

from __future__ import annotations

import numpy as np

from sherd.drawing.colors import CATEGORY_COLORS

__all__ = ["GAP_COLOR", "REFUSED_COLOR", "piece_palette"]

# Light and dark gray: no piece is gray.
GAP_COLOR = (238, 238, 238)
REFUSED_COLOR = (84, 84, 84)
# The seven hues, then the same mixed with so much white, then with so much black.
WHITE, BLACK = 0.5, 0.45


def piece_palette(count: int) -> tuple[tuple[int, int, int], ...]:
    """Colors 0..255 of `count` pieces, then that of the gap and that of refused pieces.

    Examples
    --------
    >>> palette = piece_palette(12)
    >>> len(palette), len(set(palette))
    (14, 14)
    """
    hues = np.array(CATEGORY_COLORS[:-1], dtype=np.float64)  # the last one is gray
    shades = (hues, hues + WHITE * (255 - hues), (1 - BLACK) * hues)
    colors = np.concatenate(shades).round().astype(int)
    own = [colors[k % len(colors)] for k in range(count)]
    return (*((int(r), int(g), int(b)) for r, g, b in own), GAP_COLOR, REFUSED_COLOR)
