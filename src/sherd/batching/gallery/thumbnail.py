"""A small picture of an answer, for pages that show a thousand of them."""

from __future__ import annotations

import io
import os

from PIL import Image

__all__ = ["thumbnail"]

# Two shapes side by side are told apart at this width on a page; the generated animal takes 1.6 KB.
WIDTH = 320
# Title above and legend below, as shares of the width; see sherd.drawing.picture.
TOP, BOTTOM = 100 / 1600, 176 / 1600
# At 60 the colors of flat shaded shapes show no blocks. The others are for what is finer than that:
# a thousand of these bytes are 16 MB in a page.
QUALITIES = (60, 40, 20, 5)
MOST_BYTES = 12_000


def thumbnail(picture: str | os.PathLike[str]) -> bytes:
    """WebP of the two shapes of a picture, without words; empty if it cannot be small."""
    with Image.open(picture) as image:
        width, height = image.size
        box = (0, round(TOP * width), width, round(height - BOTTOM * width))
        small = image.convert("RGB").resize(
            (WIDTH, max(1, round(WIDTH * (box[3] - box[1]) / width))),
            Image.Resampling.LANCZOS,
            box=box,
        )
    contents = (_webp(small, quality) for quality in QUALITIES)
    return next((content for content in contents if len(content) <= MOST_BYTES), b"")


def _webp(image: Image.Image, quality: int) -> bytes:
    stream = io.BytesIO()
    image.save(stream, "WEBP", quality=quality, method=4)
    return stream.getvalue()
