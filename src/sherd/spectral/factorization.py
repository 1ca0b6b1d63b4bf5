"""Sparse symmetric positive definite systems, factorized once for many right sides."""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import SuperLU, splu

__all__ = ["factorized"]

# Minimum degree on the pattern of A' + A has two thirds of the fill of COLAMD on triangle meshes.
# But in SuperLU it does not come back for meshes of 160,000 vertices and more (SciPy 1.17; it takes
# a second for 150,000), so well before that the other one orders.
MOST_BY_DEGREE = 100_000


def factorized(matrix: sparse.csc_array) -> SuperLU[np.float64]:
    """L U of a symmetric positive definite matrix (n, n), rows and columns in one order.

    SuperLU in its symmetric mode takes pivots on the diagonal, so both permutations are one.

    Raises
    ------
    RuntimeError
        If the matrix is exactly singular.
    """
    by_degree = matrix.shape[0] <= MOST_BY_DEGREE
    order: Literal["MMD_AT_PLUS_A", "COLAMD"] = "MMD_AT_PLUS_A" if by_degree else "COLAMD"
    return splu(matrix, permc_spec=order, diag_pivot_thresh=0.0, options={"SymmetricMode": True})
