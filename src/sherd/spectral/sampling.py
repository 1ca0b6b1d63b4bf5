"""Fewer points that stand for many: farthest-point samples, decimation, remeshing."""

from __future__ import annotations

import threading

import numpy as np
import pyfqmr
from numpy.typing import ArrayLike

from sherd.arrays import Floats, Ints
from sherd.errors import OptionError
from sherd.mesh import topology
from sherd.mesh.surface_points import SurfacePoints, closest_points
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.evening import evened, flipped_to_delaunay
from sherd.spectral.geodesics import Geodesics
from sherd.spectral.subdivision import split_long_edges

__all__ = [
    "decimate",
    "farthest_point_sample",
    "farthest_point_sample_euclidean",
    "farthest_points",
    "remesh",
]


# pyfqmr stops short when its error threshold grows too slowly; it goes on from where it stopped.
DECIMATION_ROUNDS = 4
# A result this much above the wanted count is taken: the last few collapses are the ugly ones.
COUNT_TOLERANCE = 0.01
# Remeshing decimates from edges this short relative to the wanted ones: about six vertices for
# one, so that few edges of the old triangulation survive and the new one is free to be even.
REFINEMENT = 0.55
# Smoothing converges geometrically; three steps between two projections stay near the surface.
SMOOTHING_STEPS = 3
SMOOTHING_ROUNDS = 3
# Vertices per area of equilateral triangles with unit edges.
VERTICES_PER_AREA = 2 / np.sqrt(3)

# pyfqmr keeps the mesh in global variables between its calls, whichever object they are made of:
# of two threads that decimate at once one would get the mesh of the other.
_pyfqmr = threading.Lock()


def farthest_point_sample(geodesics: Geodesics, count: int, *, start: int) -> tuple[Ints, Floats]:
    """The :func:`farthest_points` of a mesh and their distances.

    Parameters
    ----------
    geodesics, count, start
        As there, and what is raised.

    Returns
    -------
    indices, distances
        (c,) int and (c, n) float, l: geodesic distance from each sample to every vertex, inf where
        not connected. No vertex is farther along paths from the sample than two samples are from
        each other.

    Notes
    -----
    c distance computations, all at once; memory 8 c n bytes.
    """
    chosen = farthest_points(geodesics, count, start=start)
    return chosen, geodesics.distances_from(chosen)


def farthest_points(geodesics: Geodesics, count: int, *, start: int) -> Ints:
    """A sample (count,) of vertices, each the farthest from those before it.

    The first ones of a sample are the sample of fewer.

    Which is the farthest is measured along paths of edges and of straight lines across two
    triangles, a few percent longer than geodesics; the distances are geodesic. Vertices of a
    component that has no sample yet are infinitely far, so each component in turn, largest first,
    gets one sample; from then on all share one spacing, that is, get samples in proportion to their
    area. Vertices without a face are never taken. Ties go to the lower index, so the same question
    has the same answer.

    Parameters
    ----------
    geodesics
        Distances on the mesh.
    count
        Number of samples c, from 1 to the number of vertices with a face.
    start
        The first sample.

    Raises
    ------
    OptionError
        If `count` is out of range or `start` is no vertex with a face.

    References
    ----------
    Gonzalez, *Clustering to minimize the maximum intercluster distance*, 1985.
    """
    from sherd.spectral.farthest_kernel import farthest_along_paths  # as below  # noqa: PLC0415

    usable = geodesics.used_vertices
    _check_sample(count, start, usable)
    ranks = np.full(len(geodesics.component_labels), -1, dtype=np.int64)
    ranks[usable] = geodesics.component_labels[usable]
    paths = geodesics.paths
    chosen: Ints = farthest_along_paths(
        paths.indptr, paths.indices, paths.data, ranks, count, start
    )
    return chosen


def farthest_point_sample_euclidean(points: ArrayLike, count: int, *, start: int) -> Ints:
    """Indices (count,) of points (n, 3), each the farthest in space from those before it.

    Raises
    ------
    OptionError
        If `count` is not in 1..n or `start` is not in 0..n-1.

    Notes
    -----
    Compiled loop, O(count n): 1,000 of 1,000,000 points in about 2 s.
    """
    # numba loads slowly
    from sherd.spectral.farthest_kernel import farthest_in_space  # noqa: PLC0415

    array = np.ascontiguousarray(points, dtype=np.float64)
    _check_sample(count, start, np.arange(len(array)))
    chosen: Ints = farthest_in_space(array, count, start)
    return chosen


