"""A rigid piece drawn to the full shape from where it was laid, and how well it fits there.

Closest points are found and the motion is fitted to them, as in Besl and McKay, *A method for
registration of 3-D shapes*, 1992, by planes (Chen and Medioni, *Object modelling by registration of
multiple range images*, 1992), so that convergence is quadratic where a piece fits exactly. What is
farther off than the tolerance is worn, and counts less and less.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from sherd.arrays import Bools, Floats
from sherd.mesh.surface_finder import SurfaceFinder
from sherd.mesh.topology import adjacency
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.puzzle.rigid.motion import RigidMotion
from sherd.surface.described import DescribedSurface

__all__ = [
    "FEW_ROUNDS",
    "Probe",
    "SurfaceFit",
    "drawn_to_surface",
    "drawn_to_vertices",
    "fit_of",
    "lying_on",
    "roughness",
]

# Quadratic convergence needs five or six; a worn piece with sliding contact takes more, and what
# does not fit slides on for ever.
ROUNDS, FEW_ROUNDS = 60, 12
# Steps below this are rounding, in sqrt(area) and radians; a piece that fits exactly gets there by
# quadratic convergence. Others slide on the noise of their meshes for dozens of rounds: steps below
# what is exact that are no longer a tenth of the last one gain nothing.
ROUNDING, STILL = 1e-14, 0.1
# Keeps the system definite where a piece can slide on itself, as a sphere does.
DAMPING = 1e-9
# What is farther off counts less, in turn, in sqrt(area), but not what is within half of the
# tolerance: votes are off by a label or two, whatever is worn.
LIMITS, ROUNDS_EACH = (0.06, 0.03, 0.015, 0.0075), 6
# At last what is off by more than this, in units of the tolerance, counts less: rims of fractures
# are within the tolerance, and turn a sherd by half a degree.
LAST_LIMIT = 1 / 8
# A surface lies on another one where normals agree to 60 degrees: a face of fracture does not.
LOOKS_ALIKE = 0.5
# In sqrt(area): no scan is exact to this, and coordinates in single precision are not.
EXACT = 1e-5


@dataclass(frozen=True, eq=False)
class SurfaceFit:
    """How a piece fits where a motion brings it.

    Attributes
    ----------
    motion
        From the part's frame to that of the full shape.
    share
        Of the piece's area that lies on the full shape: within the tolerance, and looking its way.
    distance
        Geometric mean, by area, of how far it is off, in sqrt(area); what does not lie there
        counts as off by the tolerance. So a surface that is the same stands out from one that is
        near, though a part of the piece is fracture, which fits nowhere.
    """

    motion: RigidMotion
    share: float
    distance: float


@dataclass(frozen=True, eq=False)
class Probe:
    """Points of a piece that say where it lies.

    Attributes
    ----------
    points, normals
        (p, 3) in the part's frame, in sqrt(area of the full shape).
    areas
        (p,) what each stands for.
    """

    points: Floats
    normals: Floats
    areas: Floats

    @classmethod
    def of(cls, mesh: TriangleMesh, count: int, rng: np.random.Generator) -> Probe:
        """`count` vertices of a mesh, drawn at random, or all if it has no more."""
        chosen = mesh.used_vertices
        if len(chosen) > count:
            chosen = np.sort(rng.choice(chosen, count, replace=False))
        return cls(mesh.vertices[chosen], mesh.vertex_normals[chosen], mesh.vertex_areas[chosen])


def drawn_to_vertices(
    motion: RigidMotion, probe: Probe, full: DescribedSurface, tolerance: float
) -> RigidMotion:
    """The motion by the planes of the nearest vertices of the full shape: near enough to judge it.

    Parameters
    ----------
    full
        The full shape, whose unit of length is that of `tolerance`.
    """
    planes, places = full.mesh.vertex_normals, full.mesh.vertices
    for limit in LIMITS:
        for _ in range(ROUNDS_EACH):
            here = motion(probe.points)
            distance, nearest = full.vertex_tree.query(here)
            plane = planes[nearest]
            same = np.einsum("ij,ij->i", probe.normals @ motion.rotation.T, plane) > LOOKS_ALIKE
            weights = same / (1 + (distance / max(limit, 0.5 * tolerance)) ** 2) ** 2
            motion = _stepped(motion, here, places[nearest], plane, weights)[0]
    return motion


def drawn_to_surface(
    motion: RigidMotion,
    probe: Probe,
    finder: SurfaceFinder,
    tolerance: float,
    *,
    rounds: int = ROUNDS,
) -> RigidMotion:
    """The motion by closest points, until it stands still or for so many rounds, twice."""
    for limit in (1.0, LAST_LIMIT):
        motion = _standing_still(motion, probe, finder, limit * tolerance, rounds)
    return motion


def _standing_still(
    motion: RigidMotion, probe: Probe, finder: SurfaceFinder, limit: float, rounds: int
) -> RigidMotion:
    """The motion by closest points, those that are farther off than the limit counting less."""
    full, last = finder.mesh, np.inf
    for _ in range(rounds):
        here, normals = motion(probe.points), probe.normals @ motion.rotation.T
        points = finder.closest(here, normals)
        foot, plane = points.positions(full), full.face_normals[points.faces]
        distance = np.linalg.norm(here - foot, axis=1)
        same = np.einsum("ij,ij->i", normals, plane) > LOOKS_ALIKE
        weights = probe.areas * same / (1 + (distance / limit) ** 2) ** 2
        motion, step = _stepped(motion, here, foot, plane, weights)
        if step < ROUNDING or STILL * last < step < EXACT:
            break
        last = step
    return motion


def fit_of(
    motion: RigidMotion, probe: Probe, finder: SurfaceFinder, tolerance: float
) -> SurfaceFit:
    """How well a piece fits where the motion brings it."""
    here, normals = motion(probe.points), probe.normals @ motion.rotation.T
    points = finder.closest(here, normals)
    feet, planes = points.positions(finder.mesh), finder.mesh.face_normals[points.faces]
    off, lies = lying_on(feet, planes, here, normals, tolerance)
    counted = np.where(lies, np.maximum(off, EXACT), tolerance)
    return SurfaceFit(
        motion,
        float(probe.areas @ lies / probe.areas.sum()),
        float(np.exp(np.average(np.log(counted), weights=probe.areas))),
    )


def lying_on(
    feet: Floats, planes: Floats, here: Floats, normals: Floats, tolerance: float
) -> tuple[Floats, Bools]:
    """How far (p,) positions are from their points on a shape, and which of them lie there.

    That is within the tolerance, and looking as it does.

    Parameters
    ----------
    feet, planes
        (p, 3) the points on the shape, and its outward normals there.
    here, normals
        (p, 3) the positions, and outward normals of what lies there.
    tolerance
        In their unit.
    """
    off = np.linalg.norm(here - feet, axis=1)
    alike = np.einsum("ij,ij->i", normals, planes) > LOOKS_ALIKE
    return off, alike & (off <= tolerance)


def roughness(mesh: TriangleMesh) -> float:
    """What the same surface, meshed anew, may be off by: a geometric mean, in the mesh's unit.

    How far a vertex is from the middle of its neighbors, along the normal, by area. That is half
    the squared edge times the curvature, of which a point amid a face has a third, and noise as it
    is.
    """
    near = adjacency(mesh.faces, mesh.vertex_count)
    count = np.maximum(np.asarray(near.sum(axis=1)).ravel(), 1.0)
    middle = (near @ mesh.vertices) / count[:, None]
    off = np.abs(np.einsum("ij,ij->i", mesh.vertices - middle, mesh.vertex_normals))
    areas = np.array(mesh.vertex_areas)
    areas[mesh.boundary_vertices] = 0.0  # there the middle is off, however flat the surface is
    return float(np.exp(np.average(np.log(np.maximum(off, EXACT)), weights=areas + 1e-300)))


def _stepped(
    motion: RigidMotion, here: Floats, foot: Floats, plane: Floats, weights: Floats
) -> tuple[RigidMotion, float]:
    """One step toward the planes through points (p, 3), and its largest entry."""
    lever = np.concatenate([np.cross(here, plane), plane], axis=1)
    system = lever.T @ (weights[:, None] * lever)
    system += (DAMPING * np.trace(system) + 1e-300) * np.eye(6)
    step = -np.linalg.solve(system, lever.T @ (weights * ((here - foot) * plane).sum(axis=1)))
    turn = Rotation.from_rotvec(step[:3]).as_matrix()
    return RigidMotion(turn, step[3:]).after(motion), float(np.abs(step).max())
