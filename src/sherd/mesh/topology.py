"""Connectivity of triangles as functions on arrays: edges, boundary, components.

`faces` is (m, 3) int64; `count` is the number of vertices.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from sherd.arrays import Ints

__all__ = [
    "adjacency",
    "boundary_edges",
    "component_labels",
    "half_edges",
    "named_vertices",
    "renumbered",
    "unique_edges",
]


def named_vertices(faces: Ints, count: int) -> Ints:
    """The vertices that a face names, ascending; they are marked, which a sort takes longer for."""
    named = np.zeros(count, dtype=bool)
    named[faces] = True
    return np.flatnonzero(named)


def renumbered(faces: Ints) -> tuple[Ints, Ints]:
    """The vertices that faces or edges name, ascending, and these (m, k) in their numbers."""
    count = int(faces.max(initial=-1)) + 1
    used = named_vertices(faces, count)
    number = np.empty(count, dtype=np.int64)
    number[used] = np.arange(len(used))
    return used, number[faces]


def half_edges(faces: Ints) -> Ints:
    """The three directed edges of each face, (3m, 2), face after face."""
    halves: Ints = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    return halves


def unique_edges(faces: Ints) -> tuple[Ints, Ints]:
    """Undirected edges (e, 2) with the lower index first, and the number of faces at each (e,)."""
    halves = np.sort(half_edges(faces), axis=1)
    base = int(faces.max(initial=0)) + 1
    # one whole number for each edge sorts ten times faster than rows do
    keys, uses = np.unique(halves[:, 0] * base + halves[:, 1], return_counts=True)
    edges: Ints = np.stack([keys // base, keys % base], axis=1)
    return edges, uses.astype(np.int64)


def boundary_edges(faces: Ints) -> Ints:
    """Edges with one face only, (b, 2), lower index first."""
    edges, uses = unique_edges(faces)
    border: Ints = edges[uses == 1]
    return border


def adjacency(faces: Ints, count: int) -> sparse.csr_array:
    """Symmetric (n, n) matrix with 1 where an edge joins two vertices."""
    edges, _ = unique_edges(faces)
    rows = np.concatenate([edges[:, 0], edges[:, 1]])
    columns = np.concatenate([edges[:, 1], edges[:, 0]])
    return sparse.csr_array((np.ones(len(rows)), (rows, columns)), shape=(count, count))


def component_labels(faces: Ints, count: int) -> Ints:
    """Component of each vertex, (n,), numbered from 0 by descending number of vertices."""
    _, raw = csgraph.connected_components(adjacency(faces, count), directed=False)
    sizes = np.bincount(raw)
    rank = np.empty(len(sizes), dtype=np.int64)
    rank[np.argsort(-sizes, kind="stable")] = np.arange(len(sizes))
    labels: Ints = rank[raw]
    return labels
