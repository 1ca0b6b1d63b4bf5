"""Borders drawn together: pieces of one whole meet where they were cut apart.

Each piece alone is good to a vertex spacing or two, and slides along featureless stretches; its
neighbors know where it must end. Each vertex on a piece's border is drawn to the middle between
itself and the nearest border of another piece, the pieces staying elastic, some times.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from sherd.arrays import Bools, Floats, Ints
from sherd.correspondence.question import Pins, Question
from sherd.correspondence.registration import Deformation, registered_to_surface
from sherd.correspondence.working_placement import (
    SECOND_REACHES,
    Queries,
    WorkingPlacement,
    judged_placement,
    look_inside,
)
from sherd.match import PlacedPart
from sherd.mesh.topology import boundary_edges
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.puzzle.trials import Trial

__all__ = [
    "Border",
    "BorderFit",
    "border_of",
    "bordering",
    "drawn_to_borders",
    "fits_of",
    "nearest_borders",
]

# Borders farther apart than this are of different cuts: twice the error of a bad border.
REACH = 0.06
# Points of a border lie this close together: far below what borders are off.
SPACING = 0.003
# How firmly borders draw: below this length the elasticity decides, above it the border.
FIRMNESS = 0.008
ROUNDS = 3
# Mean gap between borders below which the pieces overlap by more than placements are off: a vertex
# spacing.
LEAST_GAP = -0.01
# Both pieces lie on the surface beside each other: their normals agree within 60 degrees, and what
# is outward of one border is inward of the other.
SAME_SIDE, FACING = 0.5, -0.3
# A border vertex off by half a vertex spacing is where it belongs; then nothing is drawn.
TOGETHER = 0.005


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
    """

    vertices: Ints
    at_vertices: Ints
    positions: Floats
    outward: Floats
    normals: Floats


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
    edges = boundary_edges(mesh.faces)
    if not len(edges):
        none = np.empty((0, 3))
        return Border(np.empty(0, np.int64), np.empty(0, np.int64), none, none, none)
    faces, opposite = _faces_at(mesh.faces, edges)
    first, second = positions[edges[:, 0]], positions[edges[:, 1]]
    corners = positions[mesh.faces[faces]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
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
    vertices, slot = np.unique(edges, return_inverse=True)
    mean_outward, mean_normal = np.zeros((len(vertices), 3)), np.zeros((len(vertices), 3))
    for end in slot.reshape(-1, 2).T:
        np.add.at(mean_outward, end, outward)
        np.add.at(mean_normal, end, normals)
    return Border(
        vertices=vertices,
        at_vertices=len(rows) + np.arange(len(vertices)),
        positions=np.concatenate([between, positions[vertices]]),
        outward=np.concatenate([outward[rows], _unit(mean_outward)]),
        normals=np.concatenate([normals[rows], _unit(mean_normal)]),
    )


def nearest_borders(borders: Sequence[Border]) -> list[BorderFit]:
    """For each border the nearest points of the others that face it."""
    trees = [cKDTree(b.positions) if len(b.positions) else None for b in borders]
    found = []
    for here, border in enumerate(borders):
        rows = border.at_vertices
        count = len(rows)
        piece = np.full(count, -1, dtype=np.int64)
        places = border.positions[rows].copy()
        best, gap = np.full(count, np.inf), np.full(count, np.inf)
        for there, (other, tree) in enumerate(zip(borders, trees, strict=True)):
            if there == here or tree is None or not count:
                continue
            found_at = tree.query(border.positions[rows], distance_upper_bound=REACH)
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


def bordering(chosen: Mapping[int, Trial], *, may_overlap: bool = False) -> dict[int, PlacedPart]:
    """By piece its placement, borders drawn together where the pieces were cut from one surface.

    Where pieces were not cut apart but scanned, they overlap everywhere; then they stay as they
    are. Placements that are off leave as many cracks as overlaps.
    """
    parts = {piece: trial.placed for piece, trial in chosen.items()}
    if may_overlap or len(parts) < 2:
        return parts
    questions = [part.question for part in parts.values()]
    placements = [part.best for part in parts.values()]
    gaps = np.concatenate([fit.gap for fit in fits_of(questions, placements)])
    gaps = gaps[np.isfinite(gaps)]
    if not len(gaps) or gaps.mean() < LEAST_GAP:
        return parts
    drawn = drawn_to_borders(questions, placements, [part.queries for part in parts.values()])
    return {
        piece: replace(part, best=best)
        for (piece, part), best in zip(parts.items(), drawn, strict=True)
    }


def fits_of(
    questions: Sequence[Question], placements: Sequence[WorkingPlacement]
) -> list[BorderFit]:
    """How the borders of these placements fit each other."""
    return nearest_borders(
        [
            border_of(question.part.mesh, place.deformation.positions)
            for question, place in zip(questions, placements, strict=True)
        ]
    )


def drawn_to_borders(
    questions: Sequence[Question],
    placements: Sequence[WorkingPlacement],
    queries: Sequence[Queries],
) -> list[WorkingPlacement]:
    """The placements with borders drawn together, each judged anew."""
    deformations = [place.deformation for place in placements]
    looks = [
        look_inside(question, place, each)
        for question, place, each in zip(questions, deformations, queries, strict=True)
    ]
    drawn: Bools = np.zeros(len(placements), dtype=bool)
    for _ in range(ROUNDS):
        borders = [
            border_of(question.part.mesh, place.positions)
            for question, place in zip(questions, deformations, strict=True)
        ]
        moved: list[Deformation] = []
        for k, (fit, border) in enumerate(zip(nearest_borders(borders), borders, strict=True)):
            near = np.isfinite(fit.gap)
            if not (np.abs(fit.gap[near]) > TOGETHER).any():
                moved.append(deformations[k])
                continue
            drawn[k] = True
            here = border.positions[border.at_vertices]
            pins = Pins(
                border.vertices[near],
                0.5 * (here[near] + fit.places[near]),
                np.empty((0, 2), dtype=np.int64),
                FIRMNESS,
            )
            moved.append(
                registered_to_surface(
                    replace(questions[k], pins=pins),
                    deformations[k],
                    looks[k],
                    reaches=SECOND_REACHES[-1:],
                    slides=2,
                )
            )
        deformations = moved
    return [
        judged_placement(question, place, look) if changed else before
        for question, place, look, before, changed in zip(
            questions, deformations, looks, placements, drawn, strict=True
        )
    ]


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
