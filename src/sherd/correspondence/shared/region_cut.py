"""The shared region: the vertices worth their price, with a short boundary; a minimum cut.

    E(u) = integral u (cost - 1) + width * length of the boundary of {u = 1},   u in {0, 1}

(four times its length where the other shape goes on)

is the Mumford-Shah energy of the founding paper for memberships that jump between 0 and 1, with
the area constraint replaced by a price: where `cost` is below 1 the surface is shared. Bronstein,
Bronstein, Bruckstein, Kimmel, *Partial similarity of objects*, 2009, relax it to a phase field;
between two values it is a minimum cut, which has no local minima (Boykov, Veksler, Zabih, *Fast
approximate energy minimization via graph cuts*, 2001, section 3).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sherd.arrays import Bools, Floats
from sherd.mesh.gluing import components
from sherd.mesh.minimum_cut import minimum_cut
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.operators import stiffness

__all__ = [
    "INSIDE",
    "WIDTH",
    "mutual_components",
    "seam_lengths",
    "shared_region",
    "shared_regions",
]

# Half the smallest neighborhood that is compared: what is narrower than twice that, and no better
# than its price, goes with its surroundings.
WIDTH = 0.02
# As an edge of the labeling from inside the other shape to nowhere: it says "wrong", and that costs
# at most four times what one sigma does.
INSIDE = 4.0
# Of a component that both shapes mean most lies where the other one has what is shared.
MOST = 0.5


def shared_regions(mesh: TriangleMesh, costs: Sequence[Floats], goes_on: Bools) -> list[Bools]:
    """The region (n,) of least energy for each of `costs` (n,), which are 1 at the price.

    Both shapes are cut from something whole, so what they share ends where either ends. Where the
    other shape goes on, at the vertices `goes_on` (n,), a border costs `INSIDE` times its length.
    """
    first, second = mesh.edges.T
    dear = np.where(goes_on[first] & goes_on[second], INSIDE, 1.0)
    price = WIDTH * dear * seam_lengths(mesh)
    areas = mesh.vertex_areas
    return [~minimum_cut(areas * (1.0 - cost), (first, second), price) for cost in costs]


def shared_region(mesh: TriangleMesh, cost: Floats, goes_on: Bools) -> Bools:
    """:func:`shared_regions` of one cost."""
    return shared_regions(mesh, [cost], goes_on)[0]


def mutual_components(mesh: TriangleMesh, shared: Bools, mutual: Floats) -> Bools:
    """What is shared (n,) without components most of which the other shape does not share.

    `mutual` (n,) is in [0, 1], how much of what lies around the place of a vertex is shared.
    """
    first, second = mesh.edges[shared[mesh.edges].all(axis=1)].T
    labels = components(first, second, mesh.vertex_count)
    meant = np.bincount(labels, mesh.vertex_areas * shared * (mutual - MOST))
    kept: Bools = shared & (meant[labels] > 0.0)
    return kept


def seam_lengths(mesh: TriangleMesh) -> Floats:
    """(e,) length of border that crosses each edge: of the edge's dual, l."""
    first, second = mesh.edges.T
    weak = -np.asarray(stiffness(mesh.vertices, mesh.faces).tocsr()[first, second]).ravel()
    length = np.linalg.norm(mesh.vertices[first] - mesh.vertices[second], axis=1)
    # the dual is as long as the edge times its cotangent weight
    result: Floats = length * np.maximum(weak, 0.0)
    return result
