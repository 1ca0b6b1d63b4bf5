"""Compiled: in which directions geodesics leave samples.

A kernel on plain arrays; :mod:`sherd.descriptors.tangent_frames` says what directions are.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from sherd.arrays import Floats, Ints
from sherd.compiled import compiled

__all__ = ["Slopes", "directions"]


class Slopes(NamedTuple):
    """Derivatives at each sample along its two axes: compressed rows of the same vertices."""

    starts: Ints
    vertices: Ints
    along: Floats
    across: Floats


@compiled()
def directions(  # noqa: PLR0913
    rows, places, targets, samples, distances, slopes, x_axes, y_axes, near, angles
):
    """Write the angle (s, t) at which the geodesic from sample i to target j leaves i.

    `rows` count the targets j, whose distances then stay in the cache.
    """
    starts, vertices, along, across = slopes
    for other in range(rows[0], rows[1]):
        away = distances[other]
        for sample in range(len(samples)):
            x, y = 0.0, 0.0
            if away[samples[sample]] < near:
                for axis in range(3):
                    chord = targets[other, axis] - places[sample, axis]
                    x += chord * x_axes[sample, axis]
                    y += chord * y_axes[sample, axis]
            else:
                for entry in range(starts[sample], starts[sample + 1]):
                    distance = away[vertices[entry]]
                    if distance < math.inf:
                        x -= along[entry] * distance
                        y -= across[entry] * distance
            angles[sample, other] = math.atan2(y, x)
