"""What both viewers saw: views of one camera, labeled by what faces either camera.

The border of a view runs along every limb, so no neighborhood is complete and none is cut the same
way in two views. But a view shows nothing that looks away from its viewer, wherever it lies: where
one shape is laid on the other, its viewer can be carried there, and what looks away from that
viewer is not shared.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sherd.arrays import Bools
from sherd.correspondence.labels.labeling import Problem, labeling_problem
from sherd.correspondence.labels.two_way import Both
from sherd.correspondence.placements import node_similarity
from sherd.correspondence.question import Question
from sherd.correspondence.shared.two_way_placement import SharedPlacement
from sherd.correspondence.working_placement import facing_viewer
from sherd.descriptors.rotation_shot import trusted_equally
from sherd.surface.described import RADII
from sherd.threads import side_by_side

__all__ = ["are_views", "viewed_problems"]

# Cosine below which skin looks away from a viewer: another pose turns what was seen edge on by some
# degrees.
LOOKS_AWAY = -0.1


def are_views(questions: Both[Question]) -> bool:
    """Whether any of both shapes was seen from one side."""
    return any(question.part.viewer is not None for question in questions)


def viewed_problems(
    questions: Both[Question], placements: Both[SharedPlacement], seed: int
) -> Both[Problem]:
    """What is to be labeled in both directions where each viewer sees the other shape too.

    Parameters
    ----------
    questions
        The second shape on the first, and the first on the second.
    placements
        Of both; they say where the viewers stand.
    seed
        Of all random choices.
    """
    on_first, on_second = (
        _seen_by_other(question, place)
        for question, place in zip(questions, placements, strict=True)
    )
    there, back = questions
    found = side_by_side(
        [
            lambda: _problem_within(there, on_second, on_first, seed),
            lambda: _problem_within(back, on_first, on_second, seed),
        ]
    )
    return (found[0], found[1])


def _seen_by_other(question: Question, place: SharedPlacement) -> Bools:
    """The vertices (n,) of the full shape of a question that do not look away from the viewer."""
    full, part = question.full, question.part
    if part.viewer is None:
        return np.ones(full.mesh.vertex_count, dtype=bool)
    shared = part.mesh.vertex_areas * place.shared
    return facing_viewer(question, part.viewer, place.deformation, shared, least=LOOKS_AWAY)


def _problem_within(question: Question, on_part: Bools, on_full: Bools, seed: int) -> Problem:
    """Both shapes see only what both viewers saw, and only that is placed."""
    full, part = question.full, question.part
    nodes = part.sparse.vertices
    spectra = trusted_equally(part.spectra_at_within(nodes, on_part), RADII)
    similarity = node_similarity(question, spectra, inside=full.spectra_within(on_full))
    problem = labeling_problem(question, similarity, np.random.default_rng(seed))
    unseen = ~on_part[nodes][:, None] | ~on_full[problem.labels.vertices][None, :]
    return replace(problem, forbidden=problem.forbidden | unseen)
