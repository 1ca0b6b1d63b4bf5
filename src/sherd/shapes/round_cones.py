"""A smooth body as the level set of a smooth union of round cones.

A round cone is the union of the spheres along a segment whose radius changes linearly. Its
signed distance is exact, `d(x) = min over t in [0, 1] of |x - c(t)| - r(t)`. The smooth union
`f = -w log sum_i exp(-d_i / w)` is as smooth as the distances and never changes faster than 1
per unit length; its gradient is `sum_i s_i grad d_i` with `s = softmax(-d / w)`. It is taken
twice: within each group of cones with the group's own width (narrow along a limb, whose joints
would swell otherwise), then over the groups with a wide one that fills the seams.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sherd.arrays import Floats, Ints

__all__ = ["RoundCones", "softmin_weights"]


# Points at a time: the working arrays of (points, cones, 3) stay in the cache or near it.
BLOCK = 8192
# Where two sides of a fold meet their gradients cancel; Newton's step is no longer than if the
# slope were this, so that a point stays on its own side.
FLATTEST = 0.3


@dataclass(frozen=True, eq=False)
class RoundCones:
    """Round cones and the width over which they melt into each other.

    Attributes
    ----------
    starts, directions
        (c, 3) float, l: segment from `starts` to `starts + directions`.
    radii
        (c, 2) float, l: radius at the two ends.
    groups
        (c,) int from 0: the group of each cone.
    widths
        (g,) float, l: w within each group; seams are rounded over a few w.
    seam
        l: w between the groups.
    """

    starts: Floats
    directions: Floats
    radii: Floats
    groups: Ints
    widths: Floats
    seam: float

    def distances(self, points: Floats) -> tuple[Floats, Floats]:
        """Signed distance to each cone (p, c) l, and its unit gradient (p, c, 3)."""
        length = np.linalg.norm(self.directions, axis=1)
        axis = self.directions / length[:, None]
        taper = (self.radii[:, 0] - self.radii[:, 1]) / length
        slope = taper / np.sqrt(1.0 - taper**2)
        offset = points[:, None] - self.starts
        along = np.einsum("pcx,cx->pc", offset, axis)
        square = np.einsum("pcx,pcx->pc", offset, offset)
        across = np.sqrt(np.maximum(square - along**2, 0.0))
        # the sphere that is nearest has its center where the cone's normal meets the axis
        center = np.clip(along - slope * across, 0.0, length)
        gap = offset - center[:, :, None] * axis
        norm = np.sqrt(np.einsum("pcx,pcx->pc", gap, gap))
        radius = self.radii[:, 0] - taper * center
        return norm - radius, gap / np.maximum(norm, 1e-12)[:, :, None]

    def value_and_gradient(self, points: Floats) -> tuple[Floats, Floats]:
        """Value of the union (p,) l, negative inside, and its gradient (p, 3)."""
        values, gradients = np.empty(len(points)), np.empty((len(points), 3))
        for begin in range(0, len(points), BLOCK):
            block = slice(begin, begin + BLOCK)
            distances, units = self.distances(points[block])
            weights, values[block] = self._union(distances)
            gradients[block] = np.einsum("pc,pcx->px", weights, units)
        return values, gradients

    def _union(self, distances: Floats) -> tuple[Floats, Floats]:
        """Weight of each cone (p, c) in the smooth union, and its value (p,)."""
        weights = np.empty_like(distances)
        joined = np.empty((len(distances), len(self.widths)))
        for group, width in enumerate(self.widths):
            members = self.groups == group
            weights[:, members], joined[:, group] = softmin_weights(distances[:, members], width)
        outer, values = softmin_weights(joined, self.seam)
        return weights * outer[:, self.groups], values

    def projected(self, points: Floats, *, steps: int = 3) -> Floats:
        """Points near the surface moved onto it along the gradient (Newton's method)."""
        for _ in range(steps):
            values, gradients = self.value_and_gradient(points)
            squared = np.maximum(np.einsum("px,px->p", gradients, gradients), FLATTEST**2)
            points = points - (values / squared)[:, None] * gradients
        return points

    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper corner (3,) of a box that holds the surface with room to spare."""
        # n cones that coincide push the surface out by w log n
        swelling = (self.widths.max() + self.seam) * np.log(len(self.starts))
        reach = self.radii.max(axis=1)[:, None] + swelling
        ends = self.starts + self.directions
        lower = (np.minimum(self.starts, ends) - reach).min(axis=0)
        upper = (np.maximum(self.starts, ends) + reach).max(axis=0)
        return lower, upper


def softmin_weights(values: Floats, width: float) -> tuple[Floats, Floats]:
    """Weights (p, c) of the smooth minimum over the last axis, summing to 1, and its value (p,)."""
    smallest = values.min(axis=1, keepdims=True)
    powers = np.exp((smallest - values) / width)
    total = powers.sum(axis=1, keepdims=True)
    return powers / total, (smallest - width * np.log(total))[:, 0]
