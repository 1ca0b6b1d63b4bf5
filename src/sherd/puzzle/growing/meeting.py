"""What two pieces share, or two unions of pieces, and the chance that they belong together.

As :func:`sherd.overlap` finds it, but for the chance, which asks for one thing more: where both are
cut from one whole, what they share ends where one of both does.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sherd.arrays import Ints
from sherd.correspondence.labels.two_way import Both
from sherd.correspondence.question import NO_PINS, Question
from sherd.correspondence.shared.two_way_placement import SharedPlacement, placed_together
from sherd.correspondence.working_placement import Queries
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.overlap import (
    STRETCH,
    labeled_both_ways,
    prepare_both_ways,
    queries_both_ways,
    questions_of,
)
from sherd.puzzle.growing.join_chance import join_chance, join_features
from sherd.results.overlap_options import OverlapOptions
from sherd.surface.prepared import described_part
from sherd.threads import one_blas_thread

__all__ = ["Meeting", "meeting"]

NOTHING_KNOWN = np.empty((0, 2), dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Meeting:
    """What two surfaces share.

    Attributes
    ----------
    questions
        The second on the first, and the first on the second.
    queries, placements
        Of both.
    chance
        That what they share is found rightly, and they belong together.
    """

    questions: Both[Question]
    queries: Both[Queries]
    placements: Both[SharedPlacement]
    chance: float


@one_blas_thread()
def meeting(
    first: TriangleMesh, second: TriangleMesh, seed: int, known: Ints = NOTHING_KNOWN
) -> Meeting:
    """Ask what two surfaces share, in units of sqrt(area) of the larger one.

    Parameters
    ----------
    first, second
        Without what needs repair, in one unit of length.
    seed
        Of all random choices.
    known
        (p, 2) vertices of the first and the second that lie on each other. They rule labels out;
        places are found without them.
    """
    unit = max(first.length, second.length)
    surfaces = (
        described_part(first, unit, sampled_at=known[:, 0]),
        described_part(second, unit, sampled_at=known[:, 1]),
    )
    for surface in surfaces:
        prepare_both_ways(surface)
    there, back = questions_of(surfaces, known, unknown=False)
    questions = (there.with_stretch(STRETCH), back.with_stretch(STRETCH))
    labelings = labeled_both_ways(questions, seed)
    questions = (replace(questions[0], pins=NO_PINS), replace(questions[1], pins=NO_PINS))
    queries = queries_both_ways(questions, seed)
    placements = placed_together(questions, labelings, queries, strain=OverlapOptions().strain)
    features = join_features(labelings, questions, placements, seed)
    return Meeting(questions, queries, placements, join_chance(features))
