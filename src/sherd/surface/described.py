"""DescribedSurface: all that matching and locating ask of one shape, computed on first use."""

from __future__ import annotations

from dataclasses import dataclass, fields
from threading import Lock
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from sherd.arrays import Bools, Floats, Ints, Singles
from sherd.descriptors.principal_spectra import PrincipalAxes, principal_axes
from sherd.descriptors.relief_patches import ReliefPatches, relief_patches
from sherd.descriptors.rotation_shot import rotation_spectra, trusted_by_cut
from sherd.descriptors.tangent_frames import smoothed_normals, tangent_axes
from sherd.mesh.surface_finder import SurfaceFinder
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.basis import EigenBasis, eigenbasis
from sherd.spectral.geodesics import Geodesics
from sherd.spectral.sampling import farthest_point_sample_euclidean
from sherd.surface.elastic_surface import ElasticSurface, elastic_surface
from sherd.surface.samples import (
    CoarseLabels,
    Samples,
    coarse_labels,
    dense_samples,
    sparse_samples,
)
from sherd.surface.viewing import viewing_direction
from sherd.surface.working import WorkingSurface
from sherd.threads import cached_property

__all__ = [
    "LEAST_TRUST",
    "NO_CUT",
    "RADII",
    "REFERENCE",
    "DescribedSurface",
    "Known",
    "LabelPatches",
    "Spread",
]

# All lengths are in units of sqrt(area of the full shape).
# Neighborhoods from the smallest that holds some 40 vertices of a 10,000-vertex mesh to the
# width of a limb; larger ones meet the cut too often and change with the pose.
RADII = (0.04, 0.06, 0.10)
# A neighborhood reaching far over the cut still says something about the near side.
LEAST_TRUST = 0.15
# The normal axis must not see single vertices (spacing 0.01 at 10,000 vertices) but still turn
# with the smallest neighborhood.
AXIS_WIDTH = 0.012
# Any direction will do for tangent axes; none of the coordinate axes, which shapes often follow.
REFERENCE = np.array([1.0, 0.3, 0.2])
# So many spectra are described before they are projected: 20 MB, instead of all at once.
BLOCK = 4096
# `Spread` vertices of a whole lie 0.013 apart, a third of the smallest radius, so that one of them
# sees nearly what the best vertex would see.
SPREAD_COUNT = 6000
# Three times as many as there are labels in matching, 0.016 apart: bumps are as wide, so one of the
# vertices in the cell of the right label shows them in the right places.
PATCH_COUNT = 3600
# A fifth of them, as many as there are labels in matching, tell what spectra look like.
AXES_STEP = 5
# Stands for "no cut at all": longer than any geodesic that matters.
NO_CUT = 9.0


@dataclass(frozen=True, eq=False)
class Spread:
    """Vertices spread evenly over a surface, a third of the smallest neighborhood apart.

    Attributes
    ----------
    vertices
        (c,) int, all that have a face if they are few.
    axes
        What their spectra and those compared with them are projected to.
    spectra
        (5, c, 2 k) projected, in the `frames` of the vertices.
    """

    vertices: Ints
    axes: PrincipalAxes
    spectra: Singles


@dataclass(frozen=True, eq=False)
class LabelPatches:
    """The relief around vertices spread evenly over a surface.

    Attributes
    ----------
    cells
        (c,) int, of the label in whose cell each vertex lies.
    patches
        (c,) in the frames of `cell_axes`.
    """

    cells: Ints
    patches: ReliefPatches


@dataclass(frozen=True, eq=False)
class Known:
    """What is known of a surface beforehand, from a file or from its mirror image; else None."""

    normals: Floats | None = None
    cut_distance: Floats | None = None
    dense: Samples | None = None
    sparse: Samples | None = None
    axes: PrincipalAxes | None = None
    spectra: Singles | None = None


