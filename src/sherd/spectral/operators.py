"""Discrete differential operators of a triangle mesh, and their factorization.

Sign and scaling are fixed once: the stiffness W is weak (no division by area), positive
semidefinite, its rows sum to zero, and `u' W u` is the Dirichlet energy of u.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import SuperLU, splu

from sherd.arrays import Floats, Ints
from sherd.mesh.geometry import edge_lengths, face_areas, face_cross

__all__ = [
    "MOST_BY_DEGREE",
    "corner_cotangents",
    "factorized",
    "gradient",
    "graph_laplacian",
    "positive_stiffness",
    "stiffness",
    "voronoi_vertex_areas",
]

# Minimum degree on the pattern of A' + A has two thirds of the fill of COLAMD on triangle meshes.
# But in SuperLU it does not come back for meshes of 160,000 vertices and more (SciPy 1.17; it takes
# a second for 150,000), so well before that the other one orders.
MOST_BY_DEGREE = 100_000


def corner_cotangents(vertices: Floats, faces: Ints) -> Floats:
    """Cotangent of the angle at each corner, (m, 3); 0 on faces without area.

    `cot = (b^2 + c^2 - a^2) / (4 area)` with a the edge opposite the corner.
    """
    squared = edge_lengths(vertices, faces) ** 2
    total = squared.sum(axis=1, keepdims=True)
    quadruple = 4.0 * face_areas(vertices, faces)[:, None]
    cotangents: Floats = np.divide(
        total - 2.0 * squared, quadruple, out=np.zeros_like(squared), where=quadruple > 0
    )
    return cotangents


def stiffness(vertices: Floats, faces: Ints) -> sparse.csr_array:
    """Cotangent stiffness W, (n, n): `W_ij = -(cot alpha_ij + cot beta_ij) / 2`.

    Equals `gradient' * diag(face areas) * gradient`. Faces without area contribute nothing.

    References
    ----------
    Meyer, Desbrun, Schroeder, Barr, *Discrete differential-geometry operators for triangulated
    2-manifolds*, 2003, equation 8, before the division by area.
    """
    count = len(vertices)
    weights = 0.5 * corner_cotangents(vertices, faces)
    rows, columns = faces[:, [1, 2, 0]].ravel(), faces[:, [2, 0, 1]].ravel()
    half = sparse.coo_array((weights.ravel(), (rows, columns)), shape=(count, count)).tocsr()
    return graph_laplacian(half + half.T)


def graph_laplacian(weights: sparse.csr_array) -> sparse.csr_array:
    """Matrix (n, n) of `sum w_ij |x_i - x_j|^2`, each edge once, of symmetric weights (n, n)."""
    degree: sparse.dia_array = sparse.diags_array(np.asarray(weights.sum(axis=1)).ravel())
    return sparse.csr_array(degree - weights)


def positive_stiffness(vertices: Floats, faces: Ints, *, most: float = np.inf) -> sparse.csr_array:
    """Stiffness (n, n) without weights below zero, so that flow along it never overshoots.

    Parameters
    ----------
    vertices, faces
        Of the mesh.
    most
        Largest weight of an edge; edges of slivers have millions.
    """
    weak = stiffness(vertices, faces).tocoo()
    off = (weak.row != weak.col) & (weak.data < 0)
    weights = np.minimum(-weak.data[off], most)
    graph = sparse.coo_array((weights, (weak.row[off], weak.col[off])), shape=weak.shape)
    return graph_laplacian(graph.tocsr())


def voronoi_vertex_areas(vertices: Floats, faces: Ints) -> Floats:
    """Mixed Voronoi area of each vertex, (n,) l^2; sums to the total area.

    Obtuse faces give half their area to the obtuse corner and a quarter to each other.

    References
    ----------
    Meyer et al. 2003, section 3.3 and figure 4.
    """
    cotangents = corner_cotangents(vertices, faces)
    squared = edge_lengths(vertices, faces) ** 2
    areas = face_areas(vertices, faces)[:, None]
    # the edges at corner i are opposite the other two corners j, k
    voronoi = (np.roll(squared * cotangents, 1, 1) + np.roll(squared * cotangents, -1, 1)) / 8.0
    obtuse = cotangents < 0
    split = np.where(obtuse, areas / 2.0, areas / 4.0)
    share: Floats = np.where(obtuse.any(axis=1, keepdims=True), split, voronoi)
    gathered: Floats = np.bincount(faces.ravel(), share.ravel(), minlength=len(vertices)).astype(
        float
    )
    return gathered


def gradient(vertices: Floats, faces: Ints) -> sparse.csr_array:
    """Gradient G of the linear interpolant on each face, (3m, n), unit 1/l.

    Rows 3f, 3f + 1, 3f + 2 are the components on face f; zero on faces without area.
    `grad u = sum_i u_i (normal x edge_i) / (2 area)`, edge_i opposite corner i, counterclockwise.

    References
    ----------
    Botsch et al., *Polygon Mesh Processing*, 2010, equation 3.9.
    """
    count = len(faces)
    cross = face_cross(vertices, faces)
    squared = np.einsum("mc,mc->m", cross, cross)[:, None]  # (2 area)^2
    rows, columns, values = [], [], []
    for corner in range(3):
        edge = vertices[faces[:, (corner + 2) % 3]] - vertices[faces[:, (corner + 1) % 3]]
        slope = np.cross(cross, edge)
        slope = np.divide(slope, squared, out=np.zeros_like(slope), where=squared > 0)
        rows.append(np.arange(3 * count))
        columns.append(np.repeat(faces[:, corner], 3))
        values.append(slope.ravel())
    return sparse.coo_array(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
        shape=(3 * count, len(vertices)),
    ).tocsr()


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
