"""Heat flow on a triangle mesh: values averaged over a length, whatever the meshing."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from sherd.arrays import Floats
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.operators import factorized, positive_stiffness

__all__ = ["diffused"]


def diffused(mesh: TriangleMesh, values: Floats, width: float) -> Floats:
    """Values (n, k) of the vertices after heat flow of standard deviation `width` (mesh length).

    One implicit step `(A + t W) u = A u0` with `t = width^2 / 2`: the amount of smoothing is a
    length, so two meshings of one surface get the same values. Cotangents below zero are raised to
    zero, which keeps every result between the values that it averages.
    """
    areas = np.maximum(mesh.vertex_areas, 1e-12 * mesh.area / mesh.vertex_count)
    laplacian = positive_stiffness(mesh.vertices, mesh.faces)
    system = sparse.csc_array(sparse.diags_array(areas) + 0.5 * width**2 * laplacian)
    smooth: Floats = factorized(system).solve(areas[:, None] * values)
    return smooth
