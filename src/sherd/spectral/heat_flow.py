"""HeatFlow: the two factorizations of the heat method, and distances by them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from sherd.arrays import Floats, Ints
from sherd.spectral.heat_kernel import LANES, Factor, Slopes, heat_distances
from sherd.spectral.intrinsic import IntrinsicTriangulation
from sherd.spectral.operators import factorized
from sherd.threads import over_rows

__all__ = ["HeatFlow", "heat_flow"]

# A constant may be added to distances, so their system is singular; with this much of the identity
# it is not, and distances of a few units change by less than a millionth.
SHIFT = 1e-7


@dataclass(frozen=True, eq=False)
class HeatFlow:
    """The heat method on a surface of unit area, ready for questions.

    Attributes
    ----------
    slopes
        Gradients in the triangles.
    heat, poisson
        `A + t W` with time t the square of the mean edge, and `W + SHIFT A`.
    """

    slopes: Slopes
    heat: Factor
    poisson: Factor

    def distances(self, sources: Ints, starts: Ints) -> Floats:
        """Distance (s, n) to the nearest source of each set `sources[starts[i]:starts[i + 1]]`.

        Meaningless on other components, and possibly not finite on damaged ones; below 0 where the
        method takes a vertex for nearer than the source.
        """
        sets = len(starts) - 1
        result = np.empty((sets, len(self.heat.inverse)))
        blocks = -(-sets // LANES)
        over_rows(
            heat_distances, blocks, sources, starts, self.slopes, self.heat, self.poisson, result
        )
        return result


def heat_flow(triangles: IntrinsicTriangulation, count: int) -> HeatFlow | None:
    """Set up the heat method for `count` vertices of a surface near unit area; None if it fails.

    References
    ----------
    Crane, Weischedel, Wardetzky, *Geodesics in heat*, 2013, sections 3.2 and 3.2.4.
    """
    if len(triangles.faces) == 0:
        return None
    weak, areas = triangles.stiffness_and_areas(count)
    mass = sparse.diags_array(areas)
    try:
        heat = _factor(sparse.csc_array(mass + triangles.lengths.mean() ** 2 * weak))
        poisson = _factor(sparse.csc_array(weak + SHIFT * mass))
    except RuntimeError:  # an exactly singular matrix
        return None
    return HeatFlow(_slopes(triangles), heat, poisson)


def _slopes(triangles: IntrinsicTriangulation) -> Slopes:
    x1, x2, y2 = triangles.corners().T
    parts = np.stack([1 / x1, x2 / (x1 * y2), 1 / y2, 0.5 * x1 * y2], axis=1)
    return Slopes(triangles.faces, parts)


def _factor(matrix: sparse.csc_array) -> Factor:
    """L D L' of a symmetric positive definite matrix."""
    factor = factorized(matrix)
    if not np.array_equal(factor.perm_r, factor.perm_c):
        raise RuntimeError("pivots off the diagonal")
    lower = sparse.csc_array(sparse.tril(factor.L, -1))
    return Factor(
        place=factor.perm_r.astype(np.int64),
        starts=lower.indptr.astype(np.int64),
        rows=lower.indices.astype(np.int64),
        values=lower.data,
        inverse=1.0 / factor.U.diagonal(),
    )
