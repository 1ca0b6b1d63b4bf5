"""show() and plot(): a result in a notebook, to turn or as a picture."""

from __future__ import annotations

import html
from dataclasses import dataclass

from PIL import Image

from sherd.drawing.exhibit import Exhibit
from sherd.drawing.picture import picture
from sherd.report.html import page
from sherd.report.write import report_of
from sherd.results.locate_result import LocateResult
from sherd.results.match_result import MatchResult

__all__ = ["Shown", "exhibit_of", "plot", "show"]


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
        # a frame of its own, without access to the notebook: scripts run and files can be saved
        return (
            f'<iframe srcdoc="{html.escape(self.document)}" '
            'sandbox="allow-scripts allow-downloads" '
            f'style="width:100%;height:{self.height}px;border:0"></iframe>'
        )


def exhibit_of(result: MatchResult | LocateResult | Exhibit) -> Exhibit:
    """A result as something to look at; an exhibit is returned as it is."""
    return result if isinstance(result, Exhibit) else report_of(result).exhibit


def show(result: MatchResult | LocateResult | Exhibit, *, height: int = 900) -> Shown:
    """Return the interactive page of a result; the last line of a notebook cell displays it.

    Parameters
    ----------
    result
        Of :func:`sherd.match` or :func:`sherd.locate`.
    height
        Of the frame, in pixels.

    Examples
    --------
    >>> from sherd.locate import locate
    >>> from sherd.shapes import creature, cut_by_ball, whole
    >>> full = creature(5000)
    >>> result = locate(full, cut_by_ball(whole(creature(5000, pose="walk"), full), 0, 0.5).mesh)
    >>> show(result, height=600).height
    600
    """
    return Shown(page(exhibit_of(result)), height)


def plot(
    result: MatchResult | LocateResult | Exhibit, *, layer: str | None = None, width: int = 1600
) -> Image.Image:
    """Both shapes side by side as a picture, which notebooks display and ``.save(path)`` writes.

    Parameters
    ----------
    result
        Of :func:`sherd.match` or :func:`sherd.locate`.
    layer
        What to color by: ``"membership"``, ``"region"``, ``"correspondence"``, ``"confidence"``,
        ``"distortion"``, ``"orientation"``, ``"phase field"`` or ``"<name> (from the file)"`` for a
        vertex field of the input. The map of a match and the membership of a region when None.
    width
        In pixels, 400 to 10,000.

    Raises
    ------
    OptionError
        If the result has no such layer or the width is out of range.

    Examples
    --------
    >>> from sherd.locate import locate
    >>> from sherd.shapes import creature, cut_by_ball, whole
    >>> full = creature(5000)
    >>> result = locate(full, cut_by_ball(whole(creature(5000, pose="walk"), full), 0, 0.5).mesh)
    >>> plot(result, width=800).width
    800
    """
    return picture(exhibit_of(result), layer=layer, width=width)
