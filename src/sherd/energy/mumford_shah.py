"""The energy of the paper: data term, smoothness, phase field.

A membership u in [0, 1] and a phase field rho in [0, 1] on the vertices of the full shape::

    E(u, rho) = |P' A u - q|^2 / |q|^2                                          data
              + regularity * smoothness / 2 * integral rho^2 |grad u|^2         smoothness
              + regularity * boundary * ( phase_width * integral |grad rho|^2   boundary
                                          + integral (1 - rho)^2 / (4 phase_width) )
              - integral evidence u                                             evidence

subject to `integral u = s`, the part's area. Everything is dimensionless: the data term is
relative to |q|^2, and lengths are measured in sqrt(s), so areas in s. In two dimensions the two
gradient integrals have no unit and need no factor; the integrals of (1 - rho)^2 and of the
evidence are divided by s; `phase_width` is in units of sqrt(s). Scaling both meshes, or
multiplying the descriptors by a constant, changes nothing. As phase_width tends to 0 the
boundary term tends to `regularity * boundary * (length of the jump set of u) / sqrt(s)`.

On a mesh with vertex areas A, face areas and per-face gradient G: `K(rho) = G' diag(face_area *
rho_face^2) G` with rho_face^2 the mean of rho^2 over the corners, and `S(u)` diagonal with `S_ii`
the sum over the faces at i of `face_area / 3 * |grad u|^2`, hence `u' K(rho) u = rho' S(u) rho`
exactly and an alternation over u and rho descends.

Examples
--------
>>> import numpy as np
>>> from sherd.energy.problem import region_problem
>>> from sherd.mesh.triangle_mesh import TriangleMesh
>>> square = TriangleMesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
>>> descriptors = np.eye(4)
>>> problem = region_problem(
...     square, full_descriptors=descriptors, part_integral=[1 / 3, 1 / 6, 0, 0], part_area=0.5
... )
>>> u, rho = np.array([1.0, 1, 0, 0]), np.ones(4)
>>> terms = energy(problem, u, rho)
>>> round(terms.data, 12), round(terms.boundary, 12)
(0.0, 0.0)

References
----------
Hurtado-Jauregui, *Piece-wise partial matching of non-rigid shapes*, equations 4 to 19, with its
slips mended (docs/paper.md lists them); Pokrass, Bronstein, Bronstein, *A correspondence-less
approach to matching of deformable shapes*, 2011; Ambrosio and Tortorelli, 1990.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from sherd.arrays import Floats
from sherd.energy.problem import RegionProblem

__all__ = [
    "EnergyTerms",
    "boundary_term",
    "data_gradient",
    "data_term",
    "energy",
    "evidence_term",
    "gradient_weight",
    "membership_gradient",
    "phase_gradient",
    "phase_quadratic",
    "smoothness_matrix",
    "smoothness_term",
]


@dataclass(frozen=True)
class EnergyTerms:
    """The energy by terms, dimensionless, weights included."""

    data: float
    smoothness: float
    boundary: float
    evidence: float = 0.0

    @property
    def total(self) -> float:
        """The sum, what the solvers lower."""
        return self.data + self.smoothness + self.boundary + self.evidence


def energy(problem: RegionProblem, u: Floats, rho: Floats) -> EnergyTerms:
    """The energy of membership `u` (n,) and phase field `rho` (n,) by terms."""
    return EnergyTerms(
        data=data_term(problem, u),
        smoothness=smoothness_term(problem, u, rho),
        boundary=boundary_term(problem, rho),
        evidence=evidence_term(problem, u),
    )


def data_term(problem: RegionProblem, u: Floats) -> float:
    """`|P'Au - q|^2 / |q|^2`, paper equation 9."""
    residual = problem.weighted_descriptors.T @ u - problem.part_integral
    return float(residual @ residual)


def data_gradient(problem: RegionProblem, u: Floats) -> Floats:
    """Gradient of :func:`data_term` in u, (n,): `2 A P (P'Au - q) / |q|^2`."""
    residual = problem.weighted_descriptors.T @ u - problem.part_integral
    slope: Floats = 2.0 * (problem.weighted_descriptors @ residual)
    return slope


def evidence_term(problem: RegionProblem, u: Floats) -> float:
    """`- integral evidence u / s`."""
    return -float((problem.vertex_areas * problem.evidence) @ u) / problem.part_area


def smoothness_matrix(problem: RegionProblem, rho: Floats) -> sparse.csr_array:
    """K(rho), (n, n) sparse, symmetric: `u' K(rho) u = integral rho^2 |grad u|^2`.

    Paper equation 12 per face; rho^2 on a face is the mean of rho^2 over its corners.
    """
    return _weighted_stiffness(problem, (rho**2)[problem.faces].mean(axis=1))


def gradient_weight(problem: RegionProblem, u: Floats) -> Floats:
    """Diagonal of S(u), (n,): a third of `face_area * |grad u|^2` of each face at the vertex.

    Paper equation 15, gathered so that `rho' S(u) rho = u' K(rho) u`.
    """
    slopes = (problem.gradient @ u).reshape(-1, 3)
    share = problem.face_areas * np.einsum("fc,fc->f", slopes, slopes) / 3.0
    count = problem.vertex_count
    gathered = np.bincount(problem.faces.ravel(), np.repeat(share, 3), count)
    return np.asarray(gathered, dtype=np.float64)


def smoothness_term(problem: RegionProblem, u: Floats, rho: Floats) -> float:
    """`regularity * smoothness / 2 * integral rho^2 |grad u|^2`."""
    weights = problem.weights
    integral = float(gradient_weight(problem, u) @ rho**2)
    return 0.5 * weights.regularity * weights.smoothness * integral


def boundary_term(problem: RegionProblem, rho: Floats) -> float:
    """Length of the boundary in the sense of Ambrosio and Tortorelli, weights included.

    `regularity * boundary * (phase_width rho'W rho + a'(1 - rho)^2 / (4 phase_width s))`, paper
    equations 16 and 17. It does not depend on u; in the paper this function has no u either.
    """
    weights = problem.weights
    width = weights.phase_width
    gap = float(problem.vertex_areas @ (1.0 - rho) ** 2) / problem.part_area
    slope = float(rho @ (problem.stiffness @ rho))
    return weights.regularity * weights.boundary * (width * slope + gap / (4.0 * width))


def membership_gradient(problem: RegionProblem, u: Floats, rho: Floats) -> Floats:
    """Gradient of the total energy in u, (n,)."""
    weights = problem.weights
    smooth = smoothness_matrix(problem, rho) @ u
    slope: Floats = data_gradient(problem, u)
    slope += weights.regularity * weights.smoothness * smooth
    slope -= problem.weighted_evidence
    return slope


def phase_gradient(problem: RegionProblem, u: Floats, rho: Floats) -> Floats:
    """Gradient of the total energy in rho, (n,)."""
    matrix, linear, _ = phase_quadratic(problem, u)
    slope: Floats = problem.weights.regularity * (2.0 * (matrix @ rho) + linear)
    return slope


def phase_quadratic(problem: RegionProblem, u: Floats) -> tuple[sparse.csr_array, Floats, float]:
    """H (n, n) sparse, h (n,) and c of step 2: `rho'H rho + h.rho + c`, paper equation 18.

    Times `regularity` this is the smoothness and boundary term at membership `u`; the factor is
    left out because the minimizer does not depend on it.
    """
    weights = problem.weights
    pull = weights.boundary / (4.0 * weights.phase_width) * problem.vertex_areas / problem.part_area
    diagonal = 0.5 * weights.smoothness * gradient_weight(problem, u) + pull
    matrix = weights.boundary * weights.phase_width * problem.stiffness
    return sparse.csr_array(matrix + sparse.diags_array(diagonal)), -2.0 * pull, float(pull.sum())


def _weighted_stiffness(problem: RegionProblem, face_weights: Floats) -> sparse.csr_array:
    count = problem.vertex_count
    values = problem.corner_weights * face_weights[:, None]
    rows, columns = problem.faces[:, [1, 2, 0]].ravel(), problem.faces[:, [2, 0, 1]].ravel()
    half = sparse.coo_array((values.ravel(), (rows, columns)), shape=(count, count)).tocsr()
    off_diagonal = half + half.T
    degree: Floats = np.asarray(off_diagonal.sum(axis=1)).ravel()
    return sparse.csr_array(sparse.diags_array(degree) - off_diagonal)