def decimate(
    mesh: TriangleMesh, vertex_count: int, *, keep_border: bool = True
) -> tuple[TriangleMesh, SurfacePoints]:
    """A mesh of about `vertex_count` vertices on the surface of `mesh`, and where they lie on it.

    Every border edge is kept unless told otherwise. The vertices of the result are exactly
    `points.positions(mesh)`, and its fields are interpolated there. The count is met within
    1 %, except where border, topology or tiny components allow no more collapses: then more
    vertices come back, so read `vertex_count` of the result.

    Parameters
    ----------
    mesh
        Any mesh; it is returned as it is, without unreferenced vertices, if it is small enough.
    vertex_count
        Wanted number of vertices, at least 4 and more than there are border vertices that are kept.
    keep_border
        If False, the border is decimated like the rest and stays within an edge length of its
        place: the right choice where a dense border would use up the vertices.

    Raises
    ------
    OptionError
        If `vertex_count` is too small.

    References
    ----------
    Garland and Heckbert, *Surface simplification using quadric error metrics*, 1997 (pyfqmr).
    """
    smallest = max(4, len(mesh.boundary_vertices) + 1) if keep_border else 4
    if vertex_count < smallest:
        raise OptionError(
            f"vertex_count is {vertex_count}, but {mesh.name} needs at least {smallest}: "
            f"{len(mesh.boundary_vertices)} vertices lie on its border, which is kept"
        )
    vertices, faces = _decimated(mesh.vertices, mesh.faces, vertex_count, keep_border=keep_border)
    return _on_surface(mesh, vertices, faces)


def remesh(mesh: TriangleMesh, edge_length: float) -> tuple[TriangleMesh, SurfacePoints]:
    """The surface of `mesh` with new, even triangles of about the wanted edge length.

    Edges are split, the mesh is decimated, and inner vertices move to the middle of their
    neighbors along the surface. The vertices of the result are exactly
    `points.positions(mesh)`, and its fields are interpolated there. Border vertices of `mesh`
    stay where they are; border edges longer than the wanted length are split.

    Parameters
    ----------
    mesh
        Any mesh.
    edge_length
        Wanted mean edge length, l, above 0.

    Raises
    ------
    OptionError
        If `edge_length` is not positive, or the result would have more than 20 million vertices.
    """
    wanted = VERTICES_PER_AREA * mesh.area / edge_length**2 if edge_length > 0 else np.inf
    if not wanted < 2e7:
        raise OptionError(
            f"edge_length is {edge_length}, but a positive length of a surface of area "
            f"{mesh.area:.3g} is needed that asks for fewer than 20 million vertices"
        )
    vertices, faces = split_long_edges(mesh.vertices, mesh.faces, REFINEMENT * edge_length)
    border = len(np.unique(topology.boundary_edges(faces)))
    # a border at twice the density of the inside belongs to half a ring of extra vertices
    vertices, faces = _decimated(vertices, faces, max(4, int(wanted) + border // 2, border + 1))
    for _ in range(SMOOTHING_ROUNDS):
        faces = flipped_to_delaunay(vertices, faces)
        vertices = evened(vertices, faces, steps=SMOOTHING_STEPS)
        vertices = closest_points(mesh, vertices).positions(mesh)
    return _on_surface(mesh, vertices, flipped_to_delaunay(vertices, faces))


def _check_sample(count: int, start: int, usable: Ints) -> None:
    if not 1 <= count <= len(usable):
        raise OptionError(f"count is {count}, but 1..{len(usable)} samples can be taken")
    if start not in usable:
        raise OptionError(f"start is {start}, but that is no vertex of a face")


def _decimated(
    vertices: Floats, faces: Ints, vertex_count: int, *, keep_border: bool = True
) -> tuple[Floats, Ints]:
    """Quadric decimation by pyfqmr; the surface is only approximately kept."""
    vertices, faces = _compact(vertices, faces)
    for _ in range(DECIMATION_ROUNDS):
        before = len(vertices)
        if before <= vertex_count * (1 + COUNT_TOLERANCE):
            break
        edges, uses = topology.unique_edges(faces)
        characteristic = len(vertices) - len(edges) + len(faces)
        # V - E + F = characteristic and 3 F = 2 E - border
        # a border that is thinned like the rest goes with the spacing
        border = (uses == 1).sum() * (1.0 if keep_border else np.sqrt(vertex_count / before))
        target = 2 * (vertex_count - characteristic) - int(border)
        simplifier = pyfqmr.Simplify()
        with _pyfqmr:
            simplifier.setMesh(vertices, faces.astype(np.int32))
            simplifier.simplify_mesh(
                target_count=max(4, target),
                aggressiveness=5,
                preserve_border=keep_border,
                verbose=False,
            )
            vertices, faces, _ = simplifier.getMesh()
        vertices, faces = _compact(np.asarray(vertices, dtype=np.float64), faces.astype(np.int64))
        if len(vertices) == before:
            break
    return vertices, faces


def _compact(vertices: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """Without faces that name a vertex twice and without unreferenced vertices."""
    proper = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    used, faces = topology.renumbered(faces[proper])
    return vertices[used], faces


def _on_surface(
    mesh: TriangleMesh, vertices: Floats, faces: Ints
) -> tuple[TriangleMesh, SurfacePoints]:
    points = closest_points(mesh, vertices)
    fields = {key: points.interpolate(mesh, values) for key, values in mesh.fields.items()}
    return TriangleMesh(points.positions(mesh), faces, fields=fields, name=mesh.name), points
