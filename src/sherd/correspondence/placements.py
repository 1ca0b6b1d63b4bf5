"""The stages of matching, each a function on frozen objects.

:mod:`sherd.match` calls them in order and reads as the summary of the method.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from sherd.arrays import Floats, Singles
from sherd.correspondence.labels.anchors import (
    chance_energy,
    find_anchors,
    first_labeling,
    proposed_anchors,
)
from sherd.correspondence.labels.labeling import (
    SIMILARITY_STEP,
    Labeling,
    Problem,
    labeling_problem,
)
from sherd.correspondence.question import Question
from sherd.correspondence.similar_places import Look
from sherd.correspondence.working_placement import (
    Queries,
    WorkingPlacement,
    look_from,
    mirrored_queries,
    placement_from_labeling,
    rough_placement_from_labeling,
)
from sherd.descriptors.rotation_shot import pooled_similarity, trusted_equally
from sherd.surface.described import RADII
from sherd.surface.transformed import mirrored
from sherd.threads import side_by_side

__all__ = [
    "ViewedPlacement",
    "anchor_problem",
    "mirrored_placement",
    "node_similarity",
    "second_placement",
    "viewed_placement",
]

# Once the region is known, neighborhoods agree better, and lack of similarity says more.
SECOND_STEP = 0.5 * SIMILARITY_STEP
SECOND_ROUNDS = 2
TWIN_ROUNDS = 2
# A limb that is turned about itself turns the mean of all directions a little, and a labeling may
# still take one wrongly: with three seeds each, a horse and a man of which one camera saw half end
# with errors of 1.7 to 1.8 hundredths after four rounds, and of 1.7 to 5.4 after two.
VIEWED_ROUNDS = 4


@dataclass(frozen=True, eq=False)
class ViewedPlacement:
    """A placement that knows what the part's viewer saw of the full shape.

    Attributes
    ----------
    placement
        The best of several.
    energies
        Of the first and of the last labeling of what was seen, and what they would be if nothing
        belonged together.
    """

    placement: WorkingPlacement
    energies: tuple[float, float, float]


def anchor_problem(question: Question, rng: np.random.Generator) -> Problem:
    """What is to be labeled: each node of the part, by a label of the full shape and a rotation.

    By similarity of neighborhoods, which count less near the cut, and by consistency of lengths and
    directions.
    """
    part = question.part
    similarity = node_similarity(question, part.trusted_spectra(part.sparse.vertices))
    return labeling_problem(question, similarity, rng)


def second_placement(
    question: Question, look: Look, queries: Queries, rng: np.random.Generator
) -> WorkingPlacement:
    """A placement from anchors that see of the full shape what the first placement's `look` saw.

    That is the region of the first one: there both shapes have the same cut, so neighborhoods are
    complete.
    """
    problem = _problem_within(question, look, _node_spectra(question), rng)
    labeling = _second_labeling(problem)
    return placement_from_labeling(question, labeling, queries)


def viewed_placement(
    question: Question,
    viewer: Floats,
    found: WorkingPlacement,
    queries: Queries,
    rng: np.random.Generator,
) -> ViewedPlacement:
    """A placement of a part that was seen from one side, from the direction `viewer` (3,).

    Its cut runs along all limbs, so that no neighborhood is complete, and the region of a placement
    that turns a limb about itself confirms it. But what faces away from the viewer was not seen,
    wherever the part lies: anchors see of the full shape what faces that way where the part
    was `found`. They are labeled as strictly as for a second placement and as for a first one, and
    the better of all placements is the answer.
    """
    rounds, spectra = [], _node_spectra(question)
    for _ in range(VIEWED_ROUNDS):
        look = look_from(question, viewer, found.deformation, queries)
        problem = _problem_within(question, look, spectra, rng)
        first = first_labeling(problem)
        last = find_anchors(problem, start=first)
        laid = side_by_side(
            partial(placement_from_labeling, question, labeling, queries)
            for labeling in (last, _second_labeling(problem))
        )
        found = max(laid, key=_score)
        rounds.append(found)
    best = max(rounds, key=_score)
    return ViewedPlacement(best, (first.energy, last.energy, chance_energy(problem, rng)))


def _node_spectra(question: Question) -> Singles:
    """Of the nodes, where neighborhoods are complete."""
    return trusted_equally(question.part.spectra_at(question.part.sparse.vertices), RADII)


def _problem_within(
    question: Question, look: Look, node_spectra: Singles, rng: np.random.Generator
) -> Problem:
    """What is to be labeled where both shapes have the same cut."""
    similarity = node_similarity(question, node_spectra, inside=look.full_spectra)
    return labeling_problem(question, similarity, rng)


def _second_labeling(problem: Problem) -> Labeling:
    return find_anchors(problem, step=SECOND_STEP, rounds=SECOND_ROUNDS)


def _score(placement: WorkingPlacement) -> float:
    return placement.score


def mirrored_placement(
    question: Question, queries: Queries, rng: np.random.Generator
) -> WorkingPlacement:
    """The best placement of the part's mirror image, as the left leg for the right."""
    image = question.with_part(mirrored(question.part))
    problem = anchor_problem(image, rng)
    # what growth would mend is not needed to judge it
    labeling = proposed_anchors(problem, first_labeling(problem), rounds=TWIN_ROUNDS)
    return rough_placement_from_labeling(image, labeling, mirrored_queries(queries))


def node_similarity(
    question: Question, node_spectra: Singles, *, inside: Singles | None = None
) -> Singles:
    """Similarity (k, s, r) of each node with the vertices of each label's cell, by rotation.

    `node_spectra` are not projected yet. `inside` are spectra of the full shape as seen within a
    region; all of it is seen if None.
    """
    full = question.full
    spectra = full.spectra if inside is None else inside
    projected = full.axes.project(node_spectra)
    return pooled_similarity(spectra, projected, full.dense.cells, len(full.dense))
