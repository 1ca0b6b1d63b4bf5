"""How options and results show themselves: in one line; in notebooks as table and picture."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Mapping
from dataclasses import fields
from typing import TYPE_CHECKING

from sherd.drawing.exhibit import Exhibit

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

__all__ = ["differences", "picture_html", "table_html"]

# Tuples with more entries are said as their number.
SHOWN = 4
# Pixels: narrower than any notebook, and captions are still read.
PICTURE_WIDTH = 640


def differences(options: DataclassInstance) -> str:
    """The options as they would be typed, without those that have their default."""
    said = []
    for each in fields(options):
        value = getattr(options, each.name)
        if value == each.default:
            continue
        long = isinstance(value, tuple) and len(value) > SHOWN
        said.append(f"{each.name}={f'<{len(value)} entries>' if long else repr(value)}")
    return f"{type(options).__name__}({', '.join(said)})"


def table_html(title: str, rows: Mapping[str, str]) -> str:
    """A table of names and values under a title, for notebooks."""
    body = "".join(
        f'<tr><th style="text-align:left">{html.escape(name)}</th>'
        f'<td style="text-align:left">{html.escape(value)}</td></tr>'
        for name, value in rows.items()
    )
    return f"<table><caption>{html.escape(title)}</caption>{body}</table>"


def picture_html(exhibit: Exhibit) -> str:
    """Both shapes side by side in their first layer as an image element, for notebooks."""
    from sherd.drawing.picture import picture  # pillow loads on first use  # noqa: PLC0415

    drawn = picture(exhibit, width=PICTURE_WIDTH, heading=False).convert("RGB")
    stream = io.BytesIO()
    drawn.quantize().save(stream, "PNG", optimize=True)  # 256 colors in a third of the bytes
    data = base64.b64encode(stream.getvalue()).decode()
    words = html.escape(exhibit.title)
    return f'<img alt="{words}" src="data:image/png;base64,{data}"/>'
