"""Both shapes laid on each other where one direction was told, and what they share there."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Bools, Floats
from sherd.correspondence.elastic_kernel import fit_rotations
from sherd.correspondence.labels.two_way import Both
from sherd.correspondence.question import Question
from sherd.correspondence.registration import Deformation, registered_to_positions
from sherd.correspondence.shared.two_way_placement import (
    PLACE_ROUNDS,
    SharedPlacement,
    drawn_together,
    looked_closer,
    share_something,
)
from sherd.correspondence.working_placement import Queries
from sherd.mesh.surface_points import closest_points
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["placed_where_told"]

# In edges of the full shape: what is farther from the surface that was laid on it is told nothing.
LAID = 2.0


def placed_where_told(
    questions: Both[Question],
    queries: Both[Queries],
    targets: Floats,
    told: Bools,
    *,
    strain: float,
) -> Both[SharedPlacement]:
    """As :func:`placed_together`, from positions in place of labelings.

    The other direction is told the inverse.

    Parameters
    ----------
    questions, queries, strain
        As in :func:`placed_together`.
    targets
        (n', 3) where the vertices of the second shape's working mesh lie, in the frame of the
        first.
    told
        (n',) bool, of which of them that is known; the others are carried along.
    """
    there, back = questions
    forward = _laid(there, targets, told)
    image = TriangleMesh(forward.positions, there.part.mesh.faces)
    mesh = there.full.mesh
    met = closest_points(image, mesh.vertices)
    off = np.linalg.norm(met.positions(image) - mesh.vertices, axis=1)
    known = (off < LAID * mesh.mean_edge_length) & told[met.nearest_vertices(image)]
    backward = _laid(back, met.interpolate(image, there.part.mesh.vertices), known)
    found = drawn_together(questions, (forward, backward), strain)
    if not share_something(found):
        return found
    return looked_closer(questions, queries, found, strain=strain)


def _laid(question: Question, targets: Floats, told: Bools) -> Deformation:
    start = Deformation(targets, fit_rotations(question.part.elastic, targets))
    present = told.astype(np.float64)
    return registered_to_positions(question, start, targets, rounds=PLACE_ROUNDS, present=present)
