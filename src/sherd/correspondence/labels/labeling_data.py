"""What the kernels of the labeling work on, by name.

Named tuples of arrays, which compiled kernels take as they are. Lengths are in units of
sqrt(area of the full shape), angles in radians.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numpy.typing import NDArray

from sherd.arrays import Floats, Ints, Singles

__all__ = ["Comparison", "EdgeMeasures", "FullGeometry", "PartGeometry", "State"]


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
    """Distances (s, s) between the labels; cosine and sine (s, s, 2) of geodesic directions."""

    between: NDArray[Any]
    headings: Singles


class State(NamedTuple):
    """The label (k,) and the tangent rotation (k,) of each node."""

    labels: Ints
    rotations: Floats
