"""How options and results show themselves: in one line, and as a small table in notebooks."""

from __future__ import annotations

import html
from collections.abc import Mapping
from dataclasses import fields
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

__all__ = ["differences", "table_html"]

# Tuples with more entries are said as their number.
SHOWN = 4


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