class DescribedSurface:
    """One shape of a question, whole or cut: both sides of every question are one of these.

    All is stated in units of sqrt(area of the full shape), so that neither the unit of the files
    nor a scaling of both shapes matters, and is about the working mesh unless it says otherwise.

    Parameters
    ----------
    working
        The surface at unit scale.
    reference
        (3,) direction that tangent axes are made from.
    sampled_at
        (p,) vertices that must be among the sparse samples.
    known
        What need not be computed.
    """

    def __init__(
        self,
        working: WorkingSurface,
        *,
        reference: Floats = REFERENCE,
        sampled_at: Ints | None = None,
        known: Known | None = None,
    ) -> None:
        self._begin(reference, sampled_at)
        self._given = (working, known or Known())

    def _begin(self, reference: Floats = REFERENCE, sampled_at: Ints | None = None) -> None:
        """Set what does not come from the shape itself."""
        self.reference = reference
        self._sampled_at = np.empty(0, dtype=np.int64) if sampled_at is None else sampled_at
        self._bases: dict[int, EigenBasis] = {}
        self._basis_lock = Lock()

    def __getstate__(self) -> dict[str, Any]:
        """What takes long to compute, as far as it is computed; trees and factors stay behind."""
        computed = {
            each.name: self.__dict__.get(each.name, getattr(self._known, each.name))
            for each in fields(Known)
        }
        return {
            "working": self.working,
            "reference": self.reference,
            "sampled_at": self._sampled_at,
            "known": Known(**computed),
        }

    def __setstate__(self, state: dict[str, Any]) -> None:
        DescribedSurface.__init__(self, **state)

    @property
    def working(self) -> WorkingSurface:
        """The surface at unit scale."""
        return self._given[0]

    @property
    def _known(self) -> Known:
        return self._given[1]

    @property
    def placed(self) -> TriangleMesh:
        """The shape itself, whose vertices and faces answers are counted by."""
        return self.working.placed

    @property
    def mesh(self) -> TriangleMesh:
        """The working mesh."""
        return self.working.mesh

    @property
    def own_vertices(self) -> SurfacePoints | None:
        """Where the vertices of `placed` lie on the working mesh; None if they are its vertices."""
        return self.working.own_vertices

    @cached_property
    def finder(self) -> SurfaceFinder:
        """Closest points on the working mesh."""
        return SurfaceFinder(self.mesh)

    @cached_property
    def own_finder(self) -> SurfaceFinder:
        """Closest points on the shape itself."""
        return self.finder if self.own_vertices is None else SurfaceFinder(self.placed)

    @cached_property
    def vertex_tree(self) -> cKDTree:
        """The vertices, to find those near a place."""
        return cKDTree(self.mesh.vertices)

    @cached_property
    def geodesics(self) -> Geodesics:
        """Distances on the working mesh."""
        return Geodesics(self.mesh)

    @cached_property
    def elastic(self) -> ElasticSurface:
        """The working mesh as an elastic surface."""
        return elastic_surface(self.mesh)

    @cached_property
    def cut_distance(self) -> Floats:
        """(n,) geodesic distance to the border, at most `NO_CUT`, which also says: no border."""
        if self._known.cut_distance is not None:
            return self._known.cut_distance
        distance = self.geodesics.distances_to_set(self.mesh.boundary_vertices)
        return np.where(np.isfinite(distance), np.minimum(distance, NO_CUT), NO_CUT)

    @cached_property
    def normals(self) -> Floats:
        """(n, 3) smoothed unit normals."""
        if self._known.normals is not None:
            return self._known.normals
        return smoothed_normals(self.mesh, AXIS_WIDTH)

    @cached_property
    def viewer(self) -> Floats | None:
        """Unit direction (3,) toward who saw it, if all of it was seen from one side; else None."""
        return viewing_direction(self.normals, self.mesh.vertex_areas)

    @cached_property
    def dense(self) -> Samples:
        """Samples that are the places where another surface may lie: labels."""
        if self._known.dense is not None:
            return self._known.dense
        return dense_samples(self.working, self.frames)

    @cached_property
    def coarse(self) -> CoarseLabels:
        """Fewer samples of the same kind as `dense`: labels where only likeness is asked for."""
        return coarse_labels(self.working, self.frames)

    @cached_property
    def spread(self) -> Spread:
        """The surface as it looks from vertices spread evenly over it."""
        vertices = _spread_vertices(self.mesh, SPREAD_COUNT)
        spectra = self.spectra_at(vertices)
        axes = principal_axes(spectra[:, ::AXES_STEP])
        return Spread(vertices, axes, axes.project(spectra))

    @cached_property
    def sparse(self) -> Samples:
        """Samples that are placed on another surface: nodes."""
        if self._known.sparse is not None:
            return self._known.sparse
        return sparse_samples(
            self.mesh, self.geodesics, self.cut_distance, self.frames, also=self._sampled_at
        )

    def frames(self, vertices: Ints) -> tuple[Floats, Floats]:
        """Unit tangent axes and normals (q, 3) of the given vertices."""
        normals = self.normals[vertices]
        return tangent_axes(normals, np.tile(self.reference, (len(vertices), 1))), normals

    @cached_property
    def cell_axes(self) -> Floats:
        """(n, 3) tangent axis of every vertex, nearly parallel within each cell of `dense`."""
        axes, _ = self.frames(self.dense.vertices)
        return tangent_axes(self.normals, axes[self.dense.cells])

    def spectra_at(self, vertices: Ints) -> Singles:
        """(5, q, 2 c) rotation-searched SHOT of some vertices, in their `frames`."""
        return self._spectra(vertices, self.mesh.vertex_areas, *self.frames(vertices))

    def spectra_at_within(self, vertices: Ints, mask: Bools) -> Singles:
        """`spectra_at` as a surface sees them that covers `mask` (n,) only."""
        return self._spectra(vertices, self.mesh.vertex_areas * mask, *self.frames(vertices))

    def trusted_spectra(self, vertices: Ints) -> Singles:
        """`spectra_at` the vertices; what reaches over the cut counts less."""
        depth = self.cut_distance[vertices]
        return trusted_by_cut(self.spectra_at(vertices), depth, RADII, LEAST_TRUST)

    @cached_property
    def axes(self) -> PrincipalAxes:
        """What spectra are projected to before they are compared with those of this surface."""
        if self._known.axes is not None:
            return self._known.axes
        return principal_axes(self.spectra_at(self.dense.vertices))

    @cached_property
    def spectra(self) -> Singles:
        """(5, n, 2 k) rotation-searched SHOT of every vertex, in the frames of `cell_axes`.

        Projected to `axes`.
        """
        if self._known.spectra is not None:
            return self._known.spectra
        return self._projected(np.arange(self.mesh.vertex_count), self.mesh.vertex_areas)

    def spectra_within(self, mask: Bools) -> Singles:
        """`spectra` as a surface sees them that covers `mask` (n,): only the area inside counts.

        Vertices outside, and those that nothing is hidden from, keep their ordinary spectra.
        """
        spectra = self.spectra.copy()
        inside = np.flatnonzero(mask)
        hidden = self.mesh.vertices[~mask & (self.mesh.vertex_areas > 0)]
        if len(hidden) and len(inside):
            gap = cKDTree(hidden).query(self.mesh.vertices[inside])[0]
            inside = inside[gap < max(RADII)]
            spectra[:, inside] = self._projected(inside, self.mesh.vertex_areas * mask)
        return spectra

    @cached_property
    def label_patches(self) -> LabelPatches:
        """The relief around places where another surface may lie."""
        vertices = _spread_vertices(self.mesh, PATCH_COUNT)
        patches = self._patches(vertices, self.cut_distance, self.cell_axes[vertices])
        return LabelPatches(self.dense.cells[vertices], patches)

    def patches_at(self, vertices: Ints) -> ReliefPatches:
        """The relief around some vertices, in their `frames`."""
        return self._patches(vertices, self.cut_distance, self.frames(vertices)[0])

    def patches_at_within(self, vertices: Ints, mask: Bools) -> ReliefPatches:
        """`patches_at` as far as they lie in a mask (n,)."""
        return self._patches(vertices, self.cut_distance * mask, self.frames(vertices)[0])

    def basis(self, size: int) -> EigenBasis:
        """The first `size` eigenpairs of the working mesh; waits if another thread is at it."""
        with self._basis_lock:
            if size not in self._bases:
                self._bases[size] = eigenbasis(self.mesh, size)
            return self._bases[size]

    def _projected(self, vertices: Ints, weights: Floats) -> Singles:
        """(5, q, 2 k) spectra in the frames of `cell_axes`, a block at a time."""
        blocks = np.array_split(vertices, max(1, -(-len(vertices) // BLOCK)))
        found = [
            self.axes.project(
                self._spectra(block, weights, self.cell_axes[block], self.normals[block])
            )
            for block in blocks
        ]
        return np.concatenate(found, axis=1)

    def _patches(self, vertices: Ints, cut_distance: Floats, x_axes: Floats) -> ReliefPatches:
        return relief_patches(self.mesh, self.normals, cut_distance, vertices, x_axes=x_axes)

    def _spectra(self, vertices: Ints, weights: Floats, x_axes: Floats, z_axes: Floats) -> Singles:
        return rotation_spectra(
            self.mesh.vertices,
            self.normals,
            weights,
            vertices,
            x_axes=x_axes,
            z_axes=z_axes,
            radii=RADII,
        )


def _spread_vertices(mesh: TriangleMesh, count: int) -> Ints:
    used = mesh.used_vertices
    if len(used) <= count:
        return used
    points = mesh.vertices[used]
    start = int(np.linalg.norm(points - points.mean(axis=0), axis=1).argmax())
    return used[farthest_point_sample_euclidean(points, count, start=start)]
