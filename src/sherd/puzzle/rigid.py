"""Rigid pieces: the rotation and translation that bring one onto the full shape.

A placement found for elastic pieces is the start. Then, as in Besl and McKay, *A method for
registration of 3-D shapes*, 1992, closest points are found and the motion is fitted to them, by
planes (Chen and Medioni, *Object modelling by registration of multiple range images*, 1992), so
that convergence is quadratic where a piece fits exactly. What is farther off than the tolerance is
worn, and counts less and less.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sherd.arrays import Floats
from sherd.correspondence.elastic_kernel import fit_rotations
from sherd.correspondence.registration import Deformation
from sherd.correspondence.working_placement import judged_placement, look_inside
from sherd.mesh.geometry import closest_rotation, vertex_normals
from sherd.mesh.surface_points import SurfacePoints
from sherd.place import PlacedPart

__all__ = ["RigidMotion", "rigidly_placed"]

# Points of the elastic placement farther off than this, in sqrt(area), are wrong, not bent: twice
# the error of a bad placement. The limit falls to the tolerance by halves.
FIRST_LIMIT = 0.2
START_ROUNDS = 20
# Quadratic convergence needs five or six; a worn piece with sliding contact takes more.
ROUNDS = 60
# Steps below this are rounding, in sqrt(area) and radians.
ROUNDING = 1e-14
# Keeps the system definite where a piece can slide on itself, as a sphere does.
DAMPING = 1e-9


@dataclass(frozen=True, eq=False)
class RigidMotion:
    """A rotation (3, 3) and a shift (3,), `y = rotation x + shift`, in the unit of the files."""

    rotation: Floats
    shift: Floats

    def __call__(self, points: Floats) -> Floats:
        """Points (p, 3), moved."""
        moved: Floats = points @ self.rotation.T + self.shift
        return moved

    @property
    def matrix(self) -> Floats:
        """(4, 4) for homogeneous coordinates."""
        result = np.eye(4)
        result[:3, :3], result[:3, 3] = self.rotation, self.shift
        return result


def rigidly_placed(placed: PlacedPart, tolerance: float) -> tuple[PlacedPart, RigidMotion, float]:
    """The placement made rigid, the motion, and the share of the piece's area that is not worn.

    Parameters
    ----------
    placed
        The elastic placement.
    tolerance
        In sqrt(area of the full shape).
    """
    template, question = placed.template, placed.question
    length, scale = template.length, placed.scale
    vertices = scale * placed.part.mesh.vertices[placed.kept]
    areas = question.part.placed.vertex_areas
    normals = placed.part.mesh.vertex_normals[placed.kept]
    start = placed.best.points.positions(template.intake.mesh)
    motion = _fitted(vertices, start, areas, FIRST_LIMIT * length, tolerance * length)
    to_full = _between(template.intake.mesh.vertices, template.placed.vertices, length)
    motion, points, off = _refined(motion, vertices, normals, areas, to_full, placed, tolerance)
    # the working mesh follows: its frame is that of the piece, turned and divided by a length
    own = _between(vertices, question.part.placed.vertices, length)
    turn = to_full.rotation @ motion.rotation @ own.rotation.T
    middle = vertices.mean(axis=0)
    shift = to_full(motion(middle[None]) / length) - own(middle[None] / length) @ turn.T
    positions = question.part.mesh.vertices @ turn.T + shift
    deformation = Deformation(positions, fit_rotations(question.part.elastic, positions))
    look = look_inside(question, deformation, placed.queries)
    best = replace(judged_placement(question, deformation, look), known_points=points)
    share = float(areas @ (off <= tolerance) / areas.sum())
    # where it lies as well it was bent, which scores higher
    return replace(placed, best=best, rival=None), motion, share


def _fitted(
    vertices: Floats, targets: Floats, areas: Floats, first: float, least: float
) -> RigidMotion:
    """The motion nearest to a placement, in the unit of the files; what is far off loses weight."""
    weights, reach = areas.copy(), first
    motion = RigidMotion(np.eye(3), np.zeros(3))
    for _ in range(START_ROUNDS):
        rotation = closest_rotation(vertices, targets, weights)
        means = [np.average(each, axis=0, weights=weights) for each in (vertices, targets)]
        motion = RigidMotion(rotation, means[1] - rotation @ means[0])
        off = np.linalg.norm(motion(vertices) - targets, axis=1)
        weights = areas / (1 + (off / reach) ** 2) ** 2
        reach = max(0.5 * reach, least)
    return motion


def _between(before: Floats, after: Floats, length: float) -> RigidMotion:
    """The motion that takes points, divided by a length, to the same in another frame."""
    small = before / length
    rotation = closest_rotation(small, after, np.ones(len(small)))
    return RigidMotion(rotation, after.mean(axis=0) - rotation @ small.mean(axis=0))


def _refined(
    motion: RigidMotion,
    vertices: Floats,
    normals: Floats,
    areas: Floats,
    to_full: RigidMotion,
    placed: PlacedPart,
    tolerance: float,
) -> tuple[RigidMotion, SurfacePoints, Floats]:
    """The motion by closest points, these points, and how far they are off (n,), in sqrt(area)."""
    template = placed.template
    length, mesh = template.length, template.placed
    for _ in range(ROUNDS):
        here = to_full(motion(vertices) / length)
        outward = normals @ (to_full.rotation @ motion.rotation).T
        points = template.own_finder.closest(here, outward)
        foot, plane = points.positions(mesh), mesh.face_normals[points.faces]
        away = here - foot
        distance = np.linalg.norm(away, axis=1)
        weights = areas / (1 + (distance / tolerance) ** 2) ** 2
        lever = np.concatenate([np.cross(here, plane), plane], axis=1)
        system = lever.T @ (weights[:, None] * lever)
        system += DAMPING * np.trace(system) * np.eye(6)
        step = -np.linalg.solve(system, lever.T @ (weights * (away * plane).sum(axis=1)))
        turn = _rotation(step[:3])
        # the step is about the full shape's origin, in its frame: carried back to the files'
        rotation = to_full.rotation.T @ turn @ to_full.rotation @ motion.rotation
        center = vertices.mean(axis=0)
        moved = to_full(motion(center[None]) / length) @ turn.T + step[3:]
        back = (moved - to_full.shift) @ to_full.rotation * length
        motion = RigidMotion(rotation, back[0] - rotation @ center)
        if np.abs(step).max() < ROUNDING:
            break
    here = to_full(motion(vertices) / length)
    outward = vertex_normals(here, placed.question.part.placed.faces)
    points = template.own_finder.closest(here, outward)
    return motion, points, np.linalg.norm(here - points.positions(mesh), axis=1)


def _rotation(axis: Floats) -> Floats:
    """The rotation (3, 3) about an axis (3,) by its length, in radians (Rodrigues' formula)."""
    angle = float(np.linalg.norm(axis))
    if angle == 0:
        return np.eye(3)
    x, y, z = axis / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    result: Floats = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return result
