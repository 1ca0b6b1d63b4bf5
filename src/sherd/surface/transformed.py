"""Described surfaces of the same shape, changed a little: what is known is carried over."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sherd.arrays import Bools
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.surface.described import NO_CUT, DescribedSurface, Known
from sherd.surface.working import WorkingSurface

__all__ = ["enlarged", "mirrored", "mirrored_mesh", "sampled_within", "thinned"]

FLIP = np.array([-1.0, 1.0, 1.0])


def mirrored(surface: DescribedSurface) -> DescribedSurface:
    """The mirror image: to place it is to look for the orientation-reversing twin."""
    sparse = surface.sparse
    return DescribedSurface(
        _reflected(surface.working),
        reference=surface.reference * FLIP,
        known=Known(
            normals=surface.normals * FLIP,
            cut_distance=surface.cut_distance,
            sparse=replace(sparse, directions=-sparse.directions),
        ),
    )


def enlarged(surface: DescribedSurface, factor: float) -> DescribedSurface:
    """The surface made larger by `factor`, on the same working mesh."""
    working, sparse = surface.working, surface.sparse
    mesh = working.mesh.with_vertices(working.mesh.vertices * factor)
    placed = working.placed.with_vertices(working.placed.vertices * factor)
    return DescribedSurface(
        WorkingSurface(placed, mesh, working.own_vertices),
        reference=surface.reference,
        known=Known(
            normals=surface.normals,
            cut_distance=np.minimum(surface.cut_distance * factor, NO_CUT),
            sparse=replace(
                sparse,
                distances=sparse.distances * np.float32(factor),
                between=sparse.between * factor,
            ),
        ),
    )


def thinned(surface: DescribedSurface, count: int) -> DescribedSurface:
    """The surface with at most `count` of its sparse samples, those that lie farthest apart."""
    return DescribedSurface(
        surface.working,
        reference=surface.reference,
        known=Known(
            normals=surface.normals,
            cut_distance=surface.cut_distance,
            sparse=surface.sparse.thinned(count),
        ),
    )


def sampled_within(surface: DescribedSurface, mask: Bools) -> DescribedSurface:
    """The surface with those of its sparse samples that lie in `mask` (n,)."""
    known = Known(
        normals=surface.normals,
        cut_distance=surface.cut_distance,
        dense=surface.dense,
        sparse=surface.sparse.within(mask),
        axes=surface.axes,
        spectra=surface.spectra,
    )
    return DescribedSurface(surface.working, reference=surface.reference, known=known)


def _reflected(working: WorkingSurface) -> WorkingSurface:
    own = working.own_vertices  # the corners of every face are listed the other way round
    return WorkingSurface(
        placed=mirrored_mesh(working.placed),
        mesh=mirrored_mesh(working.mesh),
        own_vertices=None if own is None else SurfacePoints(own.faces, own.barycentric[:, ::-1]),
    )


def mirrored_mesh(mesh: TriangleMesh) -> TriangleMesh:
    """The mirror image of a mesh, whose faces look outward if its own do."""
    return TriangleMesh(mesh.vertices * FLIP, mesh.faces[:, ::-1], name=mesh.name)
