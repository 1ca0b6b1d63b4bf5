"""The region of a known map: what the image of the part covers, smoothed and cut to its area."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import cg
from scipy.spatial import cKDTree

from sherd.arrays import Bools, Floats
from sherd.energy.cleanup import raised_to_area, threshold_to_area
from sherd.mesh.topology import named_vertices
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.operators import stiffness
from sherd.threads import search_threads

__all__ = ["covered_region", "smoothed"]


# Smoothing length in sqrt(area of the full shape): the vertex spacing of a 10,000-vertex mesh. It
# closes the gaps that single vertices leave and rounds nothing that such a mesh can show.
WIDTH = 0.01
# Lengths of decay, width / sqrt(2), after which the border of the mask is felt by 1e-5 only.
BAND = 12.0


def covered_region(full: TriangleMesh, covered: Bools, area: float) -> tuple[Floats, Bools]:
    """Membership (n,) in [0, 1] and mask (n,) bool of the area of the part.

    `min over u of integral (u - c)^2 + t integral |grad u|^2` with the coverage c as data: the
    membership step of the paper at rho = 1 on all vertices. Where many places compete, a region
    must be drawn from votes with few eigenvectors; here the map has decided, and a basis would only
    round small holes away.

    Parameters
    ----------
    full
        The full shape; area 1.
    covered
        (n,) bool, vertices of whose area the image of the part covers at least half.
    area
        What the region shall have: that of the covered vertices, less what is unmatched.

    Notes
    -----
    One solve by conjugate gradients, near linear in n.
    """
    smooth = smoothed(full, covered)
    wanted = min(area, full.area)
    areas = full.vertex_areas
    # no cleaning: small holes and pieces are real here, the part may have them
    return raised_to_area(smooth, areas, wanted), threshold_to_area(smooth, areas, wanted)


def smoothed(mesh: TriangleMesh, covered: Bools) -> Floats:
    """Membership (n,) in [0, 1] near the mask (n,), for a mesh of area near 1.

    `min over u of integral (u - c)^2 + t integral |grad u|^2`, t the square of the width. Away from
    the border of the mask u is c, up to `exp(-BAND)`, so there nothing is solved.
    """
    smooth = covered.astype(np.float64)
    near = _near_border(mesh, covered)
    if not near.any():
        return smooth
    band, vertices = mesh.submesh(near[mesh.faces].any(axis=1))
    # vertices without area are tied to nothing; a trace of mass keeps the system definite
    mass = np.maximum(mesh.vertex_areas[vertices], 1e-12 * mesh.area / mesh.vertex_count)
    weak = stiffness(band.vertices, band.faces)
    system = sparse.csr_array(sparse.diags_array(mass) + 0.5 * WIDTH**2 * weak)
    scale = sparse.diags_array(1.0 / system.diagonal())
    coverage = smooth[vertices]
    found, _ = cg(system, mass * coverage, x0=coverage, rtol=1e-6, maxiter=500, M=scale)
    smooth[vertices] = np.clip(found, 0.0, 1.0)
    return smooth


def _near_border(mesh: TriangleMesh, covered: Bools) -> Bools:
    """The vertices (n,) within `BAND` lengths of decay of an edge on which the mask changes."""
    mixed = covered[mesh.faces].any(axis=1) & ~covered[mesh.faces].all(axis=1)
    if not mixed.any():
        return np.zeros(mesh.vertex_count, dtype=bool)
    tree = cKDTree(mesh.vertices[named_vertices(mesh.faces[mixed], mesh.vertex_count)])
    reach = BAND * WIDTH / np.sqrt(2)
    # through space it is nearer than along the surface, so nobody is left out
    workers = search_threads(mesh.vertex_count)
    distance = tree.query(mesh.vertices, distance_upper_bound=reach, workers=workers)[0]
    near: Bools = np.isfinite(distance)
    return near
