"""show(): the interactive page inside a notebook."""

from __future__ import annotations

import html
from dataclasses import dataclass

from sherd.report.exhibit import Exhibit
from sherd.report.html import page

__all__ = ["Shown", "show"]


@dataclass(frozen=True)
class Shown:
    """A page that a notebook displays; elsewhere it is only its text.

    Parameters
    ----------
    document
        The whole page as HTML.
    height
        Of the frame, in pixels.
    """

    document: str
    height: int

    def __repr__(self) -> str:
        return f"Shown({len(self.document):,} characters; displayed by notebooks)"

    def _repr_html_(self) -> str:
        # a frame of its own, without access to the notebook: scripts run, nothing else does
        return (
            f'<iframe srcdoc="{html.escape(self.document)}" sandbox="allow-scripts" '
            f'style="width:100%;height:{self.height}px;border:0"></iframe>'
        )


def show(exhibit: Exhibit, *, height: int = 900) -> Shown:
    """Return the page of an exhibit; as the last line of a notebook cell it is displayed."""
    return Shown(page(exhibit), height)
