"""Deformation: the full shape in the pose of its pieces, from a coarse mesh to its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.correspondence.elastic_kernel import closest_rotations
from sherd.fitting.as_rigid_as_possible import Elasticity
from sherd.fitting.chance import distances_beyond
from sherd.fitting.scan_surface import ScanSurface
from sherd.fitting.sizes import sizes_of
from sherd.fitting.targets import Targets
from sherd.mesh.geometry import closest_rotation, face_areas, vertex_normals
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.fitted.fit_options import Sizing

__all__ = [
    "Deformation",
    "area_kept",
    "carried_up",
    "coarse_deformation",
    "continued_deformation",
    "corners_of",
    "fine_deformation",
    "with_rings",
    "without_data",
]

# All lengths are in units of sqrt(area of the full shape). Data terms are areas over squared
# lengths: below such a length elasticity decides, above it the data. Places of a map are good to
# 0.005 to 0.01.
MAP_LENGTH = 0.01
# A surface is followed down to the size of a triangle.
SURFACE_LENGTH = 0.005
# Along the surface places go so much of the way to those of the map in each round; else elasticity
# alone decides, and what is seen slides. With true maps of 15 parts of animals the error of what
# was seen fell from 0.0049 to 0.0035 and that of the rest by 3 %; with their own maps both stay.
TOWARD_MAP = 0.5
# Places farther than this from where their neighbors draw them are wrong, not noisy.
MAP_LIMIT = 0.03
# Rotations are averaged over so much of what is seen. Beyond, first over as much, so that the bend
# at the cut goes on as what lies on both sides of it asks for; with each step away over more, up to
# the length of a limb, which thus stays in one piece.
SEEN_LENGTH, LARGEST_LENGTH = 0.03, 0.5
# What the edges of a hidden vertex say of its rotation, beside those of a seen one: near the cut as
# much, and so much far from it, where positions follow from rotations rather than the reverse.
FAR_CERTAINTY, NEAR_CUT = 0.02, 0.05
# Rotations to begin with, of places that were not averaged yet.
FIRST_LENGTH = 0.05
# What is not released stays within this.
HOLD_LENGTH = 0.002
MAP_ROUNDS, SURFACE_ROUNDS, FINE_ROUNDS = 8, 4, 2
# Beyond the cut rotations go on as they change there, and come to rest over about this length. Of
# 27 balls of animated animals, 2,500 vertices, the mean ratio of hidden errors to those of libigl's
# ARAP with the same map is 0.96 for lengths of 0, 0.93 for 0.1 and 0.2, 0.94 for 0.3.
CONTINUED_LENGTH = 0.1
# Over so much what is continued may differ from what edges say: less than a triangle, as rotations
# were smoothed before, and the last ring tells most. With 0.001 that ratio is 0.95, with 0.005
# 0.94, with 0.01 0.955, with 0.03 1.00.
KEPT_LENGTH = 0.003
# Rotations that change fast squeeze what lies on the inner side of a bend. While hidden area
# changes by more than this, less than the 0.05 that a fit is doubted for, as what follows changes
# it by up to 0.01, rounds of as-rigid-as-possible spread the bend. Each brings some of the lever
# back: eight of them everywhere would cost 0.025 of the ratio above.
MOST_SQUEEZED, SPREADING_ROUNDS = 0.04, 30

Smoothing: TypeAlias = Callable[[Floats, Floats], Floats]


@dataclass(frozen=True, eq=False)
class Deformation:
    """The full shape laid onto its pieces, in units of sqrt(its area).

    Attributes
    ----------
    positions
        (n, 3) in the frame of the pieces.
    rotations
        (n, 3, 3) from the frame of the full shape.
    sizes
        (n,) how many times longer the surface is there.
    """

    positions: Floats
    rotations: Floats
    sizes: Floats

    @property
    def turns(self) -> Floats:
        """(n, 3, 3) rotations times sizes."""
        turns: Floats = self.sizes[:, None, None] * self.rotations
        return turns


def coarse_deformation(
    elasticity: Elasticity, targets: Targets, scan: ScanSurface, *, sizing: Sizing
) -> Deformation:
    """The shape drawn to its targets, then to the surface of the pieces.

    Parameters
    ----------
    elasticity
        Of the full shape, n vertices, a mesh of moderate size.
    targets
        For its vertices.
    scan
        The surface of the pieces.
    sizing
        As of :class:`sherd.FitOptions`.
    """
    now = _rigid(elasticity, targets)
    # positions that are the targets themselves tell rotations at once, where all around is seen
    inner = targets.seen & (elasticity.springs @ (~targets.seen).astype(np.float64) == 0)
    drawn = np.where(targets.seen[:, None], targets.positions, now.positions)
    first = elasticity.smoothing(inner.astype(np.float64), np.full(len(inner), FIRST_LENGTH))
    now = replace(now, rotations=_smooth_rotations(elasticity, drawn, now.rotations, first))
    smoothing = _rotation_smoothing(elasticity, targets.seen)
    pulls = elasticity.areas * targets.confidence / MAP_LENGTH**2
    for step in range(MAP_ROUNDS):
        firm = pulls if step == 0 else pulls * _inliers(now.positions, targets.positions)
        now = _relaxed(elasticity, now, firm, targets.positions)
        if step >= MAP_ROUNDS // 2:
            sizes = sizes_of(elasticity, now.positions, targets.confidence, sizing=sizing)
            now = replace(now, sizes=sizes)
        now = _turned(elasticity, now, smoothing)
    for _ in range(SURFACE_ROUNDS):
        now = _turned(elasticity, _onto_surface(elasticity, now, targets, scan), smoothing)
    return now


def continued_deformation(
    elasticity: Elasticity, now: Deformation, targets: Targets, scan: ScanSurface
) -> Deformation:
    """What :func:`coarse_deformation` found, its hidden parts turned as what was seen says alone.

    Rotations of hidden vertices that follow their own edges, round by round, lever the noise of the
    map at the cut. Here they are those of what was seen, continued, and positions follow.
    """
    seen = targets.seen
    turned, known = elasticity.seen_rotations(now.positions, seen)
    certain = known * targets.confidence * _inliers(now.positions, targets.positions)
    continued = elasticity.continuation(certain / KEPT_LENGTH**2, CONTINUED_LENGTH)
    rotations = continued(turned.reshape(-1, 9), now.rotations.reshape(-1, 9))
    now = replace(now, rotations=closest_rotations(rotations.reshape(-1, 3, 3)))
    pulls, places = _drawn(elasticity, now, targets, scan)
    relaxed = elasticity.relaxation(pulls)
    now = replace(now, positions=relaxed(now.turns, places, now.positions))
    hidden: Bools = np.all(~seen[elasticity.mesh.faces], axis=1)
    for _ in range(SPREADING_ROUNDS):
        if abs(area_kept(elasticity.mesh, now, hidden) - 1) <= MOST_SQUEEZED:
            break
        now = replace(now, rotations=elasticity.fitted_rotations(now.positions))
        now = replace(now, positions=relaxed(now.turns, places, now.positions))
    return now


def area_kept(shape: TriangleMesh, deformation: Deformation, faces: Bools) -> float:
    """Area of some faces (m,) in the deformation over what it should be; 1 if there are none."""
    if not faces.any():
        return 1.0
    corners = shape.faces[faces]
    wanted = shape.face_areas[faces] * (deformation.sizes[corners] ** 2).mean(axis=1)
    return float(face_areas(deformation.positions, corners).sum() / wanted.sum())


def _turned(elasticity: Elasticity, now: Deformation, smoothing: Smoothing) -> Deformation:
    rotations = _smooth_rotations(elasticity, now.positions, now.rotations, smoothing)
    return replace(now, rotations=rotations)


def carried_up(
    coarse: TriangleMesh, deformation: Deformation, own: SurfacePoints, vertices: Floats
) -> Deformation:
    """A deformation of a coarse mesh for vertices (n, 3) that lie at the points `own` of it.

    Each corner moves the vertex rigidly with itself; the weights of its point blend.
    """
    corners = coarse.faces[own.faces]
    weights = own.barycentric
    turns = deformation.turns[corners]
    arms = vertices[:, None, :] - coarse.vertices[corners]
    moved = deformation.positions[corners] + np.einsum("nkij,nkj->nki", turns, arms)
    rotations = np.einsum("nk,nkij->nij", weights, deformation.rotations[corners])
    return Deformation(
        np.einsum("nk,nki->ni", weights, moved),
        closest_rotations(rotations),
        np.einsum("nk,nk->n", weights, deformation.sizes[corners]),
    )


def fine_deformation(
    elasticity: Elasticity, start: Deformation, targets: Targets, scan: ScanSurface
) -> Deformation:
    """The shape itself, near `start`, drawn to the surface of the pieces."""
    now = start
    for _ in range(FINE_ROUNDS):
        now = _onto_surface(elasticity, now, targets, scan)
    return now


def corners_of(elasticity: Elasticity, faces: Bools | Ints) -> Bools:
    """The vertices (n,) of some of the faces, a mask (m,) or numbers."""
    marked = np.zeros(len(elasticity.rest), dtype=bool)
    marked[elasticity.mesh.faces[faces].ravel()] = True
    return marked


def with_rings(elasticity: Elasticity, marked: Bools, rings: int) -> Bools:
    """Marked vertices (n,) and so many rings of edges around them."""
    around = elasticity.springs.astype(bool).astype(np.float64)
    for _ in range(rings):
        marked = marked | (np.asarray(around @ marked.astype(np.float64)) > 0)
    return marked


def without_data(elasticity: Elasticity, found: Deformation, released: Bools) -> Deformation:
    """The same, but what is `released` (n,) continues from around: nothing holds it any more."""
    held = (~released).astype(np.float64)
    lengths = np.full(len(held), elasticity.mesh.mean_edge_length)
    before = found.rotations.reshape(-1, 9)
    smooth = closest_rotations(
        elasticity.smoothing(held, lengths)(before, before).reshape(-1, 3, 3)
    )
    rotations = np.where(released[:, None, None], smooth, found.rotations)
    step = replace(found, rotations=rotations)
    return _relaxed(elasticity, step, elasticity.areas * held / HOLD_LENGTH**2, found.positions)


def _rigid(elasticity: Elasticity, targets: Targets) -> Deformation:
    """The whole moved as one body: what nothing is known about stays so."""
    rest, weights = elasticity.rest, elasticity.areas * targets.confidence
    rotation = closest_rotation(rest, targets.positions, weights)
    before = np.average(rest, axis=0, weights=weights)
    after = np.average(targets.positions, axis=0, weights=weights)
    count = len(rest)
    return Deformation(
        (rest - before) @ rotation.T + after, np.tile(rotation, (count, 1, 1)), np.ones(count)
    )


def _rotation_smoothing(elasticity: Elasticity, seen: Bools) -> Smoothing:
    """Smooths rotations that the edges around each vertex (n,) tell, best where it is seen."""
    beyond = np.minimum(distances_beyond(elasticity.mesh, seen), LARGEST_LENGTH)
    certainty = FAR_CERTAINTY + (1 - FAR_CERTAINTY) * np.exp(-beyond / NEAR_CUT)
    return elasticity.smoothing(certainty, np.minimum(SEEN_LENGTH + beyond, LARGEST_LENGTH))


def _smooth_rotations(
    elasticity: Elasticity, positions: Floats, before: Floats, smoothing: Smoothing
) -> Floats:
    fitted = elasticity.fitted_rotations(positions)
    smooth = smoothing(fitted.reshape(-1, 9), before.reshape(-1, 9))
    return closest_rotations(smooth.reshape(-1, 3, 3))


def _relaxed(
    elasticity: Elasticity, now: Deformation, pulls: Floats, positions: Floats
) -> Deformation:
    relaxed = elasticity.relaxation(pulls)(now.turns, positions, now.positions)
    return replace(now, positions=relaxed)


def _inliers(positions: Floats, targets: Floats) -> Floats:
    """Weights (n,) of Geman and McClure: near 1 for noise, near 0 for what is wrong."""
    off = ((positions - targets) ** 2).sum(axis=1)
    weights: Floats = 1.0 / (1.0 + off / MAP_LIMIT**2) ** 2
    return weights


def _onto_surface(
    elasticity: Elasticity, now: Deformation, targets: Targets, scan: ScanSurface
) -> Deformation:
    """One step toward the closest points of the pieces; where there are none, toward the map."""
    pulls, places = _drawn(elasticity, now, targets, scan)
    return _relaxed(elasticity, now, pulls, places)


def _drawn(
    elasticity: Elasticity, now: Deformation, targets: Targets, scan: ScanSurface
) -> tuple[Floats, Floats]:
    """How firmly (n,) each vertex is drawn to which place (n, 3)."""
    inliers = _inliers(now.positions, targets.positions)
    off = (inliers * targets.seen)[:, None] * (targets.positions - now.positions)
    normals = vertex_normals(now.positions, elasticity.mesh.faces)
    points, found = scan.closest(now.positions + TOWARD_MAP * off, normals)
    found &= targets.seen
    firm = targets.confidence * inliers / MAP_LENGTH**2
    pulls: Floats = elasticity.areas * np.where(found, 1.0 / SURFACE_LENGTH**2, firm)
    feet = points.positions(scan.mesh)
    return pulls, np.where(found[:, None], feet, targets.positions)
