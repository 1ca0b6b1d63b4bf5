"""A small picture of an answer, for pages that show a thousand of them."""

from __future__ import annotations

import io
import os

from PIL import Image

__all__ = ["thumbnail"]

# Two shapes side by side are told apart at this width on a page, and a thousand take 10 MB.
WIDTH = 320
# Title above and legend below, as shares of the width; see sherd.drawing.picture.
TOP, BOTTOM = 100 / 1600, 176 / 1600
# At 60 the colors of flat shaded shapes show no blocks.
QUALITY = 60


def thumbnail(picture: str | os.PathLike[str]) -> bytes:
    """WebP of the two shapes of a picture, without words."""
    with Image.open(picture) as image:
        width, height = image.size
        box = (0, round(TOP * width), width, round(height - BOTTOM * width))
        small = image.convert("RGB").resize(
            (WIDTH, max(1, round(WIDTH * (box[3] - box[1]) / width))),
            Image.Resampling.LANCZOS,
            box=box,
        )
    stream = io.BytesIO()
    small.save(stream, "WEBP", quality=QUALITY, method=4)
    return stream.getvalue()
