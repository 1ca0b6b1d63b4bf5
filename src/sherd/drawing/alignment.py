"""How to turn the part on the page, so that both shapes are seen from the same side."""

from __future__ import annotations

from functools import partial

import numpy as np
from scipy.spatial import cKDTree

from sherd.arrays import Floats
from sherd.drawing.exhibit import Exhibit
from sherd.mesh.geometry import closest_rotation
from sherd.threads import side_by_side

__all__ = ["rotation_to_full"]


SAMPLE_SIZE = 400
# Rotations are compared after this many rounds of closest points; ten more change a view little.
ROUNDS = 8
# Fewer matched points than this do not fix a rotation.
LEAST_MATCHES = 12


def rotation_to_full(exhibit: Exhibit) -> Floats:
    """Proper rotation (3, 3) that turns part vertices toward their place on the full shape.

    With a map it is the rotation closest to it; without one, the region and the part are laid
    over each other by closest points, from the file's own orientation and the 24 ways to exchange
    principal axes. It serves looking only: nothing is computed from it.

    References
    ----------
    Kabsch, *A solution for the best rotation to relate two sets of vectors*, 1976.
    Besl, McKay, *A method for registration of 3-D shapes*, 1992.
    """
    part, full, partner = exhibit.part, exhibit.full, exhibit.partner
    if partner is not None and partner.known.sum() >= LEAST_MATCHES:
        known = partner.known
        targets = partner.points.positions(full)[known]
        return closest_rotation(part.vertices[known], targets, part.vertex_areas[known])
    region = np.asarray(exhibit.region)
    if region.sum() < LEAST_MATCHES:
        return np.eye(3)
    return _closest_rotation(_spread(part.vertices), _spread(full.vertices[region]))


def _closest_rotation(source: Floats, target: Floats) -> Floats:
    source = source - source.mean(axis=0)
    target = target - target.mean(axis=0)
    tree = cKDTree(target)
    source_axes = _principal_axes(source)
    target_axes = _principal_axes(target)
    starts = [np.eye(3), *(target_axes.T @ turn @ source_axes for turn in _axis_turns())]
    found = side_by_side(partial(_improved, start, source, target, tree) for start in starts)
    errors = np.array([error for _, error in found])
    errors[0] *= 0.8  # files usually agree on what is up: leave them so unless clearly wrong
    return found[int(errors.argmin())][0]


def _improved(
    rotation: Floats, source: Floats, target: Floats, tree: cKDTree
) -> tuple[Floats, float]:
    """The rotation after some rounds of closest points, and the squared distances it leaves."""
    for _ in range(ROUNDS):
        _, nearest = tree.query(source @ rotation.T)
        rotation = closest_rotation(source, target[nearest], np.ones(len(source)))
    turned = source @ rotation.T
    forward, backward = tree.query(turned)[0], cKDTree(turned).query(target)[0]
    return rotation, float(np.mean(np.square(forward)) + np.mean(np.square(backward)))


def _principal_axes(points: Floats) -> Floats:
    """Rows: directions by descending spread, right-handed."""
    axes = np.linalg.svd(points, full_matrices=False)[2]
    axes[2] *= np.sign(np.linalg.det(axes))
    return axes


def _axis_turns() -> list[Floats]:
    """All 24 rotations that map coordinate axes to coordinate axes."""
    turns = []
    for order in ((0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)):
        for first in (1.0, -1.0):
            for second in (1.0, -1.0):
                turn = np.zeros((3, 3))
                turn[np.arange(3), order] = (first, second, 1.0)
                turn[2] *= np.linalg.det(turn)
                turns.append(turn)
    return turns


def _spread(points: Floats) -> Floats:
    return points[np.linspace(0, len(points) - 1, min(SAMPLE_SIZE, len(points))).astype(np.int64)]
