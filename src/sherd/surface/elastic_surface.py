"""ElasticSurface: the part's edges and how firmly each keeps its length and direction."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from sherd.arrays import Floats, Ints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.operators import stiffness

__all__ = ["ElasticSurface", "elastic_surface"]


# Cotangent weights; an equilateral triangle has 0.58, slivers have anything.
LEAST, MOST = 0.05, 5.0
# Missing skin is followed across gaps as wide as the largest neighborhood, not farther.
WIDEST_GAP = 0.1
# Along an even border so many vertices reach as far as the widest gap.
BORDER_NEIGHBORS = 32


class ElasticSurface(NamedTuple):
    """Edges by vertex, both ways; a named tuple, which compiled kernels take as it is.

    Attributes
    ----------
    pointers, neighbors, weights
        The edges of vertex i lead to `neighbors[pointers[i]:pointers[i + 1]]`, with those weights.
    rest
        (n, 3) positions without strain.
    """

    pointers: Ints
    neighbors: Ints
    weights: Floats
    rest: Floats


def elastic_surface(mesh: TriangleMesh) -> ElasticSurface:
    """The mesh's edges with cotangent weights, and springs across gaps between its components.

    Components keep their places in the scan, so the skin that is missing between two borders ties
    them: a strip of width g along a border with vertex spacing s is as stiff as edges with
    weight s / g.
    """
    matrix = stiffness(mesh.vertices, mesh.faces).tocsr()
    first, second = mesh.edges.T  # also the diagonals of squares, whose weight is 0
    weights = np.clip(-np.asarray(matrix[first, second]).ravel(), LEAST, MOST)
    weak = sparse.csr_array((weights, (first, second)), shape=matrix.shape)
    weak = (weak + weak.T).tocsr()
    if mesh.component_count > 1:
        weak = (weak + _across_gaps(mesh)).tocsr()
    return ElasticSurface(
        weak.indptr.astype(np.int64), weak.indices.astype(np.int64), weak.data, mesh.vertices
    )


def _across_gaps(mesh: TriangleMesh) -> sparse.csr_array:
    """Weights (n, n) between each border vertex and the nearest one of another component."""
    count = mesh.vertex_count
    border, labels = mesh.boundary_vertices, mesh.component_labels
    if len(border) < 2:
        return sparse.csr_array((count, count))
    places = mesh.vertices[border]
    tree: Any = cKDTree(places)
    length, near = tree.query(
        places, k=min(BORDER_NEIGHBORS, len(border)), distance_upper_bound=WIDEST_GAP
    )
    other = labels[np.append(border, border[0])[near]] != labels[border][:, None]
    other &= np.isfinite(length)
    first, found = other.argmax(axis=1), np.flatnonzero(other.any(axis=1))
    gap = length[found, first[found]]
    ends = border[found], border[near[found, first[found]]]
    spacing = np.sqrt(mesh.area / len(mesh.used_vertices))
    weights = np.minimum(spacing / np.maximum(gap, 1e-12), 1.0)
    springs = sparse.csr_array((weights, ends), shape=(count, count))
    return springs.maximum(springs.T).tocsr()
