"""What the kernels of the labeling work on, by name.

Named tuples of arrays, which compiled kernels take as they are. Lengths are in units of
sqrt(area of the full shape), angles in radians.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sherd.arrays import Floats, Ints, Singles, frozen
from sherd.surface.counted import TURN

__all__ = ["Comparison", "EdgeMeasures", "FullGeometry", "PartGeometry", "State", "turn_costs"]


class Comparison(NamedTuple):
    """How lengths and directions are compared.

    Attributes
    ----------
    length_sigma, stretch_sigma
        A length d may be off by `length_sigma + stretch_sigma d`.
    limit
        Beyond so many squared sigmas a pair says "wrong" and not more.
    longer_limit
        The same where the length on the full shape is the longer one.
    angle_sigma
        A direction may be off by so much.
    """

    length_sigma: float
    stretch_sigma: float
    limit: float
    longer_limit: float
    angle_sigma: float


class EdgeMeasures(NamedTuple):
    """What is known of each pair of nodes that is compared, (e,) each.

    Attributes
    ----------
    length
        On the part; infinite between components.
    lower
        Lower bound of the length on the full shape.
    equality
        In [0, 1], belief that both lengths are equal; 1 where the path cannot have met the cut.
    weight
        Of the edge.
    turn
        Weight of the comparison of directions.
    """

    length: Floats
    lower: Floats
    equality: Floats
    weight: Floats
    turn: Floats


class PartGeometry(NamedTuple):
    """Distances (k, k) between the nodes and the angles (k, k) of geodesics from node to node."""

    between: NDArray[Any]
    directions: Singles


class FullGeometry(NamedTuple):
    """Distances and directions between the labels (s, s).

    Attributes
    ----------
    between
        Distances.
    directions
        Angles at which the geodesics from label i to label j leave i.
    leaving, arriving
        The same from i to j and from j to i, in steps of a turn over `TURN`: a quarter of what
        cosines and sines would take, and nearer to each other, which makes up half of the time.
    """

    between: NDArray[Any]
    directions: Singles
    leaving: NDArray[np.uint16]
    arriving: NDArray[np.uint16]


@cache  # a millisecond, and every node that is grown asks
def turn_costs(comparison: Comparison) -> Singles:
    """What it costs (`TURN`,) when two directions differ by so many steps.

    The squared length of the difference of their unit vectors over the squared `angle_sigma`,
    at most `limit` (Geman-McClure).
    """
    off = 2.0 - 2.0 * np.cos(np.arange(TURN) * (2.0 * np.pi / TURN))
    squared = off / comparison.angle_sigma**2
    costs: Singles = (squared / (1.0 + squared / comparison.limit)).astype(np.float32)
    return frozen(costs)


class State(NamedTuple):
    """The label (k,) and the tangent rotation (k,) of each node."""

    labels: Ints
    rotations: Floats
