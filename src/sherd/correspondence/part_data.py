"""PartData: what matching needs to know about the part, in the unit of the template."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sherd.descriptors.rotation_shot import rotation_spectra, weighted_spectra
from sherd.descriptors.tangent_frames import geodesic_directions, smoothed_normals, tangent_axes
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.geodesics import Geodesics
from sherd.spectral.sampling import farthest_point_sample
from sherd.template import AXIS_WIDTH, NEAR, RADII, canonical

__all__ = ["NODE_COUNT", "PartData", "part_data", "part_spectra"]

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Ints = NDArray[np.int64]

# 200 nodes on a part of half the area lie 0.05 apart, half the largest neighborhood; 400 were
# no better and four times as dear.
NODE_COUNT = 200
# A neighborhood reaching far over the cut still says something about the near side.
LEAST_TRUST = 0.15
# Stands for "no cut at all": longer than any geodesic that matters.
NO_CUT = 9.0


@dataclass(frozen=True, eq=False)
class PartData:
    """The part in the template's unit, with its samples.

    Attributes
    ----------
    mesh
        The part, scaled and turned to its own principal axes.
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
    """

    mesh: TriangleMesh
    cut_distance: Floats
    normals: Floats
    nodes: Ints
    node_distances: Singles
    between: Floats
    x_axes: Floats
    directions: Singles


def part_data(part: TriangleMesh, length: float, *, extra_nodes: Ints | None = None) -> PartData:
    """Sample the part; `length` is the part's length that equals the template's unit.

    `extra_nodes` (e,) are vertices that must be nodes (landmarks); they are added to the others.
    """
    mesh = canonical(part, length)
    geodesics = Geodesics(mesh)
    cut = geodesics.distances_to_set(mesh.boundary_vertices)
    cut = np.where(np.isfinite(cut), np.minimum(cut, NO_CUT), NO_CUT)
    used = np.unique(mesh.faces)
    start = int(used[cut[used].argmax()])
    count = min(NODE_COUNT, len(used))
    nodes, distances = farthest_point_sample(geodesics, count, start=start)
    if extra_nodes is not None and len(extra_nodes):
        added = np.setdiff1d(extra_nodes, nodes)
        nodes = np.concatenate([nodes, added])
        distances = np.concatenate([distances, geodesics.distances_from(added)])
    # message passing sweeps outward from the first node, the one farthest from the cut
    order = np.argsort(distances[0, nodes], kind="stable")
    nodes, distances = nodes[order], distances[order]
    between = distances[:, nodes]
    normals = smoothed_normals(mesh, AXIS_WIDTH)
    x_axes = tangent_axes(normals[nodes], np.tile([1.0, 0.3, 0.2], (len(nodes), 1)))
    directions = geodesic_directions(
        mesh, nodes, distances, x_axes=x_axes, z_axes=normals[nodes], near=NEAR
    )
    return PartData(
        mesh,
        cut,
        normals,
        nodes,
        distances.astype(np.float32),
        np.minimum(between, between.T),
        x_axes,
        directions,
    )


def part_spectra(data: PartData, vertices: Ints, *, cut_aware: bool) -> Singles:
    """Weighted spectra (5, q, 2 c) of the given vertices; frames as at nodes.

    With `cut_aware`, a neighborhood that the cut makes incomplete counts less: in proportion to the
    distance to the cut over its radius. Without it all radii count the same, as they should when
    the full shape is described inside the same region.
    """
    x_axes = tangent_axes(data.normals[vertices], np.tile([1.0, 0.3, 0.2], (len(vertices), 1)))
    spectra = rotation_spectra(
        data.mesh.vertices,
        data.normals,
        data.mesh.vertex_areas,
        vertices,
        x_axes=x_axes,
        z_axes=data.normals[vertices],
        radii=RADII,
    )
    trust = np.ones((len(vertices), len(RADII)))
    if cut_aware:
        trust = np.clip(data.cut_distance[vertices, None] / np.array(RADII), LEAST_TRUST, 1.0)
    return weighted_spectra(spectra, trust)
