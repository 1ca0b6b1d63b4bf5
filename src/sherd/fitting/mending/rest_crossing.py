"""What pierces itself in the full shape already, as lips and toes of models do, moved as one piece.

Two layers that lie in each other there do so in the fit as well, but where they pierce moves with
the noise of the map: other faces pierce each other than before. Nothing can be pushed apart there,
as it would have to be in the full shape first. Moved as a rigid body the very same faces pierce.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sherd.arrays import Bools, Ints
from sherd.fitting.as_rigid_as_possible import Elasticity
from sherd.fitting.deformation import Deformation, corners_of, with_rings
from sherd.fitting.mending.patch import Patch
from sherd.mesh.geometry import closest_rotation
from sherd.mesh.topology import component_labels

__all__ = ["rest_crossings", "with_rest_crossings"]

# Rings of edges around a rigid piece that follow it, so that it has no seam. Noise of the map
# moves such a piece by half an edge, which strains eight rings by a sixteenth.
FOLLOWING = 8
# Places of a map are good to 0.005 to 0.01, in sqrt(area). What is farther from a rigid motion on
# average, as a hand whose fingers touch, has bent and is no body.
MOST_BENT = 0.005
# The following rings turn with their positions: rounds until that has settled.
ROUNDS = 3
# How firmly what does not follow stays, in sqrt(area) as a data term: as if it could not move.
FIXED_LENGTH = 1e-4


def rest_crossings(elasticity: Elasticity, pairs: Ints) -> list[Ints]:
    """The vertices of each place where `pairs` (k, 2) of faces pierce each other.

    Faces that pierce each other, and those that have a corner in common, are of one place.
    """
    faces = elasticity.mesh.faces
    if not len(pairs):
        return []
    crossing = np.unique(pairs)
    # a triangle of a corner of either face ties the two, whichever corners these are
    ties = np.concatenate([faces[crossing], faces[pairs, 0][:, [0, 1, 1]]])
    labels = component_labels(ties, len(elasticity.rest))
    used = np.unique(faces[crossing])
    return [used[labels[used] == label] for label in np.unique(labels[used])]


def with_rest_crossings(
    elasticity: Elasticity, found: Deformation, places: list[Ints], crossing: Ints, rings: int
) -> Deformation:
    """The same, but places that pierced themselves before, and did not bend, move as rigid bodies.

    Parameters
    ----------
    elasticity
        Of the full shape.
    found
        The deformation.
    places
        As of :func:`rest_crossings`.
    crossing
        Numbers of the faces that pierce others in `found` and did not before: places near none of
        them stay as they are.
    rings
        So many rings of edges around each place are of its body.
    """
    at_fault = corners_of(elasticity, crossing)
    bodies = np.zeros(len(elasticity.rest), dtype=bool)
    positions, rotations = found.positions.copy(), found.rotations.copy()
    for place in places:
        body = np.zeros(len(bodies), dtype=bool)
        body[place] = True
        body = with_rings(elasticity, body, rings)
        if not (body & at_fault).any():
            continue
        weights, rest = elasticity.areas[body], elasticity.rest[body]
        rotation = closest_rotation(rest, found.positions[body], weights)
        size = np.average(found.sizes[body], weights=weights)
        before = np.average(rest, axis=0, weights=weights)
        after = np.average(found.positions[body], axis=0, weights=weights)
        moved = size * (rest - before) @ rotation.T + after
        off = ((moved - found.positions[body]) ** 2).sum(axis=1)
        if np.average(off, weights=weights) > MOST_BENT**2:
            continue
        positions[body] = moved
        rotations[body] = rotation
        bodies |= body
    if not bodies.any():
        return found
    rigid = replace(found, positions=positions, rotations=rotations)
    return _followed(elasticity, rigid, with_rings(elasticity, bodies, FOLLOWING) & ~bodies)


def _followed(elasticity: Elasticity, moved: Deformation, free: Bools) -> Deformation:
    """What is `free` (n,) follows what is around it, which stays."""
    patch = Patch(elasticity, moved, free)
    local, now, own = patch.elasticity, patch.start, patch.free
    relaxed = local.relaxation(local.areas * ~own / FIXED_LENGTH**2)
    for _ in range(ROUNDS):
        places = relaxed(now.turns, now.positions, now.positions)
        places = np.where(own[:, None], places, now.positions)
        turned = local.fitted_rotations(places)
        turned = np.where(own[:, None, None], turned, now.rotations)
        now = replace(now, positions=places, rotations=turned)
    return patch.put_back(moved, now)
