"""RigidMotion: a rotation and a shift."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sherd.arrays import Floats
from sherd.mesh.geometry import closest_rotation

__all__ = ["RigidMotion", "best_motion", "extent"]


@dataclass(frozen=True, eq=False)
class RigidMotion:
    """A rotation (3, 3) and a shift (3,), `y = rotation x + shift`."""

    rotation: Floats
    shift: Floats

    def __call__(self, points: Floats) -> Floats:
        """Points (p, 3), moved."""
        moved: Floats = points @ self.rotation.T + self.shift
        return moved

    def after(self, first: RigidMotion) -> RigidMotion:
        """The motion that does `first`, then this."""
        return RigidMotion(self.rotation @ first.rotation, self.rotation @ first.shift + self.shift)

    @property
    def inverse(self) -> RigidMotion:
        """What takes everything back."""
        return RigidMotion(self.rotation.T, -self.shift @ self.rotation)

    @property
    def matrix(self) -> Floats:
        """(4, 4) for homogeneous coordinates."""
        result = np.eye(4)
        result[:3, :3], result[:3, 3] = self.rotation, self.shift
        return result


def best_motion(points: Floats, targets: Floats, weights: Floats | None = None) -> RigidMotion:
    """The motion that brings points (p, 3) nearest to targets (p, 3), in least squares."""
    weights = np.ones(len(points)) if weights is None else weights + 1e-300
    rotation = closest_rotation(points, targets, weights)
    middle, target = (np.average(each, axis=0, weights=weights) for each in (points, targets))
    return RigidMotion(rotation, target - rotation @ middle)


def extent(points: Floats) -> float:
    """How far points (p, 3) are from their middle, as the root of the mean square."""
    return float(np.sqrt(((points - points.mean(axis=0)) ** 2).sum(axis=1).mean()))
