"""Samples: vertices that stand for a surface, how far apart they lie and in which directions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sherd.arrays import Bools, Floats, Ints, Singles, field_state
from sherd.descriptors.tangent_frames import Compass
from sherd.mesh.surface_points import SurfacePoints, closest_points
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.geodesics import Geodesics
from sherd.spectral.sampling import farthest_points
from sherd.surface.counted import round_to_counts, steps_of
from sherd.surface.working import WorkingSurface
from sherd.threads import cached_property

__all__ = [
    "COARSE_COUNT", "CoarseLabels", "Frames", "Labels", "Samples", "coarse_labels",
    "dense_samples", "sparse_samples",
]  # fmt: skip

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
# Distances from so many of them are kept at a time, 3 MB; from all 25, a twelfth of all memory.
AT_ONCE = 64
# 200 samples of a part of half the area lie 0.05 apart, half the largest neighborhood; 400 were
# no better and four times as dear, 300 gained 0.003 IoU in locating for twice the time.
SPARSE_COUNT = 200


@dataclass(frozen=True, eq=False)
class Labels:
    """Vertices that stand for a surface; lengths in units of sqrt(area of the full shape).

    Attributes
    ----------
    vertices
        (s,) int.
    between
        (s, s) symmetric geodesic distances between them, inf if not connected.
    directions
        (s, s) float32 angle in radians at which the geodesic from one to another leaves the
        first, in its tangent frame.
    """

    vertices: Ints
    between: NDArray[np.floating]
    directions: Singles

    def __len__(self) -> int:
        return len(self.vertices)

    def __getstate__(self) -> dict[str, Any]:
        return field_state(self)

    @cached_property
    def leaving(self) -> NDArray[np.uint16]:
        """(s, s) `directions` in steps; see :func:`sherd.surface.counted.steps_of`."""
        return steps_of(self.directions)

    @cached_property
    def arriving(self) -> NDArray[np.uint16]:
        """(s, s) `leaving` from the second to the first."""
        return np.ascontiguousarray(self.leaving.T)


@dataclass(frozen=True, eq=False)
class CoarseLabels(Labels):
    """Labels where only likeness is asked for; a quarter of the memory of :class:`Samples`.

    Attributes
    ----------
    cells
        (n,) the label nearest to each vertex.
    """

    cells: Ints


@dataclass(frozen=True, eq=False)
class Samples(Labels):
    """Labels with distances to all of the surface.

    Attributes
    ----------
    distances
        (s, n) float32 geodesic distance from each sample to every vertex, inf if not connected.
    farthest_first
        (s,) int, the samples in the order in which they were chosen: the first few lie farthest
        apart, whatever the order of the others.
    """

    distances: Singles
    farthest_first: Ints

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
        cells = _Cells(self.distances.shape[1])
        cells.add(self.distances)
        return cells.of(self.vertices)


class _Cells:
    """Finds the label nearest to each of `count` vertices."""

    def __init__(self, count: int) -> None:
        self._least = np.full(count, np.inf, dtype=np.float32)
        self._nearest = np.zeros(count, dtype=np.int64)
        self._seen = 0

    def add(self, distances: Singles) -> None:
        """Look at further labels by their distances (b, n) to all vertices."""
        # numpy's own search for the least of each column copies all of them to rows first
        for row in distances:
            nearer = np.flatnonzero(row < self._least)
            self._least[nearer] = row[nearer]
            self._nearest[nearer] = self._seen
            self._seen += 1

    def of(self, vertices: Ints) -> Ints:
        """(n,) nearest of all labels (s,), which are these vertices."""
        self._nearest[vertices] = np.arange(len(vertices))
        return self._nearest


@dataclass(frozen=True, eq=False)
class _Ruler:
    """Distances from the labels of a surface.

    Split edges add vertices to the working mesh but nothing to its shape: distances are measured
    on the mesh before the split, at a third of the cost, and carried over to `added`, places on it.
    """

    geodesics: Geodesics
    mesh: TriangleMesh
    vertices: Ints
    added: SurfacePoints | None
    count: int

    @classmethod
    def of(cls, working: WorkingSurface, count: int) -> _Ruler:
        """For at most `count` labels that lie farthest apart."""
        split = working.placed.vertex_count < working.mesh.vertex_count
        mesh = working.placed if split else working.mesh
        # the start is the vertex farthest from the center: it does not depend on numbering
        start = int(np.linalg.norm(mesh.vertices, axis=1).argmax())
        geodesics = Geodesics(mesh)
        vertices = farthest_points(geodesics, min(count, len(mesh.used_vertices)), start=start)
        further = working.mesh.vertices[mesh.vertex_count :]
        added = closest_points(mesh, further) if split else None
        return cls(geodesics, mesh, vertices, added, working.mesh.vertex_count)

    def distances(self, rows: slice) -> Singles:
        """(b, n) from some of the labels to all vertices of the working mesh."""
        vertices, known = self.vertices[rows], self.mesh.vertex_count
        distances = np.empty((len(vertices), self.count), dtype=np.float32)
        self.geodesics.singles_from(vertices, out=distances[:, :known])
        if self.added is not None:
            corners = self.mesh.faces[self.added.faces]
            weights = self.added.barycentric.astype(np.float32)
            carried = distances[:, known:]
            carried[:] = 0.0
            for k in range(3):
                # a corner of weight 0 may lie on another component, infinitely far
                far = np.where(weights[:, k] > 0, distances[:, corners[:, k]], 0.0)
                carried += far * weights[:, k]
        return distances


def dense_samples(working: WorkingSurface, frames: Frames, count: int = DENSE_COUNT) -> Samples:
    """At most `count` samples: the places where another surface may lie.

    Distances and directions are rounded to about 1e-4, far below their own error of half a percent,
    so that a file of them is small and read at once.
    """
    ruler = _Ruler.of(working, count)
    vertices = ruler.vertices
    distances = ruler.distances(slice(None))
    directions = _compass(working.mesh, vertices, frames).toward(vertices, distances)
    round_to_counts(distances)  # the largest array of all: never twice
    round_to_counts(directions)
    return Samples.of(vertices, distances, directions)


def coarse_labels(
    working: WorkingSurface, frames: Frames, count: int = COARSE_COUNT
) -> CoarseLabels:
    """At most `count` labels, chosen as those of :func:`dense_samples`; few numbers are kept."""
    ruler = _Ruler.of(working, count)
    vertices = ruler.vertices
    compass = _compass(working.mesh, vertices, frames)
    cells = _Cells(working.mesh.vertex_count)
    between = np.empty((len(vertices), len(vertices)), dtype=np.float32)
    directions = np.empty_like(between)
    for start in range(0, len(vertices), AT_ONCE):
        rows = slice(start, start + AT_ONCE)
        distances = ruler.distances(rows)
        between[rows] = distances[:, vertices]
        directions[:, rows] = compass.toward(vertices[rows], distances)
        cells.add(distances)
    return CoarseLabels(
        vertices=vertices,
        between=np.minimum(between, between.T),
        directions=directions,
        cells=cells.of(vertices),
    )


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
    directions = _compass(mesh, vertices, frames).toward(vertices, distances)
    return Samples.of(vertices, distances, directions, np.argsort(order, kind="stable"))


def _compass(mesh: TriangleMesh, vertices: Ints, frames: Frames) -> Compass:
    x_axes, z_axes = frames(vertices)
    return Compass(mesh, vertices, x_axes=x_axes, z_axes=z_axes, near=NEAR)
