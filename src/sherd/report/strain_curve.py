"""How much two shapes share as more strain is accepted: a plot as SVG."""

from __future__ import annotations

import math

from sherd.drawing.exhibit import SharedCurve

__all__ = ["strain_curve_svg"]

# As the plot of confidence: width, height, and the room for the labels.
WIDTH, HEIGHT = 560, 230
LEFT, RIGHT, TOP, BOTTOM = 58, 14, 10, 44
SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)
STRAINS = (0.05, 0.1, 0.2, 0.5, 1.0)


def strain_curve_svg(curve: SharedCurve) -> str:
    """Shared area of both shapes against accepted strain, the chosen one marked.

    Colors come from the page's style sheet, so that they follow its theme.
    """
    lines = []
    for name, shares in (("first", curve.first), ("second", curve.second)):
        points = " ".join(
            f"{_x(strain):.1f},{_y(share):.1f}"
            for strain, share in zip(curve.strains, shares, strict=True)
        )
        dashes = "" if name == "first" else ' stroke-dasharray="6 4"'
        lines.append(
            f'<polyline class="curve" points="{points}"{dashes}/>'
            f'<text x="{_x(curve.strains[0]) + 6:.1f}" y="{_y(shares[0]) - 6:.1f}">{name}</text>'
        )
    x = _x(min(max(curve.chosen, curve.strains[0]), curve.strains[-1]))
    words = (
        f"Shared area against accepted strain, from {curve.strains[0]:g} to "
        f"{curve.strains[-1]:g}; {curve.chosen:g} was chosen."
    )
    return (
        f'<svg class="plot" id="strain-curve" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" '
        f'aria-label="{words}"><title>{words}</title>{_grid()}{"".join(lines)}'
        f'<line class="chosen" x1="{x:.1f}" y1="{_y(0):.1f}" x2="{x:.1f}" y2="{_y(1):.1f}" '
        'stroke="currentColor" stroke-dasharray="2 3"/>'
        f'<text x="{x - 5:.1f}" y="{TOP + 12}" text-anchor="end">chosen</text>'
        f'<text class="name" x="{(LEFT + WIDTH - RIGHT) / 2:.1f}" y="{HEIGHT - 6}" '
        'text-anchor="middle">accepted strain</text>'
        f'<text class="name" x="14" y="{_y(0.5):.1f}" text-anchor="middle" '
        f'transform="rotate(-90 14 {_y(0.5):.1f})">shared area</text></svg>'
    )


def _grid() -> str:
    lines = [
        f'<line class="grid" x1="{_x(STRAINS[0]):.1f}" y1="{_y(share):.1f}" '
        f'x2="{_x(STRAINS[-1]):.1f}" y2="{_y(share):.1f}"/>'
        f'<text x="{LEFT - 8}" y="{_y(share) + 4:.1f}" text-anchor="end">{100 * share:.0f} %</text>'
        for share in SHARES
    ]
    lines += [
        f'<line class="grid" x1="{_x(strain):.1f}" y1="{_y(0):.1f}" x2="{_x(strain):.1f}" '
        f'y2="{_y(1):.1f}"/><text x="{_x(strain):.1f}" y="{_y(0) + 17:.1f}" '
        f'text-anchor="middle">{strain:g}</text>'
        for strain in STRAINS
    ]
    return "".join(lines)


def _x(strain: float) -> float:
    """Strains are spaced by their ratio."""
    place = math.log(strain / STRAINS[0]) / math.log(STRAINS[-1] / STRAINS[0])
    return LEFT + place * (WIDTH - LEFT - RIGHT)


def _y(share: float) -> float:
    return HEIGHT - BOTTOM - share * (HEIGHT - TOP - BOTTOM)
