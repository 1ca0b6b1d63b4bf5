"""Optical flow on a surface: the smooth field along it that turns one picture into another.

A picture is a value at each vertex, what is seen of the skin there. A surface that lies beside its
place on another one moves along it until its own picture lies on the other one's.

References
----------
Horn, Schunck, *Determining optical flow*, 1981.
Brox, Bruhn, Papenberg, Weickert, *High accuracy optical flow estimation based on a theory for
warping*, 2004: from coarse to fine, each step from where the last one led.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.sparse import bsr_array, csr_array, eye_array, kron
from scipy.sparse.linalg import cg

from sherd.arrays import Bools, Floats
from sherd.mesh.geometry import lengths
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.operators import gradient, stiffness

__all__ = ["Sight", "flow_field", "ranks", "slopes"]

# Ranks differ by a third where nothing agrees; beyond this a difference counts less and less.
DOUBT = 0.3
# Where nothing is seen the field is held by so little of what slopes hold it by elsewhere.
LEAST_HOLD = 1e-3
CG_TOLERANCE, CG_LIMIT = 1e-3, 200


@dataclass(frozen=True, eq=False)
class Sight:
    """How one picture differs from another where a surface lies now.

    Attributes
    ----------
    unlike
        (n,) the own picture less the other one's there, as of :func:`ranks`.
    slopes
        (n, 3) gradients of the other picture there.
    """

    unlike: Floats
    slopes: Floats


def ranks(values: Floats, among: Bools) -> Floats:
    """Values (n,) as ranks among those of a mask (n,), from -1/2 to 1/2.

    A nose or a hoof has more relief than all the rest, and what two meshings have of it differs.
    """
    order = np.sort(values[among])
    found: Floats = (np.searchsorted(order, values) + 0.5) / (len(order) + 1) - 0.5
    return found


def slopes(mesh: TriangleMesh, values: Floats) -> Floats:
    """Gradient (n, 3) of values (n,) at vertices: the mean of those on faces, by area."""
    steps = (gradient(mesh.vertices, mesh.faces) @ values).reshape(-1, 3)
    weighed = np.repeat(steps * mesh.face_areas[:, None], 3, axis=0)
    total = [
        np.bincount(mesh.faces.ravel(), axis, minlength=mesh.vertex_count) for axis in weighed.T
    ]
    found: Floats = np.stack(total, axis=1) / np.maximum(3 * mesh.vertex_areas, 1e-15)[:, None]
    return found


def flow_field(
    mesh: TriangleMesh,
    laid: Floats,
    trust: Floats,
    still: Floats,
    sights: Sequence[Sight],
    up: Floats,
    before: Floats,
    length: float,
) -> Floats:
    """The smooth field (n, 3) along the other surface that explains best how pictures differ.

    Minimizes, with slopes g along the surface, their mean square s over all that is trusted, and w
    the trust where pictures differ little, both sums also over the pictures,

        sum w (unlike - g (u - before))^2
        + s sum laid (up u)^2 + s sum still |u|^2 + s length^2 integral |grad u|^2

    Parameters
    ----------
    mesh
        The surface that moves, in its own shape.
    laid, trust, still
        (n,) area of what lies on the other surface, of what sees its picture, and of what would
        rather stay where it is.
    sights
        One for each picture, after the field `before`.
    up
        (n, 3) normals of the other surface there.
    before
        (n, 3) what the last step found.
    length
        What is seen says more than that the field is smooth about what is wider than this.
    """
    up = up / np.maximum(lengths(up), 1e-12)[:, None]
    hold, pull = np.zeros((len(up), 3, 3)), np.zeros_like(up)
    steep = 0.0
    for sight in sights:
        along = sight.slopes - np.einsum("ni,ni->n", sight.slopes, up)[:, None] * up
        steep += float(trust @ (along**2).sum(axis=1) / max(trust.sum(), 1e-12))
        weights = trust / (1 + (sight.unlike / DOUBT) ** 2)
        hold += weights[:, None, None] * along[:, :, None] * along[:, None, :]
        pull += (weights * (sight.unlike + np.einsum("ni,ni->n", along, before)))[:, None] * along
    # a surface without slopes says nothing, and is still solved
    steep = max(steep, 1e-9)
    hold += (steep * laid)[:, None, None] * up[:, :, None] * up[:, None, :]
    kept = np.maximum(still, LEAST_HOLD * mesh.area / mesh.vertex_count)
    hold += (steep * kept)[:, None, None] * np.eye(3)
    stiff = steep * length**2 * _stiffness_of_fields(mesh)
    blocks = hold + stiff.diagonal().reshape(-1, 3)[:, :, None] * np.eye(3)
    found, _ = cg(
        _block_diagonal(hold).tocsr() + stiff,
        pull.ravel(),
        x0=before.ravel(),
        rtol=CG_TOLERANCE,
        maxiter=CG_LIMIT,
        # conditioned by the blocks on the diagonal
        M=_block_diagonal(np.linalg.inv(blocks).astype(np.float64, copy=False)),
    )
    field: Floats = found.reshape(-1, 3)
    return field


# a surface slides in many steps
@lru_cache(maxsize=4)
def _stiffness_of_fields(mesh: TriangleMesh) -> csr_array:
    """The stiffness (3n, 3n) of x, y and z of each vertex in turn."""
    return kron(stiffness(mesh.vertices, mesh.faces), eye_array(3), "csr")


def _block_diagonal(blocks: Floats) -> bsr_array:
    """The matrix (3n, 3n) with blocks (n, 3, 3) on its diagonal."""
    places = np.arange(len(blocks) + 1)
    return bsr_array((blocks, places[:-1], places), shape=(3 * len(blocks), 3 * len(blocks)))
