"""Elasticity: a shape that is bent, turned and sized with as little strain as possible.

    E(p) = sum over edges w_ij |p_i - p_j - (A_i + A_j) / 2 (y_i - y_j)|^2 + sum_i m_i |p_i - t_i|^2

with y the rest positions, A_i a rotation times a size, w_ij cotangent weights, and m_i how firmly
vertex i is drawn to t_i. For given A it is a linear problem with a matrix that does not depend on
A. Where nothing is seen, positions cannot tell how the shape is turned, only how its neighbors are:
there rotations continue smoothly, which keeps a limb as it is beyond the cut. On their own, as in
the founding paper, they would need hundreds of rounds for that, and shear the limb at the cut.

References
----------
Sorkine, Alexa, *As-rigid-as-possible surface modeling*, 2007, equations 3, 5, 8 and 9.
Levi, Gotsman, *Smooth rotation enhanced as-rigid-as-possible mesh animation*, 2015, equation 5:
the smooth rotations; here they are smoothed by one linear problem for all vertices, then projected,
and the length over which that happens differs between what was seen and what was not.
Schweikert, *An interpolation curve using a spline in tension*, 1966: the continuation.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import sparse

from sherd.arrays import Bools, Floats
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.operators import factorized, graph_laplacian
from sherd.surface.elastic_surface import ElasticSurface, elastic_surface
from sherd.threads import cached_property

__all__ = ["Elasticity"]

# Components without data stay where they are; beside cotangents of order 1 this moves nothing.
HOLD = 1e-9
# Edges of a vertex that say how it is turned: two lie in one plane with any noise.
FEWEST_EDGES = 3


class Elasticity:
    """The edges of a mesh as springs, and the linear problems on them.

    Parameters
    ----------
    mesh
        In units of sqrt(area of the full shape).
    """

    def __init__(self, mesh: TriangleMesh) -> None:
        self.mesh = mesh
        self.areas = np.maximum(mesh.vertex_areas, 1e-12)
        self.surface: ElasticSurface = elastic_surface(mesh)
        pointers, neighbors, weights, self.rest = self.surface
        count = mesh.vertex_count
        self.springs = sparse.csr_array((weights, neighbors, pointers), shape=(count, count))

    @cached_property
    def laplacian(self) -> sparse.csr_array:
        """(n, n) matrix of `sum w_ij |x_i - x_j|^2`, each edge once."""
        return graph_laplacian(self.springs)

    def fitted_rotations(self, positions: Floats) -> Floats:
        """The rotation (n, 3, 3) of each vertex that fits its edges best (equation 5)."""
        from sherd.correspondence.elastic_kernel import fit_rotations  # noqa: PLC0415 - numba

        return fit_rotations(self.surface, positions)

    def seen_rotations(self, positions: Floats, seen: Bools) -> tuple[Floats, Bools]:
        """The rotation of each vertex (n, 3, 3) that fits those edges best that were seen whole.

        And which vertices (n,) have the three such edges that tell a rotation from noise.
        """
        from sherd.correspondence.elastic_kernel import fit_rotations  # noqa: PLC0415 - numba

        pointers, neighbors, weights, _ = self.surface
        whole = np.repeat(seen, np.diff(pointers)) & seen[neighbors]
        edges = sparse.csr_array(
            (whole.astype(np.float64), neighbors, pointers), self.springs.shape
        )
        known: Bools = np.asarray(edges.sum(axis=1)) >= FEWEST_EDGES
        return fit_rotations(self.surface._replace(weights=weights * whole), positions), known

    def strains(self, positions: Floats, turns: Floats) -> Floats:
        """Relative strain (n,) at each vertex, beside the rotations times sizes `turns`."""
        from sherd.correspondence.elastic_kernel import strains  # noqa: PLC0415 - numba

        return strains(self.surface, positions, turns)

    def fitted_sizes(self, positions: Floats) -> Floats:
        """How many times longer (n,) the edges of each vertex are, root of weighted squares."""
        grown = _spread(self.springs, positions) / np.maximum(
            _spread(self.springs, self.rest), 1e-300
        )
        sizes: Floats = np.sqrt(np.maximum(grown, 0.0))
        return sizes

    def relaxation(self, pulls: Floats) -> Callable[[Floats, Floats, Floats], Floats]:
        """The solver of E for fixed `pulls` (n,), the m_i.

        It takes rotations times sizes (n, 3, 3), targets (n, 3), and positions (n, 3) that parts
        without any pull keep the center of; it returns positions (n, 3).
        """
        solve = _solver(self.laplacian + sparse.diags_array(pulls + HOLD))

        def relaxed(turns: Floats, targets: Floats, start: Floats) -> Floats:
            pulled = self._turned_edges(turns) + pulls[:, None] * targets + HOLD * start
            return solve(pulled)

        return relaxed

    def smoothing(self, certainty: Floats, lengths: Floats) -> Callable[[Floats, Floats], Floats]:
        """The solver that minimizes `sum a_i c_i |x_i - v_i|^2 + integral length^2 |grad x|^2`.

        Parameters
        ----------
        certainty
            (n,) the c_i, at least 0; where it is 0, x continues harmonically.
        lengths
            (n,) over which x is smoothed.

        Returns
        -------
        function
            Of values v (n, k) and of others (n, k), which components without certainty get.
        """
        pointers, neighbors, weights, _ = self.surface
        firm = np.repeat(lengths**2, np.diff(pointers)) + lengths[neighbors] ** 2
        springs = sparse.csr_array((0.5 * weights * firm, neighbors, pointers), self.springs.shape)
        known = self.areas * certainty
        solve = _solver(graph_laplacian(springs) + sparse.diags_array(known + HOLD * self.areas))

        def smoothed(values: Floats, otherwise: Floats) -> Floats:
            return solve(known[:, None] * values + (HOLD * self.areas)[:, None] * otherwise)

        return smoothed

    def continuation(self, firmness: Floats, length: float) -> Callable[[Floats, Floats], Floats]:
        """The solver that minimizes `sum a_i f_i |x_i - v_i|^2 + E_1 + length^2 E_2`.

        E_1 is the integral of the squared gradient of x, E_2 that of its squared Laplacian: a
        spline under tension. Where nothing is known x goes on as it changed at the border, and so
        less and less over `length`; with a length of 0 it would not go on at all.

        Parameters
        ----------
        firmness
            (n,) the f_i, at least 0.
        length
            In units of the mesh.

        Returns
        -------
        function
            Of values v (n, k) and of others (n, k), which components without firmness get.
        """
        bends = self.laplacian @ sparse.diags_array(1.0 / self.areas) @ self.laplacian
        known = self.areas * firmness
        stiff = self.laplacian + length**2 * bends
        solve = _solver((stiff + sparse.diags_array(known + HOLD)).tocsr())

        def continued(values: Floats, otherwise: Floats) -> Floats:
            return solve(known[:, None] * values + HOLD * otherwise)

        return continued

    def _turned_edges(self, turns: Floats) -> Floats:
        """Sum over the edges of each vertex of w_ij (A_i + A_j) / 2 (y_i - y_j), (n, 3)."""
        rest, springs = self.rest, self.springs
        own = np.einsum("nij,nj->ni", turns, self.laplacian @ rest)
        around = np.asarray(springs @ turns.reshape(-1, 9)).reshape(-1, 3, 3)
        theirs = np.einsum("nij,nj->ni", around, rest)
        theirs -= springs @ np.einsum("nij,nj->ni", turns, rest)
        total: Floats = 0.5 * (own + theirs)
        return total


def _spread(springs: sparse.csr_array, positions: Floats) -> Floats:
    """Sum over the edges of each vertex of w_ij |x_i - x_j|^2, (n,)."""
    squares = (positions**2).sum(axis=1)
    spread: Floats = springs.sum(axis=1) * squares + springs @ squares
    spread -= 2 * np.einsum("ni,ni->n", positions, springs @ positions)
    return spread


def _solver(matrix: sparse.csr_array) -> Callable[[Floats], Floats]:
    """Direct solver of a symmetric positive definite problem; many right sides are cheap."""
    factors = factorized(matrix.tocsc())

    def solve(right: Floats) -> Floats:
        return np.asarray(factors.solve(np.ascontiguousarray(right)), dtype=np.float64)

    return solve
