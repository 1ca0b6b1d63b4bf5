"""From a soft membership to a crisp region of the right area, without crumbs and pinholes."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from sherd.arrays import Bools, Floats, Ints

__all__ = ["clean_region", "grow_region", "pieces", "raised_to_area", "threshold_to_area"]


# A piece or hole below this share of the part's area is an artifact of thresholding: a disk of
# this area is about as wide as the boundary layer of the membership.
SMALLEST_PIECE = 0.02
# Dropping a piece moves the threshold, which may cut off another; this settles at once or soon.
CLEANING_PASSES = 5


def threshold_to_area(scores: Floats, areas: Floats, area: float) -> Bools:
    """The vertices of highest score (n,) whose areas add up to `area`, as near as they can.

    Ties go to the lower index. At least one vertex is taken.
    """
    order = np.argsort(-scores, kind="stable")
    total = np.cumsum(areas[order])
    count = int(np.searchsorted(total, area))
    # take the next vertex as well if that comes nearer to the area
    if count < len(order):
        before = total[count - 1] if count else 0.0
        count += int(total[count] - area <= area - before)
    mask = np.zeros(len(scores), dtype=bool)
    mask[order[: max(count, 1)]] = True
    return mask


def pieces(mask: Bools, adjacency: sparse.csr_array) -> Ints:
    """Number of the connected piece of each vertex in `mask` (n,), from 0; -1 outside."""
    inside = np.flatnonzero(mask)
    labels = np.full(len(mask), -1, dtype=np.int64)
    if len(inside):
        _, found = csgraph.connected_components(adjacency[inside][:, inside], directed=False)
        labels[inside] = found
    return labels


def clean_region(
    scores: Floats, areas: Floats, area: float, *, adjacency: sparse.csr_array
) -> Bools:
    """Threshold to the area, then drop small pieces and fill small holes at the same area.

    Several large pieces are left alone: a part may have several components.
    """
    adjusted = scores.astype(np.float64)
    for _ in range(CLEANING_PASSES):
        mask = threshold_to_area(adjusted, areas, area)
        crumbs = _small(mask, areas, area, adjacency)
        holes = _small(~mask, areas, area, adjacency)
        if crumbs[mask].all():  # nothing large is left to keep
            return mask
        if not crumbs.any() and not holes.any():
            return mask
        adjusted[crumbs] = -np.inf
        adjusted[holes] = np.inf
    return threshold_to_area(adjusted, areas, area)


def grow_region(core: Bools, distances: Floats, areas: Floats, area: float) -> Bools:
    """Add the vertices nearest to `core` (n,) until the area is met.

    `distances` (n,) are geodesic distances to the core, 0 on it. This is the way back from the
    region of the part's interior to that of the whole part: the band that was left out has the
    same width everywhere.
    """
    reachable = np.where(core, -1.0, np.where(np.isfinite(distances), distances, 1e300))
    return threshold_to_area(-reachable, areas, area) | core


def raised_to_area(membership: Floats, areas: Floats, area: float) -> Floats:
    """`membership ** g` with g > 0 such that it integrates to `area`, or comes nearest.

    A power keeps the order and the bounds of a membership (n,) in [0, 1].
    """
    low, high = -10.0, 10.0  # exponents of 2: beyond, every value is 0 or 1 to the eye
    for _ in range(50):
        middle = 0.5 * (low + high)
        if areas @ membership ** (2.0**middle) > area:
            low = middle
        else:
            high = middle
    raised: Floats = membership ** (2.0**high)
    return raised


def _small(mask: Bools, areas: Floats, area: float, adjacency: sparse.csr_array) -> Bools:
    labels = pieces(mask, adjacency)
    if labels.max() < 0:
        return np.zeros(len(mask), dtype=bool)
    sizes = np.bincount(labels[mask], areas[mask])
    small = sizes < SMALLEST_PIECE * area
    result = np.zeros(len(mask), dtype=bool)
    result[mask] = small[labels[mask]]
    return result
