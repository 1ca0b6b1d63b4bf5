"""RegionProblem: which region of the full shape has this area and descriptor integral."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from sherd.arrays import Floats, Ints, frozen
from sherd.errors import InfeasibleError, InputError, OptionError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.operators import corner_cotangents, gradient, stiffness
from sherd.threads import cached_property

__all__ = ["EdgeOperators", "EnergyWeights", "RegionProblem", "region_problem"]


# A part may exceed the full shape by discretization and pose alone; beyond this it cannot fit.
LARGEST_AREA_RATIO = 1.05


@dataclass(frozen=True)
class EnergyWeights:
    """The paper's parameters, dimensionless; :mod:`sherd.energy.mumford_shah` states the energy.

    Attributes
    ----------
    regularity
        lambda_r > 0 or 0, of both regularity terms against the relative data term. A residual of
        10 % of |q| costs 0.01 in the data term, as does a cut of length sqrt(s) at 0.01.
    smoothness
        lambda_s >= 0, cost of a gradient of u where rho = 1.
    boundary
        lambda_b > 0, cost of the boundary length in units of sqrt(s).
    phase_width
        epsilon > 0 in units of sqrt(s), half the width over which rho recovers from 0 to 1. It
        cannot be finer than the basis resolves, about pi / sqrt(lambda_k).

    Raises
    ------
    OptionError
        If a weight is not finite or out of range.
    """

    regularity: float = 0.01
    smoothness: float = 1.0
    boundary: float = 1.0
    phase_width: float = 0.2

    def __post_init__(self) -> None:
        for name in ("regularity", "smoothness"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0):
                raise OptionError(f"{name} is {value}, but a finite number >= 0 is needed")
        for name in ("boundary", "phase_width"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise OptionError(f"{name} is {value}, but a finite number > 0 is needed")


@dataclass(frozen=True, eq=False)
class EdgeOperators:
    """The integral of `rho^2 |grad u|^2` written over edges: `sum_e w_e (u_i - u_j)^2`.

    Attributes
    ----------
    difference
        (e, n) sparse, `u_i - u_j` of each edge.
    spread
        M (e, n) sparse, `w = M rho^2`.
    difference_transposed, spread_transposed
        By rows, so that products need no search.
    """

    difference: sparse.csr_array
    spread: sparse.csr_array
    difference_transposed: sparse.csr_array
    spread_transposed: sparse.csr_array

    def of_type(self, dtype: Any) -> EdgeOperators:
        """The same in float32 or float64."""
        return EdgeOperators(
            *(getattr(self, each.name).astype(dtype, copy=False) for each in fields(self))
        )


@dataclass(frozen=True, eq=False)
class RegionProblem:
    """One question: which region has this area and this descriptor integral.

    Made by :func:`region_problem`. Nothing here is dense n x n.

    Attributes
    ----------
    faces
        (m, 3) int.
    face_areas
        (m,) l^2.
    vertex_areas
        (n,) l^2, a in the paper, barycentric.
    gradient
        G, (3m, n) sparse, 1/l.
    stiffness
        W, (n, n) sparse, equal to K(1).
    descriptors
        P over |q|, (n, d).
    part_integral
        q over |q|, (d,), so of length 1.
    part_area
        s, l^2, the integral that u must have.
    weights
        The energy's weights.
    evidence
        (n,) gain per unit of membership at each vertex, dimensionless; zeros without any.
    corner_weights
        (m, 3), half the cotangent at each corner, 1: the entries of K(rho).
    edges
        The same by edges, for many memberships at once.
    """

    faces: Ints
    face_areas: Floats
    vertex_areas: Floats
    gradient: sparse.csr_array
    stiffness: sparse.csr_array
    descriptors: Floats
    part_integral: Floats
    part_area: float
    weights: EnergyWeights
    evidence: Floats
    corner_weights: Floats = field(repr=False)
    edges: EdgeOperators = field(repr=False)

    @property
    def vertex_count(self) -> int:
        """Number of vertices, n."""
        return len(self.vertex_areas)

    @property
    def area(self) -> float:
        """Area of the full shape, l^2."""
        return float(self.vertex_areas.sum())

    @cached_property
    def weighted_descriptors(self) -> Floats:
        """A P over |q|, (n, d) l^2: its transpose times u is the integral of the descriptors."""
        return self.vertex_areas[:, None] * self.descriptors

    @cached_property
    def data_linear(self) -> Floats:
        """A P q / |q|^2, (n,): `data_term = |P'Au|^2 - 2 data_linear . u + 1`."""
        linear: Floats = self.weighted_descriptors @ self.part_integral
        return linear

    @cached_property
    def weighted_evidence(self) -> Floats:
        """A evidence over s, (n,): times u it is what the evidence takes off the energy."""
        return self.vertex_areas * self.evidence / self.part_area

    def with_weights(self, weights: EnergyWeights) -> RegionProblem:
        """The same question under other weights; shares every array."""
        return replace(self, weights=weights)

    def with_descriptors(self, descriptors: ArrayLike, part_integral: ArrayLike) -> RegionProblem:
        """The same question by other descriptors (n, d) and their integral (d,)."""
        values, integral = _checked_descriptors(descriptors, part_integral, self.vertex_count)
        return replace(self, descriptors=values, part_integral=integral)

    def with_evidence(self, evidence: ArrayLike) -> RegionProblem:
        """The same question with another evidence (n,); shares every other array."""
        checked = _checked_evidence(evidence, self.vertex_count)
        return replace(self, evidence=checked)


def region_problem(
    full: TriangleMesh,
    *,
    full_descriptors: ArrayLike,
    part_integral: ArrayLike,
    part_area: float,
    weights: EnergyWeights | None = None,
    evidence: ArrayLike | None = None,
) -> RegionProblem:
    """The problem of finding a region of `full` with this area and descriptor integral.

    Parameters
    ----------
    full
        Full shape, n vertices.
    full_descriptors
        (n, d) float, P, in any unit; finite.
    part_integral
        (d,) float, q: the descriptors of the part integrated over it, in that unit times l^2.
    part_area
        s, l^2, the area the integral was taken over.
    weights
        Weights of the energy; the defaults of :class:`EnergyWeights` if None.
    evidence
        (n,) float, gain per unit of membership at each vertex, dimensionless; none if None.

    Raises
    ------
    InputError
        If an array has the wrong shape or a value that is not finite, or the integral is zero.
    InfeasibleError
        If `part_area` is not positive, or above 1.05 times the area of the full shape. Between
        1 and 1.05 times it is lowered to the area of the full shape.
    """
    count = full.vertex_count
    descriptors, integral = _checked_descriptors(full_descriptors, part_integral, count)
    corner_weights = frozen(0.5 * corner_cotangents(full.vertices, full.faces))
    return RegionProblem(
        faces=full.faces,
        face_areas=full.face_areas,
        vertex_areas=full.vertex_areas,
        gradient=gradient(full.vertices, full.faces),
        stiffness=stiffness(full.vertices, full.faces),
        descriptors=descriptors,
        part_integral=integral,
        part_area=_checked_area(part_area, full.area),
        weights=weights or EnergyWeights(),
        evidence=_checked_evidence(np.zeros(count) if evidence is None else evidence, count),
        corner_weights=corner_weights,
        edges=_edge_operators(full.faces, corner_weights, count),
    )


def _edge_operators(faces: Ints, corner_weights: Floats, count: int) -> EdgeOperators:
    first, second = faces[:, [1, 2, 0]].ravel(), faces[:, [2, 0, 1]].ravel()
    keys = np.minimum(first, second) * count + np.maximum(first, second)
    unique, edge_of = np.unique(keys, return_inverse=True)
    rows = np.repeat(np.arange(len(unique)), 2)
    ends = np.stack([unique // count, unique % count], axis=1).ravel()
    signs = np.tile([1.0, -1.0], len(unique))
    shape = (len(unique), count)
    difference = sparse.csr_array(sparse.coo_array((signs, (rows, ends)), shape=shape))
    thirds = np.repeat(corner_weights.ravel() / 3.0, 3)
    corners = np.repeat(faces, 3, axis=0).ravel()  # every corner of the face feeds its three edges
    places = (np.repeat(edge_of, 3), corners)
    spread = sparse.csr_array(sparse.coo_array((thirds, places), shape=shape))
    transposed = (sparse.csr_array(each.T) for each in (difference, spread))
    return EdgeOperators(difference, spread, *transposed)


def _checked_area(part_area: float, full_area: float) -> float:
    area = float(part_area)
    if not (math.isfinite(area) and area > 0):
        raise InfeasibleError(f"part_area is {area}, but a positive area is needed")
    if area > LARGEST_AREA_RATIO * full_area:
        raise InfeasibleError(
            f"the part has {area / full_area:.3f} times the area of the full shape; a part is at "
            f"most {LARGEST_AREA_RATIO} times as large. Are the two swapped, or in other units?"
        )
    return min(area, full_area)


def _checked_descriptors(
    full_descriptors: ArrayLike, part_integral: ArrayLike, count: int
) -> tuple[Floats, Floats]:
    """Both divided by the length of the integral."""
    descriptors = np.asarray(full_descriptors, dtype=np.float64)
    integral = np.asarray(part_integral, dtype=np.float64)
    if descriptors.ndim != 2 or len(descriptors) != count:
        raise InputError(f"full_descriptors has shape {descriptors.shape}, not ({count}, d)")
    if integral.shape != descriptors.shape[1:]:
        raise InputError(
            f"part_integral has shape {integral.shape}, but {descriptors.shape[1:]} is needed"
        )
    if not (np.isfinite(descriptors).all() and np.isfinite(integral).all()):
        raise InputError("descriptors hold NaN or infinite values; leave those vertices out")
    norm = float(np.linalg.norm(integral))
    if norm == 0:
        raise InputError("part_integral is zero, so the part has no descriptor to be found by")
    return frozen(descriptors / norm), frozen(integral / norm)


def _checked_evidence(evidence: ArrayLike, count: int) -> Floats:
    values = np.asarray(evidence, dtype=np.float64)
    if values.shape != (count,) or not np.isfinite(values).all():
        raise InputError(f"evidence has shape {values.shape}; ({count},) finite values are needed")
    return frozen(values)
