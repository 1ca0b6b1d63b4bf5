"""Borders of pieces on the full shape: where they run, and which lie beside each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from sherd.arrays import Bools, Floats, Ints
from sherd.mesh.geometry import face_cross
from sherd.mesh.topology import renumbered
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.threads import cached_property

__all__ = [
    "REACH",
    "Border",
    "BorderFit",
    "border_of",
    "facing_lengths",
    "nearest_borders",
]

# Borders farther apart than this are of different cuts: twice the error of a bad border.
REACH = 0.06
# Points of a border lie this close together: far below what borders are off.
SPACING = 0.003
# Both pieces lie on the surface beside each other: their normals agree within 60 degrees, and what
# is outward of one border is inward of the other.
SAME_SIDE, FACING = 0.5, -0.3


@dataclass(frozen=True, eq=False)
class Border:
    """Points of a piece's border on the full shape.

    Attributes
    ----------
    vertices
        (b,) vertices of the working mesh on the border.
    at_vertices
        (b,) the row of each among the points.
    positions, outward, normals
        (p, 3) in the frame of the full shape: where, the direction in the surface that leads out
        of the piece, and the surface's normal.
    weights
        (p,) length of the border that each point stands for.
    """

    vertices: Ints
    at_vertices: Ints
    positions: Floats
    outward: Floats
    normals: Floats
    weights: Floats

    @cached_property
    def tree(self) -> cKDTree:
        """Of its points."""
        return cKDTree(self.positions)

    @property
    def length(self) -> float:
        """Of the whole border."""
        return float(self.weights.sum())


@dataclass(frozen=True, eq=False)
class BorderFit:
    """The nearest border of another piece for the vertices on one piece's border.

    Attributes
    ----------
    piece
        (b,) number of the other piece; -1 where none is near.
    places
        (b, 3) the nearest point of its border.
    gap
        (b,) distance; negative where the pieces overlap, infinite where none is near.
    """

    piece: Ints
    places: Floats
    gap: Floats


def border_of(mesh: TriangleMesh, positions: Floats) -> Border:
    """The border of a working mesh whose vertices lie at `positions` (n', 3)."""
    edges = mesh.boundary_edges
    if not len(edges):
        none = np.empty((0, 3))
        index = np.empty(0, dtype=np.int64)
        return Border(index, index, none, none, none, np.empty(0))
    faces, opposite = _faces_at(mesh.faces, edges)
    first, second = positions[edges[:, 0]], positions[edges[:, 1]]
    normals = face_cross(positions, mesh.faces[faces])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    along = second - first
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    inward = positions[opposite] - first
    inward -= (inward * along).sum(axis=1, keepdims=True) * along
    outward = -inward / np.maximum(np.linalg.norm(inward, axis=1, keepdims=True), 1e-12)
    steps = np.maximum(1, np.ceil(np.linalg.norm(second - first, axis=1) / SPACING)).astype(int)
    rows = np.repeat(np.arange(len(edges)), steps)
    number = np.arange(len(rows)) - np.repeat(np.cumsum(steps) - steps, steps)
    share = ((number + 0.5) / steps[rows])[:, None]
    between = (1 - share) * first[rows] + share * second[rows]
    lengths = (np.linalg.norm(second - first, axis=1) / steps)[rows]
    vertices, slot = renumbered(edges)
    mean_outward, mean_normal = np.zeros((len(vertices), 3)), np.zeros((len(vertices), 3))
    for end in slot.T:
        np.add.at(mean_outward, end, outward)
        np.add.at(mean_normal, end, normals)
    return Border(
        vertices=vertices,
        at_vertices=len(rows) + np.arange(len(vertices)),
        positions=np.concatenate([between, positions[vertices]]),
        outward=np.concatenate([outward[rows], _unit(mean_outward)]),
        normals=np.concatenate([normals[rows], _unit(mean_normal)]),
        weights=np.concatenate([lengths, np.zeros(len(vertices))]),
    )


def nearest_borders(borders: Sequence[Border]) -> list[BorderFit]:
    """For each border the nearest points of the others that face it."""
    found = []
    for here, border in enumerate(borders):
        rows = border.at_vertices
        count = len(rows)
        piece = np.full(count, -1, dtype=np.int64)
        places = border.positions[rows].copy()
        best, gap = np.full(count, np.inf), np.full(count, np.inf)
        for there, other in enumerate(borders):
            if there == here or not len(other.positions) or not count:
                continue
            found_at = other.tree.query(border.positions[rows], distance_upper_bound=REACH)
            away, at = np.asarray(found_at[0]), np.asarray(found_at[1], dtype=np.int64)
            at = np.minimum(at, len(other.positions) - 1)
            facing = (border.outward[rows] * other.outward[at]).sum(axis=1) < FACING
            facing &= (border.normals[rows] * other.normals[at]).sum(axis=1) > SAME_SIDE
            nearer = facing & (away < best)
            to_other = other.positions[at] - border.positions[rows]
            sign = np.sign((to_other * border.outward[rows]).sum(axis=1))
            best[nearer], piece[nearer] = away[nearer], there
            gap[nearer] = (sign * away)[nearer]
            places[nearer] = other.positions[at[nearer]]
        found.append(BorderFit(piece, places, gap))
    return found


def facing_lengths(borders: Sequence[Border]) -> Floats:
    """(k, k) symmetric length along which each two borders face each other."""
    found = np.zeros((len(borders), len(borders)))
    for here, border in enumerate(borders):
        for there, other in enumerate(borders):
            if there != here:
                found[here, there] = float(border.weights @ _faced(border, other))
    lengths: Floats = 0.5 * (found + found.T)
    return lengths


def _faced(border: Border, other: Border) -> Bools:
    """The points (p,) of a border that have the other one near, facing them."""
    faced: Bools = np.zeros(len(border.positions), dtype=bool)
    if not len(border.positions) or not len(other.positions):
        return faced
    away, at = other.tree.query(border.positions, distance_upper_bound=REACH)
    near = np.flatnonzero(np.isfinite(away))
    at = np.asarray(at)[near]
    facing = (border.outward[near] * other.outward[at]).sum(axis=1) < FACING
    facing &= (border.normals[near] * other.normals[at]).sum(axis=1) > SAME_SIDE
    faced[near[facing]] = True
    return faced


def _faces_at(faces: Ints, edges: Ints) -> tuple[Ints, Ints]:
    """For each border edge (b, 2) its face and the vertex of it across the edge."""
    base = int(faces.max()) + 1
    halves = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    keys = halves[:, 0] * base + halves[:, 1]
    order = np.argsort(keys, kind="stable")
    at = order[np.searchsorted(keys[order], edges[:, 0] * base + edges[:, 1])]
    return at // 3, faces[at // 3, (at % 3 + 2) % 3]


def _unit(vectors: Floats) -> Floats:
    unit: Floats = vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12)
    return unit
