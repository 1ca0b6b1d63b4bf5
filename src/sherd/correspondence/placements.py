"""The stages of matching, each a function on frozen objects.

:mod:`sherd.match` calls them in order and reads as the summary of the method.
"""

from __future__ import annotations

import numpy as np

from sherd.arrays import Singles
from sherd.correspondence.labels.anchors import find_anchors, proposed_anchors
from sherd.correspondence.labels.labeling import SIMILARITY_STEP, Labeling, labeling_problem
from sherd.correspondence.question import Question
from sherd.correspondence.working_placement import (
    Queries,
    WorkingPlacement,
    mirrored_queries,
    placement_from_labeling,
    rough_placement_from_labeling,
)
from sherd.descriptors.rotation_shot import pooled_similarity, trusted_equally
from sherd.surface.described import RADII
from sherd.surface.transformed import mirrored

__all__ = ["anchor_labeling", "mirrored_placement", "node_similarity", "second_placement"]

# Once the region is known, neighborhoods agree better, and lack of similarity says more.
SECOND_STEP = 0.5 * SIMILARITY_STEP
SECOND_ROUNDS = 2
TWIN_ROUNDS = 2


def anchor_labeling(question: Question, rng: np.random.Generator) -> Labeling:
    """A label of the full shape and a rotation for each node of the part, jointly.

    By similarity of neighborhoods, which count less near the cut, and by consistency of lengths and
    directions.
    """
    part = question.part
    similarity = node_similarity(question, part.trusted_spectra(part.sparse.vertices))
    return find_anchors(labeling_problem(question, similarity, rng))


def second_placement(
    question: Question, first: WorkingPlacement, queries: Queries, rng: np.random.Generator
) -> WorkingPlacement:
    """A placement from anchors that see the full shape inside the first one's region.

    There both shapes have the same cut, so neighborhoods are complete.
    """
    spectra = trusted_equally(question.part.spectra_at(question.part.sparse.vertices), RADII)
    similarity = node_similarity(question, spectra, inside=first.inside_spectra)
    problem = labeling_problem(question, similarity, rng)
    labeling = find_anchors(problem, step=SECOND_STEP, rounds=SECOND_ROUNDS)
    return placement_from_labeling(question, labeling, queries)


def mirrored_placement(
    question: Question, queries: Queries, rng: np.random.Generator
) -> WorkingPlacement:
    """The best placement of the part's mirror image, as the left leg for the right."""
    image = question.with_part(mirrored(question.part))
    part = image.part
    similarity = node_similarity(image, part.trusted_spectra(part.sparse.vertices))
    # what growth would mend is not needed to judge it
    labeling = proposed_anchors(labeling_problem(image, similarity, rng), rounds=TWIN_ROUNDS)
    return rough_placement_from_labeling(image, labeling, mirrored_queries(queries))


def node_similarity(
    question: Question, node_spectra: Singles, *, inside: Singles | None = None
) -> Singles:
    """Similarity (k, s, r) of each node with the members of each label's cell, by rotation.

    `node_spectra` are not projected yet. `inside` are spectra of the full shape as seen within a region; all of it is seen if None.
    """
    full = question.full
    members = full.dense.members
    spectra = (full.spectra if inside is None else inside)[:, members]
    return pooled_similarity(
        spectra, full.axes.project(node_spectra), full.dense.cells[members], len(full.dense)
    )
