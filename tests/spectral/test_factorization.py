"""Large systems are factorized as well, which minimum degree alone never finishes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from sherd.spectral.operators import MOST_BY_DEGREE, factorized


def _grid(side: int) -> sparse.csc_array:
    """Laplacian of a square grid with diagonals, as of a triangle mesh, and a little of itself."""
    number = np.arange(side * side).reshape(side, side)
    pairs = (
        (number[:, :-1], number[:, 1:]),
        (number[:-1], number[1:]),
        (number[:-1, :-1], number[1:, 1:]),
    )
    rows, columns = (np.concatenate([pair[k].ravel() for pair in pairs]) for k in (0, 1))
    half = sparse.coo_array((np.ones(len(rows)), (rows, columns)), shape=(side**2,) * 2).tocsr()
    graph = half + half.T
    degree = sparse.diags_array(np.asarray(graph.sum(axis=1)).ravel() + 0.1)
    return sparse.csc_array(degree - graph)


@pytest.mark.parametrize("side", [30, 420])
def test_it_solves_and_both_permutations_are_one(side: int) -> None:
    matrix = _grid(side)
    assert (matrix.shape[0] > MOST_BY_DEGREE) == (side > 100)
    found = factorized(matrix)
    assert np.array_equal(found.perm_r, found.perm_c)
    right = np.random.default_rng(0).standard_normal(matrix.shape[0])
    assert np.abs(matrix @ found.solve(right) - right).max() < 1e-9


def test_a_singular_one_is_refused() -> None:
    with pytest.raises(RuntimeError):
        factorized(sparse.csc_array((3, 3)))
