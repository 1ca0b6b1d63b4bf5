"""How many answers remain when only the surer ones are kept: a plot as SVG."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Bools, Floats

__all__ = ["share_above", "tradeoff_svg"]

# Pixels of the plot before the page scales it: width, height, and the room for the labels.
WIDTH, HEIGHT = 560, 230
LEFT, RIGHT, TOP, BOTTOM = 58, 14, 10, 44
# The curve is drawn through so many thresholds; more cannot be told apart at this size.
STEPS = 101
GRID = (0.0, 0.25, 0.5, 0.75, 1.0)


def share_above(confidence: Floats, matched: Bools, thresholds: Floats) -> Floats:
    """Share of all vertices that are matched with at least each confidence, (t,).

    Examples
    --------
    >>> share_above(np.array([0.2, 0.8, 0.9]), np.array([True, True, False]), np.array([0, 0.5]))
    array([0.66666667, 0.33333333])
    """
    known = np.sort(confidence[matched & np.isfinite(confidence)])
    above = len(known) - np.searchsorted(known, thresholds, side="left")
    return above / max(len(confidence), 1)


def tradeoff_svg(confidence: Floats, matched: Bools) -> str:
    """Share of vertices above each confidence as an SVG element; empty if nothing is known.

    Colors come from the page's style sheet, so that they follow its theme.
    """
    if not np.isfinite(confidence[matched]).any():
        return ""
    thresholds = np.linspace(0, 1, STEPS)
    shares = share_above(confidence, matched, thresholds)
    points = " ".join(f"{_x(t):.1f},{_y(s):.1f}" for t, s in zip(thresholds, shares, strict=True))
    half, nine = share_above(confidence, matched, np.array([0.5, 0.9]))
    words = (
        f"Share of vertices above each confidence: {half:.0%} are matched with a confidence of at "
        f"least 0.5, {nine:.0%} of at least 0.9."
    )
    middle, bottom = _x(0.5), HEIGHT - 6
    return (
        f'<svg class="plot" id="tradeoff" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" '
        f'aria-label="{words}"><title>{words}</title>{_grid()}'
        f'<polygon class="under" points="{_x(0):.1f},{_y(0):.1f} {points} '
        f'{_x(1):.1f},{_y(0):.1f}"/><polyline class="curve" points="{points}"/>'
        f'<text class="name" x="{middle:.1f}" y="{bottom}" text-anchor="middle">'
        "confidence of at least</text>"
        f'<text class="name" x="14" y="{_y(0.5):.1f}" text-anchor="middle" '
        f'transform="rotate(-90 14 {_y(0.5):.1f})">share of vertices</text></svg>'
    )


def _grid() -> str:
    lines = []
    for value in GRID:
        x, y = _x(value), _y(value)
        lines.append(
            f'<line class="grid" x1="{x:.1f}" y1="{_y(0):.1f}" x2="{x:.1f}" y2="{_y(1):.1f}"/>'
            f'<line class="grid" x1="{_x(0):.1f}" y1="{y:.1f}" x2="{_x(1):.1f}" y2="{y:.1f}"/>'
            f'<text x="{x:.1f}" y="{_y(0) + 17:.1f}" text-anchor="middle">{value:g}</text>'
            f'<text x="{LEFT - 8}" y="{y + 4:.1f}" text-anchor="end">{100 * value:.0f} %</text>'
        )
    return "".join(lines)


def _x(confidence: float) -> float:
    return LEFT + confidence * (WIDTH - LEFT - RIGHT)


def _y(share: float) -> float:
    return HEIGHT - BOTTOM - share * (HEIGHT - TOP - BOTTOM)
