"""General solvers from other hands on the same programs (optional extra `witness`)."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from sherd.arrays import Floats
from sherd.energy.quadratic import BoundedQuadratic, StructuredQuadratic

__all__ = ["clarabel_dense", "piqp_all_vertex", "piqp_dense", "witnesses_installed"]


# Asked of every witness: an objective good to about 1e-8, as that of sherd's own solvers.
ACCURACY = 1e-8


def witnesses_installed() -> bool:
    """True if PIQP and Clarabel can be imported."""
    try:
        import clarabel  # noqa: F401, PLC0415
        import piqp  # noqa: F401, PLC0415
    except ImportError:
        return False
    return True


def piqp_dense(problem: BoundedQuadratic) -> Floats:
    """Point (k,) of the subspace program by PIQP's dense interior point method."""
    import piqp  # noqa: PLC0415  optional

    solver = piqp.DenseSolver()
    solver.settings.eps_abs = solver.settings.eps_rel = ACCURACY
    count = len(problem.rows)
    equality, target = _equality(problem)
    solver.setup(
        np.asfortranarray(problem.matrix),
        problem.linear,
        np.asfortranarray(equality),
        target,
        np.asfortranarray(problem.rows),
        np.zeros(count),
        np.ones(count),
    )
    solver.solve()
    return np.array(solver.result.x)


def clarabel_dense(problem: BoundedQuadratic) -> Floats:
    """Point (k,) of the subspace program by Clarabel's interior point method."""
    import clarabel  # noqa: PLC0415  optional

    count = len(problem.rows)
    equality, target = _equality(problem)
    constraints = np.vstack([equality, problem.rows, -problem.rows])
    bounds = np.concatenate([target, np.ones(count), np.zeros(count)])
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    solver = clarabel.DefaultSolver(
        sparse.csc_matrix(np.triu(problem.matrix)),
        problem.linear,
        sparse.csc_matrix(constraints),
        bounds,
        [clarabel.ZeroConeT(len(target)), clarabel.NonnegativeConeT(2 * count)],
        settings,
    )
    return np.array(solver.solve().x)


def piqp_all_vertex(problem: StructuredQuadratic) -> Floats:
    """Membership (n,) of the all-vertex program by PIQP's sparse method.

    The low-rank term becomes d further unknowns `y = V'u`, so that every matrix is sparse or has
    d dense rows; this is the kindest form for a general solver.
    """
    import piqp  # noqa: PLC0415  optional

    count, rank = problem.low_rank.shape
    quadratic = sparse.block_diag([problem.sparse_matrix, sparse.eye(rank)], format="csc")
    links = sparse.hstack([sparse.csc_matrix(problem.low_rank.T), -sparse.eye(rank)])
    rows, values = [links], [np.zeros(rank)]
    if problem.equality is not None:
        scaled = problem.equality[None, :] / problem.target
        rows.append(sparse.hstack([sparse.csc_matrix(scaled), sparse.csc_matrix((1, rank))]))
        values.append(np.ones(1))
    lower = np.concatenate([np.zeros(count), np.full(rank, -np.inf)])
    upper = np.concatenate([np.ones(count), np.full(rank, np.inf)])
    solver = piqp.SparseSolver()
    solver.settings.eps_abs = solver.settings.eps_rel = ACCURACY
    solver.setup(
        sparse.csc_matrix(quadratic),
        np.concatenate([problem.linear, np.zeros(rank)]),
        sparse.csc_matrix(sparse.vstack(rows)),
        np.concatenate(values),
        None,
        None,
        None,
        lower,
        upper,
    )
    solver.solve()
    return np.array(solver.result.x[:count])


def _equality(problem: BoundedQuadratic) -> tuple[Floats, Floats]:
    """The equality as rows (1 or 0, k) with values, its target scaled to 1."""
    if problem.equality is None:
        return np.zeros((0, len(problem.linear))), np.zeros(0)
    return problem.equality[None, :] / problem.target, np.ones(1)
