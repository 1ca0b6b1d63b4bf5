"""Further places of one incomplete shape on another, by what no labeling asks for: their form.

Of two species wrong places save as much as right ones, and what saves most of many places is hardly
ever the right one: a front leg on a hind leg keeps the whole flank beside it, a right shoulder some
nodes. Small groups that look like a place lie right somewhere among the first fifty, and after one
round their form is more alike than that of nearly all others. So many groups grow, and those go on
whose form is most alike, not those that save most.
"""

from __future__ import annotations

from functools import partial

from sherd.arrays import Floats
from sherd.correspondence.labels.labeling import LIMIT, Labeling, Problem
from sherd.correspondence.labels.local_groups import local_groups
from sherd.correspondence.labels.places import is_known
from sherd.correspondence.labels.saved import saved
from sherd.correspondence.labels.two_way import (
    Agreed,
    Both,
    TwoLabelings,
    all_agreed,
    described,
    elsewhere,
    finished,
    labeled_around,
    led,
    only_placed,
)
from sherd.correspondence.shared.relief_correlation import alike_at_labels

__all__ = ["finished_place", "labelings_by_form"]

# Groups of either direction. Where half of SMAL was not sure, the first right group of a pair that
# came out wrong was the 5th to 37th of the better direction.
GROUPS = 48
# Of these starts so many are labeled, the most alike in form at once: a group is some twenty nodes,
# which say little of form, but a round for each start was two thirds of all work here. Of ten pairs
# of SMAL with a right start that grows, the last one whose start grew came 33rd of 96.
BEGUN = 40
# Different places that go on. On the same pairs a right place was among the first 4 after a round
# in each pair that had one, and among the first 3 after the last. A round of 16 between changed
# nothing in three pairs.
LEFT = (8, 5)


def labelings_by_form(
    problems: Both[Problem], forms: Both[Floats], known: TwoLabelings
) -> list[TwoLabelings]:
    """Labelings of both directions at different places, the most alike in form first; five at most.

    They still grow, see :func:`finished_place`. None lies where the known one does: to ask there
    again until the answer pleases proves nothing.

    Parameters
    ----------
    problems
        Without a price: the nodes of each are those of the other's labels' shape.
    forms
        (n,) and (m,), of the vertices of the second shape and of the first, see
        :func:`sherd.descriptors.relief.form`.
    known
        The labeling of both that saves most.
    """
    chance = known.chance
    again = partial(all_agreed, problems, chance, inside=LIMIT, labeled=labeled_around)
    groups = [
        local_groups(problem, energy, GROUPS)
        for problem, energy in zip(problems, chance, strict=True)
    ]

    def alike(each: Agreed) -> tuple[float, float]:
        # where no form says anything, swapping the shapes must still swap what is chosen
        return alike_at_labels(forms, problems, each.found, each.agrees), each.saved

    def alike_already(start: Both[Labeling]) -> tuple[float, float]:
        kept = (start[0].placed, start[1].placed)
        return alike_at_labels(forms, problems, start, kept), saved(problems, start, chance)

    starts = sorted(led(problems, *groups), key=alike_already, reverse=True)[:BEGUN]
    tried = again(starts)
    for left in LEFT:
        tried = elsewhere(problems, sorted(tried, key=alike, reverse=True))[:left]
        grown = again([each.found for each in tried])
        tried = [max(pair, key=alike) for pair in zip(tried, grown, strict=True)]
    return [
        described(problems, chance, each, known.first_ratio)
        for each in elsewhere(problems, sorted(tried, key=alike, reverse=True))
        if not is_known(problems, each, known)
    ]


def finished_place(problems: Both[Problem], begun: TwoLabelings) -> TwoLabelings:
    """Labelings of both directions as all rounds make them; the same ones if these save no more."""
    found, agrees = (begun.forward, begun.backward), (begun.forward_agrees, begun.backward_agrees)
    kept = (only_placed(found[0], agrees[0]), only_placed(found[1], agrees[1]))
    agreed = Agreed(found, agrees, begun.agreement, saved(problems, kept, begun.chance))
    last = finished(problems, begun.chance, agreed)
    return begun if last is agreed else described(problems, begun.chance, last, begun.first_ratio)
