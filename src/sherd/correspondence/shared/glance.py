"""What labels alone say of a place, before anything is laid there.

To lay two shapes on each other takes as long as thirty rounds of labels. But nodes that agree know
nearly all that is asked of an answer: whether their places lead, seeing only what is shared, how
much of the border around them lies inside both shapes, and whether forms are alike. All of it is
coarser, a spacing of nodes instead of one of vertices, so it chooses which places are laid, and
says no more of any.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from sherd.arrays import Bools, Floats
from sherd.correspondence.labels.labeling import Labeling, Problem
from sherd.correspondence.labels.two_way import Both, TwoLabelings
from sherd.correspondence.question import Question
from sherd.correspondence.shared.likeness import Likeness, likeness_inside, mean_likeness
from sherd.correspondence.shared.open_border import is_inside, open_seam_where
from sherd.correspondence.shared.relief_correlation import alike_at_labels
from sherd.threads import side_by_side

__all__ = ["Glance", "glance"]


@dataclass(frozen=True)
class Glance:
    """What the nodes that agree say of the place where they lie.

    Attributes
    ----------
    likeness
        Of what is seen of what lies around them; None where too little agrees to be judged.
    is_open
        How much of the border of that lies inside both shapes, on the shape where it is more.
    form
        How alike forms are at their labels, times the root of the area.
    """

    likeness: Likeness | None
    is_open: float
    form: float


def glance(
    questions: Both[Question],
    problems: Both[Problem],
    labelings: TwoLabelings,
    forms: Both[Floats],
) -> Glance:
    """What labelings of both directions say of the place where they lie.

    What is shared is what is nearest to a node that agrees, as far as labels know.

    Parameters
    ----------
    questions, problems
        The second shape on the first, and the first on the second.
    labelings
        Of both.
    forms
        (n,) and (m,), see :func:`sherd.descriptors.relief.form`.
    """
    found = (labelings.forward, labelings.backward)
    agrees = (labelings.forward_agrees, labelings.backward_agrees)
    around = (_around(questions[0], agrees[0]), _around(questions[1], agrees[1]))
    seen = side_by_side(
        partial(_seen, *each)
        for each in zip(questions, problems, found, around, around[::-1], strict=True)
    )
    is_open = max(_open(*each) for each in zip(questions, problems, found, around, strict=True))
    return Glance(
        mean_likeness(*seen), is_open, form=alike_at_labels(forms, problems, found, agrees)
    )


def _around(question: Question, agrees: Bools) -> Bools:
    """The vertices (n,) of the part that are nearest to a node that agrees."""
    near: Bools = agrees[question.part.sparse.cells]
    return near


def _seen(
    question: Question, problem: Problem, found: Labeling, own: Bools, other: Bools
) -> Likeness | None:
    places = question.full.mesh.vertices[problem.labels.vertices[found.labels]]
    return likeness_inside(question, places[question.part.sparse.cells], own, other)


def _open(question: Question, problem: Problem, found: Labeling, own: Bools) -> float:
    part = question.part
    goes_on = is_inside(problem.label_depth[found.labels])
    return open_seam_where(part.mesh, own, goes_on[part.sparse.cells])
