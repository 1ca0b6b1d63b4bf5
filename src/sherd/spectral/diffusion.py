"""Heat flow on a triangle mesh: values averaged over a length, whatever the meshing."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from sherd.arrays import Floats
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.factorization import factorized
from sherd.spectral.operators import stiffness

__all__ = ["diffused"]


def diffused(mesh: TriangleMesh, values: Floats, width: float) -> Floats:
    """Values (n, k) of the vertices after heat flow of standard deviation `width` (mesh length).

    One implicit step `(A + t W) u = A u0` with `t = width^2 / 2`: the amount of smoothing is a
    length, so two meshings of one surface get the same values. Cotangents below zero are raised to
    zero, which keeps every result between the values that it averages.
    """
    weak = stiffness(mesh.vertices, mesh.faces).tocoo()
    off = (weak.row != weak.col) & (weak.data < 0)
    graph = sparse.coo_array(
        (-weak.data[off], (weak.row[off], weak.col[off])), shape=weak.shape
    ).tocsr()
    areas = np.maximum(mesh.vertex_areas, 1e-12 * mesh.area / mesh.vertex_count)
    laplacian = sparse.diags_array(np.asarray(graph.sum(axis=1)).ravel()) - graph
    system = sparse.csc_array(sparse.diags_array(areas) + 0.5 * width**2 * laplacian)
    smooth: Floats = factorized(system).solve(areas[:, None] * values)
    return smooth
