"""Question: the two described shapes, what the user knows, and how lengths are compared."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.correspondence.labels.labeling_data import Comparison
from sherd.surface.described import DescribedSurface
from sherd.surface.samples import Labels

__all__ = ["NO_PINS", "Pins", "Question"]

# A pin holds one vertex as firmly as the surface is held, against all its neighbors.
PIN_LENGTH = 0.002


@dataclass(frozen=True, eq=False)
class Pins:
    """Landmarks that the user gave.

    Attributes
    ----------
    vertices
        (p,) vertices of the part's working mesh, among its sparse samples.
    positions
        (p, 3) where they belong, in the frame of the full shape.
    landmarks
        (p, 2) vertices of the part and of the full shape, as the user counts.
    length
        How firmly they hold: against neighbors that pull farther than this.
    """

    vertices: Ints
    positions: Floats
    landmarks: Ints
    length: float = PIN_LENGTH


NO_PINS = Pins(np.empty(0, dtype=np.int64), np.empty((0, 3)), np.empty((0, 2), dtype=np.int64))


@dataclass(frozen=True, eq=False)
class Question:
    """What is asked: where on `full` each point of `part` lies.

    Attributes
    ----------
    full, part
        The two shapes. Sparse samples of `part`, the nodes, get `labels`.
    comparison
        How lengths and directions are compared.
    pins
        Landmarks.
    free
        (n,) bool, vertices of the full shape's working mesh where nodes may be placed, since
        nothing else lies there; all if None.
    other_labels
        Labels other than the dense samples of `full`.
    """

    full: DescribedSurface
    part: DescribedSurface
    comparison: Comparison
    pins: Pins = NO_PINS
    free: Bools | None = None
    other_labels: Labels | None = None

    @property
    def labels(self) -> Labels:
        """Vertices of `full` that stand for its places."""
        return self.full.dense if self.other_labels is None else self.other_labels

    def with_part(self, part: DescribedSurface) -> Question:
        """The same question about another part, such as the mirror image."""
        return replace(self, part=part)

    def with_stretch(self, stretch: float) -> Question:
        """The same question, where a length may be off by this share of itself."""
        return replace(self, comparison=self.comparison._replace(stretch_sigma=stretch))
