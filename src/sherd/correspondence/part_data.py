"""PartData: what matching needs to know about the part, in the unit of the template."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from sherd.arrays import Floats, Ints, Singles
from sherd.correspondence.elastic_surface import ElasticSurface, elastic_surface
from sherd.descriptors.rotation_shot import rotation_spectra, weighted_spectra
from sherd.descriptors.tangent_frames import geodesic_directions, smoothed_normals, tangent_axes
from sherd.mesh.surface_points import SurfacePoints, closest_points
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.denoising import denoised
from sherd.spectral.geodesics import Geodesics
from sherd.spectral.sampling import farthest_point_sample
from sherd.template import AXIS_WIDTH, NEAR, RADII, canonical, working_mesh

__all__ = [
    "NODE_COUNT",
    "PartData",
    "mirrored",
    "part_data",
    "part_spectra",
    "rescaled",
    "trusted_by_cut",
    "trusted_equally",
]


# 200 nodes on a part of half the area lie 0.05 apart, half the largest neighborhood; 400 were
# no better and four times as dear.
NODE_COUNT = 200
# A neighborhood reaching far over the cut still says something about the near side.
LEAST_TRUST = 0.15
# Any direction will do for tangent axes.
REFERENCE = np.array([1.0, 0.3, 0.2])
# Stands for "no cut at all": longer than any geodesic that matters.
NO_CUT = 9.0


@dataclass(frozen=True, eq=False)
class PartData:
    """The part in the template's unit, with its samples.

    Attributes
    ----------
    placed, mesh
        The part itself, scaled and turned to its own principal axes, and the same surface as a
        working mesh, see :func:`sherd.template.working_mesh`; all below is about the latter.
    own_vertices
        Where the vertices of the part itself lie on the working mesh; None if they are its
        vertices.
    cut_distance
        (n',) geodesic distance of each vertex to the part's border.
    normals
        (n', 3) smoothed unit normals.
    nodes
        (k,) farthest-point samples of the vertices, by distance from the one deepest inside.
    node_distances
        (k, n') float32 geodesic distances, inf where not connected.
    between
        (k, k) symmetric distances between the nodes.
    x_axes
        (k, 3) first tangent axis of each node.
    directions
        (k, k) angle of the geodesic from node to node.
    reference
        (3,) direction that tangent axes are made from.
    pin_vertices, pin_positions
        (p,) vertices and (p, 3) places in the template's frame where the user wants them.
    """

    placed: TriangleMesh
    mesh: TriangleMesh
    own_vertices: SurfacePoints | None
    cut_distance: Floats
    normals: Floats
    nodes: Ints
    node_distances: Singles
    between: Floats
    x_axes: Floats
    directions: Singles
    reference: Floats
    pin_vertices: Ints
    pin_positions: Floats

    @cached_property
    def elastic(self) -> ElasticSurface:
        """The working mesh as an elastic surface."""
        return elastic_surface(self.mesh)


def part_data(
    part: TriangleMesh, length: float, *, pins: tuple[Ints, Floats] | None = None
) -> PartData:
    """Sample the part.

    Parameters
    ----------
    part
        The part.
    length
        The part's length that equals the template's unit.
    pins
        (p,) vertices and (p, 3) places in the template's frame (landmarks); these vertices become
        nodes in addition to the others.
    """
    pin_vertices, pin_positions = pins or (np.empty(0, dtype=np.int64), np.empty((0, 3)))
    placed = denoised(canonical(part, length))
    mesh = working_mesh(placed)
    own_vertices = None if mesh is placed else closest_points(mesh, placed.vertices)
    if own_vertices is not None:
        pin_vertices = own_vertices[pin_vertices].nearest_vertices(mesh)
        pin_vertices, first = np.unique(pin_vertices, return_index=True)
        pin_positions = pin_positions[first]
    geodesics = Geodesics(mesh)
    cut = geodesics.distances_to_set(mesh.boundary_vertices)
    cut = np.where(np.isfinite(cut), np.minimum(cut, NO_CUT), NO_CUT)
    used = np.unique(mesh.faces)
    start = int(used[cut[used].argmax()])
    count = min(NODE_COUNT, len(used))
    nodes, distances = farthest_point_sample(geodesics, count, start=start)
    added = np.setdiff1d(pin_vertices, nodes)
    if len(added):
        nodes = np.concatenate([nodes, added])
        distances = np.concatenate([distances, geodesics.distances_from(added)])
    # message passing sweeps outward from the first node, the one farthest from the cut
    order = np.argsort(distances[0, nodes], kind="stable")
    nodes, distances = nodes[order], distances[order]
    between = distances[:, nodes]
    normals = smoothed_normals(mesh, AXIS_WIDTH)
    x_axes = tangent_axes(normals[nodes], np.tile(REFERENCE, (len(nodes), 1)))
    directions = geodesic_directions(
        mesh, nodes, distances, x_axes=x_axes, z_axes=normals[nodes], near=NEAR
    )
    return PartData(
        placed=placed,
        mesh=mesh,
        own_vertices=own_vertices,
        cut_distance=cut,
        normals=normals,
        nodes=nodes,
        node_distances=distances.astype(np.float32),
        between=np.minimum(between, between.T),
        x_axes=x_axes,
        directions=directions,
        reference=REFERENCE,
        pin_vertices=pin_vertices,
        pin_positions=pin_positions,
    )


def mirrored(data: PartData) -> PartData:
    """The part's mirror image: to place it is to look for the orientation-reversing twin."""
    flip = np.array([-1.0, 1.0, 1.0])
    own = data.own_vertices  # the corners of every face are listed the other way round
    return replace(
        data,
        own_vertices=None if own is None else SurfacePoints(own.faces, own.barycentric[:, ::-1]),
        placed=_reflected(data.placed, flip),
        mesh=_reflected(data.mesh, flip),
        normals=data.normals * flip,
        x_axes=data.x_axes * flip,
        directions=-data.directions,
        reference=data.reference * flip,
    )


def _reflected(mesh: TriangleMesh, flip: Floats) -> TriangleMesh:
    return TriangleMesh(mesh.vertices * flip, mesh.faces[:, ::-1], name=mesh.name)


def rescaled(data: PartData, factor: float) -> PartData:
    """The part made larger by `factor`."""
    return replace(
        data,
        placed=data.placed.with_vertices(data.placed.vertices * factor),
        mesh=data.mesh.with_vertices(data.mesh.vertices * factor),
        cut_distance=np.minimum(data.cut_distance * factor, NO_CUT),
        node_distances=data.node_distances * np.float32(factor),
        between=data.between * factor,
    )


def part_spectra(data: PartData, vertices: Ints) -> Singles:
    """Spectra (5, q, 2 c) of the given vertices; frames as at nodes."""
    x_axes = tangent_axes(data.normals[vertices], np.tile(data.reference, (len(vertices), 1)))
    return rotation_spectra(
        data.mesh.vertices,
        data.normals,
        data.mesh.vertex_areas,
        vertices,
        x_axes=x_axes,
        z_axes=data.normals[vertices],
        radii=RADII,
    )


def trusted_by_cut(data: PartData, vertices: Ints, spectra: Singles) -> Singles:
    """`spectra` of the vertices, a neighborhood that the cut makes incomplete counting less.

    Its weight is the distance to the cut over its radius.
    """
    trust = np.clip(data.cut_distance[vertices, None] / np.array(RADII), LEAST_TRUST, 1.0)
    return weighted_spectra(spectra, trust)


def trusted_equally(spectra: Singles) -> Singles:
    """`spectra` whose radii all count the same.

    So they should when the full shape is described inside the same region.
    """
    return weighted_spectra(spectra, np.ones((spectra.shape[1], len(RADII))))
