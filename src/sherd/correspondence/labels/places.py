"""Further places of one shape on another, besides the one where most is saved.

What saves most is not always right: half of a body laid on a sixth that is shared may save more
than that sixth. Who has other evidence, of the surfaces themselves, can choose among several.
"""

from __future__ import annotations

from sherd.correspondence.labels.consistent import same_place
from sherd.correspondence.labels.labeling import LIMIT, Problem
from sherd.correspondence.labels.local_groups import local_groups
from sherd.correspondence.labels.two_way import (
    Agreed,
    TwoLabelings,
    all_agreed,
    described,
    finished,
    grown_apart,
    labeled_around,
    led,
)

__all__ = ["further_labelings"]

# Groups of either direction. Of 12 pairs of pieces of a wolf that share 0.12 and more of the
# smaller one eight had a right group among so many, the last of these the 21st; of 32 one more.
GROUPS = 24
# Different places that go on; of those eight seven right ones were among the last four.
LEFT = (16, 8, 4)


def further_labelings(
    forward: Problem, backward: Problem, known: TwoLabelings
) -> list[TwoLabelings]:
    """Labelings of both directions at different places, what saves most first; four at most.

    None lies where the known one does: to ask there again until the answer pleases proves nothing.
    Two thirds of another person, laid on a woman, had a chance of 0.61 and at the same place 0.65.

    Parameters
    ----------
    forward, backward
        Problems without a price: the nodes of each are those of the other's labels' shape.
    known
        The labeling of both that saves most.
    """
    problems, chance = (forward, backward), known.chance
    groups = [
        local_groups(problem, energy, GROUPS)
        for problem, energy in zip(problems, chance, strict=True)
    ]
    starts = led(problems, *groups)
    tried = all_agreed(problems, chance, starts, inside=LIMIT, labeled=labeled_around)
    places = [
        finished(problems, chance, each)
        for each in grown_apart(problems, chance, tried, LEFT)[: LEFT[-1]]
    ]
    return [
        described(problems, chance, each, known.first_ratio)
        for each in places
        if not _is_known(problems, each, known)
    ]


def _is_known(problems: tuple[Problem, Problem], each: Agreed, known: TwoLabelings) -> bool:
    found = (each.found, (known.forward, known.backward))
    kept = (each.agrees, (known.forward_agrees, known.backward_agrees))
    return same_place(problems, found, kept)
