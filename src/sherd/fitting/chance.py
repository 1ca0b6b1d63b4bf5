"""Chances: how surely a vertex of a fit is near where it truly is, without the truth."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from sherd.arrays import Bools, Floats
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["chances", "distances_beyond"]

# The median error, in sqrt(area of the full shape), of what was seen where the map is surest and
# where it is least sure, and how it grows along the surface beyond the cut. From parts of 0.35, 0.5
# and 0.7 of two horses, a cat, a lion and a person in other poses, 15 right matches in two sets:
# medians of 0.003 and 0.004 where the confidence was above 0.98, of 0.03 and 0.02 below 0.5; beyond
# the cut of 0.028 and 0.025 at 0.075, 0.10 and 0.06 at 0.25, 0.22 and 0.12 at 0.4.
SURE_ERROR, UNSURE_ERROR = 0.004, 0.04
GROWTH = 0.35
# Chance that an error is below r for a median m: 1 - 2^-(r / m)^SHAPE, a Weibull distribution. Of
# vertices of both sets that it promised less than 0.1, 0.15 and 0.07 were within 0.02, of those
# with 0.4 to 0.5, 0.48 and 0.49, of those above 0.9, 0.92 and 0.97.
SHAPE = 1.2
# Where what was seen is larger or smaller than the full shape, it is of another individual, or its
# map is stretched: either way points slid. So much of the mean logarithm is added to the median. Of
# four faces of other people, seen vertices whose confidence was above 0.9 were near in 0.73 of the
# cases where this promises 0.66, and in 0.84 for 0.87 where sizes were fitted; of twelve right maps
# of poses in 0.90 for 0.85. Without it, 0.99 was promised throughout.
GROWN_ERROR = 0.15


def distances_beyond(shape: TriangleMesh, seen: Bools) -> Floats:
    """Length (n,) of the shortest path of edges from what was seen; inf on other components."""
    if not seen.any():
        return np.full(shape.vertex_count, np.inf)
    first, second = shape.edges.T
    lengths = np.linalg.norm(shape.vertices[first] - shape.vertices[second], axis=1)
    graph = sparse.csr_array(
        (np.maximum(lengths, 1e-12), (first, second)), shape=(shape.vertex_count,) * 2
    )
    found: Floats = csgraph.dijkstra(
        graph, directed=False, indices=np.flatnonzero(seen), min_only=True
    )
    return found


def chances(
    beyond: Floats, confidence: Floats, *, near: float, placed: float, grown: float
) -> Floats:
    """Chance (n,) that a vertex is within `near` of where it truly is.

    Parameters
    ----------
    beyond
        (n,) distance along the surface from what was seen; 0 where it was, inf if not connected.
    confidence
        (n,) of the map, 0 beyond.
    near
        In units of sqrt(area of the full shape), as all lengths.
    placed
        Chance that the pieces belong where the map has them: if not, nothing is near.
    grown
        Mean logarithm of how much longer what was seen is than on the full shape, at its size.
    """
    here = beyond == 0
    sure = np.where(here, confidence, confidence[here].mean() if here.any() else 0.0)
    median = UNSURE_ERROR ** (1 - sure) * SURE_ERROR**sure + GROWTH * beyond
    median += GROWN_ERROR * abs(grown)
    chance: Floats = placed * (1.0 - 0.5 ** ((near / median) ** SHAPE))
    return chance
