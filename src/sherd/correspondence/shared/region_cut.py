"""The shared region: the vertices worth their price, with a short boundary; a minimum cut.

    E(u) = integral u (cost - 1) + width * length of the boundary of {u = 1},   u in {0, 1}

is the Mumford-Shah energy of the founding paper for memberships that jump between 0 and 1, with
the area constraint replaced by a price: where `cost` is below 1 the surface is shared. Bronstein,
Bronstein, Bruckstein, Kimmel, *Partial similarity of objects*, 2009, relax it to a phase field;
between two values it is a minimum cut, which has no local minima (Boykov, Veksler, Zabih, *Fast
approximate energy minimization via graph cuts*, 2001, section 3).
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from sherd.arrays import Bools, Floats
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.operators import stiffness

__all__ = ["WIDTH", "shared_region"]

# Half the smallest neighborhood that is compared: what is narrower than twice that, and no better
# than its price, goes with its surroundings.
WIDTH = 0.02
# Capacities are whole numbers: a millionth of the largest sum is exact enough.
UNITS = 1_000_000_000


def shared_region(mesh: TriangleMesh, cost: Floats, *, width: float = WIDTH) -> Bools:
    """The region (n,) of least energy; `cost` (n,) is 1 where a vertex is just worth its price."""
    gain = mesh.vertex_areas * (1.0 - cost)
    first, second = mesh.edges.T
    weak = -np.asarray(stiffness(mesh.vertices, mesh.faces).tocsr()[first, second]).ravel()
    length = np.linalg.norm(mesh.vertices[first] - mesh.vertices[second], axis=1)
    # an edge of the cut's dual is as long as the edge times its cotangent weight
    seam = width * length * np.maximum(weak, 0.0)
    count = mesh.vertex_count
    source, sink = count, count + 1
    unit = UNITS / max(np.abs(gain).sum(), seam.sum(), 1e-300)
    wanted, unwanted = np.flatnonzero(gain > 0), np.flatnonzero(gain < 0)
    rows = np.concatenate([np.full(len(wanted), source), unwanted, first, second])
    columns = np.concatenate([wanted, np.full(len(unwanted), sink), second, first])
    values = np.concatenate([gain[wanted], -gain[unwanted], seam, seam])
    capacity = np.ceil(unit * values).astype(np.int32)
    graph = sparse.csr_array((capacity, (rows, columns)), shape=(count + 2, count + 2))
    left = graph - csgraph.maximum_flow(graph, source, sink).flow
    left.data = np.maximum(left.data, 0)
    left.eliminate_zeros()
    reached = csgraph.breadth_first_order(left, source, return_predecessors=False)
    inside = np.zeros(count + 2, dtype=bool)
    inside[reached] = True
    return inside[:count]
