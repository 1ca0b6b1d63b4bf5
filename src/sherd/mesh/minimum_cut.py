"""Energies of two values per variable, minimized exactly: a minimum cut."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from sherd.arrays import Bools, Floats, Ints

__all__ = ["minimum_cut"]

# Capacities are 32-bit whole numbers, and so is their flow: a billionth of the largest is exact
# enough, and twice as many steps would overflow.
UNITS = 1_000_000_000


def minimum_cut(
    extra: Floats, pairs: tuple[Ints, Ints], prices: Floats, back: Floats | None = None
) -> Bools:
    """Values x (a,) bool of least energy, a minimum cut.

        E(x) = sum extra_i x_i + sum prices_p [x_i = 0, x_j = 1] + sum back_p [x_i = 1, x_j = 0]

    over pairs p = (i, j), each of which is named once.

    Parameters
    ----------
    extra
        (a,) what a 1 costs more than a 0.
    pairs
        (p,) first and (p,) second variables.
    prices, back
        (p,) at least 0, where the two differ; `back` is `prices` if None.

    Notes
    -----
    Of several answers the one with the most ones.

    References
    ----------
    Kolmogorov and Zabih, *What energy functions can be minimized via graph cuts?*, 2004.
    """
    back = prices if back is None else back
    count = len(extra)
    source, sink = count, count + 1
    up, down = np.flatnonzero(extra > 0), np.flatnonzero(extra < 0)
    rows = np.concatenate([np.full(len(up), source), down, pairs[0], pairs[1]])
    columns = np.concatenate([up, np.full(len(down), sink), pairs[1], pairs[0]])
    values = np.concatenate([extra[up], -extra[down], prices, back])
    # the flow is at most the sum of all that leaves the source
    largest = max(np.abs(extra).sum(), prices.max(initial=0.0), back.max(initial=0.0), 1e-300)
    capacity = np.ceil(UNITS / largest * values).astype(np.int32)
    graph = sparse.csr_array((capacity, (rows, columns)), shape=(count + 2, count + 2))
    left = graph - csgraph.maximum_flow(graph, source, sink).flow
    left.data = np.maximum(left.data, 0)
    left.eliminate_zeros()
    zeros = csgraph.breadth_first_order(left, source, return_predecessors=False)
    ones = np.ones(count + 2, dtype=bool)
    ones[zeros] = False
    return ones[:count]
