"""Samples: vertices that stand for a surface, how far apart they lie and in which directions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sherd.arrays import Bools, Floats, Ints, Singles, field_state
from sherd.descriptors.tangent_frames import geodesic_directions
from sherd.mesh.surface_points import closest_points
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.geodesics import Geodesics
from sherd.spectral.sampling import farthest_points
from sherd.surface.counted import rounded, steps_of
from sherd.surface.working import WorkingSurface
from sherd.threads import cached_property

__all__ = ["COARSE_COUNT", "Frames", "Samples", "dense_samples", "sparse_samples"]

# The unit tangent axes (s, 3) and normals (s, 3) of vertices (s,).
Frames = Callable[[Ints], tuple[Floats, Floats]]

# Closer than this the gradient of a geodesic distance is unreliable: a few vertex spacings.
NEAR = 0.07
# 1,200 samples lie 0.03 apart, below the smallest radius; 700 were too few to pin directions.
DENSE_COUNT = 1200
# 0.04 apart, twice as far in area: enough to tell whether a part belongs at all. With 400 a part of
# 4 % of the area could not be told any more; with 1,200, and with the vertices around each label
# as well, the first of eleven full shapes was the same for all of 19 parts, at 2.8 times the time.
COARSE_COUNT = 600
# 200 samples of a part of half the area lie 0.05 apart, half the largest neighborhood; 400 were
# no better and four times as dear, 300 gained 0.003 IoU in locating for twice the time.
SPARSE_COUNT = 200


@dataclass(frozen=True, eq=False)
class Samples:
    """Farthest-point samples of a surface; lengths in units of sqrt(area of the full shape).

    Attributes
    ----------
    vertices
        (s,) int.
    distances
        (s, n) float32 geodesic distance from each sample to every vertex, inf if not connected.
    between
        (s, s) symmetric distances between the samples.
    directions
        (s, s) float32 angle in radians at which the geodesic from sample to sample leaves the
        first, in its tangent frame.
    farthest_first
        (s,) int, the samples in the order in which they were chosen: the first few lie farthest
        apart, whatever the order of the others.
    """

    vertices: Ints
    distances: Singles
    between: NDArray[np.floating]
    directions: Singles
    farthest_first: Ints

    def __len__(self) -> int:
        return len(self.vertices)

    def __getstate__(self) -> dict[str, Any]:
        return field_state(self)

    @classmethod
    def of(
        cls,
        vertices: Ints,
        distances: NDArray[np.floating],
        directions: Singles,
        farthest_first: Ints | None = None,
    ) -> Samples:
        """The samples with these distances (s, n) and directions; `between` follows from them."""
        between = distances[:, vertices]
        return cls(
            vertices=vertices,
            distances=distances.astype(np.float32, copy=False),
            between=np.ascontiguousarray(np.minimum(between, between.T)),
            directions=directions,
            farthest_first=np.arange(len(vertices)) if farthest_first is None else farthest_first,
        )

    def thinned(self, count: int) -> Samples:
        """At most `count` of the samples, those that lie farthest apart, in the same order."""
        return self._only(self.farthest_first[:count])

    def within(self, mask: Bools) -> Samples:
        """Those that lie in `mask` (n,), in the same order."""
        inside = mask[self.vertices[self.farthest_first]]
        return self._only(self.farthest_first[inside])

    def _only(self, chosen: Ints) -> Samples:
        kept = np.sort(chosen)
        return Samples(
            vertices=self.vertices[kept],
            distances=self.distances[kept],
            between=self.between[np.ix_(kept, kept)],
            directions=self.directions[np.ix_(kept, kept)],
            farthest_first=np.searchsorted(kept, chosen),
        )

    @cached_property
    def cells(self) -> Ints:
        """(n,) the sample nearest to each vertex."""
        # numpy's own search for the least of each column copies all of them to rows first
        least = self.distances[0].copy()
        nearest = np.zeros(len(least), dtype=np.int64)
        for sample in range(1, len(self)):
            nearer = np.flatnonzero(self.distances[sample] < least)
            least[nearer] = self.distances[sample, nearer]
            nearest[nearer] = sample
        nearest[self.vertices] = np.arange(len(self))
        return nearest

    @cached_property
    def leaving(self) -> NDArray[np.uint16]:
        """(s, s) `directions` in steps; see :func:`sherd.surface.counted.steps_of`."""
        return steps_of(self.directions)

    @cached_property
    def arriving(self) -> NDArray[np.uint16]:
        """(s, s) `leaving` from the second sample to the first."""
        return np.ascontiguousarray(self.leaving.T)


def dense_samples(working: WorkingSurface, frames: Frames, count: int = DENSE_COUNT) -> Samples:
    """At most `count` samples: the places where another surface may lie.

    Split edges add vertices to the working mesh but nothing to its shape: distances are measured
    on the mesh before the split, at a third of the cost, and carried over. Distances and
    directions are rounded to about 1e-4, far below their own error of half a percent, so that a
    file of them is small and read at once.
    """
    mesh = working.mesh
    split = working.placed.vertex_count < mesh.vertex_count
    ruler = working.placed if split else mesh
    # the start is the vertex farthest from the center: it does not depend on numbering
    start = int(np.linalg.norm(ruler.vertices, axis=1).argmax())
    geodesics = Geodesics(ruler)
    vertices = farthest_points(geodesics, min(count, len(ruler.used_vertices)), start=start)
    distances = geodesics.singles_from(vertices)
    if split:
        distances = np.concatenate([distances, _carried(distances, ruler, mesh)], axis=1)
    directions = _directions(mesh, vertices, distances, frames)
    return Samples.of(vertices, rounded(distances), rounded(directions))


def sparse_samples(
    mesh: TriangleMesh, geodesics: Geodesics, depth: Floats, frames: Frames, *, also: Ints
) -> Samples:
    """Samples few enough to be placed together, sorted by distance from the deepest one.

    Parameters
    ----------
    mesh, geodesics
        The surface and distances on it.
    depth
        (n,) distance of each vertex to the cut. The first sample is the vertex deepest inside, so
        that numbering and pose do not matter; message passing sweeps outward from it.
    frames
        Gives tangent frames of vertices.
    also
        (p,) vertices that must be among the samples.
    """
    used = mesh.used_vertices
    start = int(used[depth[used].argmax()])
    count = min(SPARSE_COUNT, len(used))
    vertices = farthest_points(geodesics, count, start=start)
    distances = geodesics.singles_from(vertices)
    added = np.setdiff1d(also, vertices)
    if len(added):
        vertices = np.concatenate([vertices, added])
        distances = np.concatenate([distances, geodesics.singles_from(added)])
    order = np.argsort(distances[0, vertices], kind="stable")
    vertices, distances = vertices[order], distances[order]
    directions = _directions(mesh, vertices, distances, frames)
    return Samples.of(vertices, distances, directions, np.argsort(order, kind="stable"))


def _directions(
    mesh: TriangleMesh, vertices: Ints, distances: NDArray[np.floating], frames: Frames
) -> Singles:
    x_axes, z_axes = frames(vertices)
    return geodesic_directions(mesh, vertices, distances, x_axes=x_axes, z_axes=z_axes, near=NEAR)


def _carried(distances: Singles, ruler: TriangleMesh, mesh: TriangleMesh) -> Singles:
    """Distances (s, n) on `ruler` at the vertices that `mesh` has in addition."""
    added = closest_points(ruler, mesh.vertices[ruler.vertex_count :])
    corners, weights = ruler.faces[added.faces], added.barycentric.astype(np.float32)
    # a corner of weight 0 may lie on another component, infinitely far
    carried: Singles = np.zeros((len(distances), len(corners)), dtype=np.float32)
    for k in range(3):
        carried += np.where(weights[:, k] > 0, distances[:, corners[:, k]], 0.0) * weights[:, k]
    return carried
