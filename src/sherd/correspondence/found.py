"""What was found of one part, as it is sought from further starts: each counts if it fits better.

Labels settle in one place. From where they begin again, elsewhere or by relief, the part is laid
once more, and the better score is the answer; the best of the others that lies elsewhere is kept.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sherd.correspondence.elsewhere import LabeledElsewhere, are_apart
from sherd.correspondence.labels.labeling import Labeling
from sherd.correspondence.placements import second_placement
from sherd.correspondence.plausibility import placement_chance, placement_features
from sherd.correspondence.working_placement import (
    Queries,
    WorkingPlacement,
    placement_from_look,
    seen_by_labeling,
)
from sherd.results.advice import FOREIGN, SURE

__all__ = ["Found", "beside_elsewhere", "beside_relief", "found_of_two"]

# Arms of stars that are all alike, meshed anew and bent, differ by 0.02 but for one in 24 (0.04).
# Of 37 pieces of animals and people whose other place scored less by up to this much 11 lay in the
# wrong one, of 30 with 0.03 to 0.05 two.
RIVAL_MARGIN = 0.03


@dataclass(frozen=True, eq=False)
class Found:
    """The placements of one part, of which an answer is made.

    Attributes
    ----------
    best, other
        The better and the worse of two placements in one place, as far as both agree.
    rival
        The best placement found where most of the part lies elsewhere; None if there is none that
        may be as good.
    energies
        Of the first and the last labeling, and what they would be if nothing belonged together; of
        a part that was seen from one side those of what its viewer saw.
    """

    best: WorkingPlacement
    other: WorkingPlacement
    rival: WorkingPlacement | None
    energies: tuple[float, float, float]

    @property
    def chance(self) -> float:
        """That the best placement as a whole is right, in [0, 1]."""
        first, last, by_chance = self.energies
        surface = self.best.question.part
        return placement_chance(
            placement_features(
                surface, self.best, self.other, (first, last), chance_energy=by_chance
            )
        )

    @property
    def equal_rival(self) -> WorkingPlacement | None:
        """The placement in another place, if the part fits there about as well."""
        rival = self.rival
        near = rival is not None and rival.score > self.best.score - RIVAL_MARGIN
        return rival if near else None

    @property
    def doubtful(self) -> bool:
        """Whether the part may belong here, and it is not sure where."""
        chance = self.chance
        return chance >= FOREIGN and (chance < SURE or self.equal_rival is not None)


def found_of_two(
    one: WorkingPlacement, two: WorkingPlacement, energies: tuple[float, float, float]
) -> Found:
    """Two placements in one place, as nothing is known of others."""
    best, other = sorted((one, two), key=_worse_last)
    return Found(best, other, None, energies)


def beside_elsewhere(
    found: Found, elsewhere: LabeledElsewhere, queries: Queries, rng: np.random.Generator
) -> Found:
    """The better of what was found and of where the part lies elsewhere, if it may fit there.

    A place is laid a second time if it is the better one, as it is then believed.
    """
    question, (start, _, by_chance) = found.best.question, found.energies
    places = [found.other]
    if elsewhere.is_as_cheap(start, by_chance):
        labeling = elsewhere.finished()
        laid, look = seen_by_labeling(question, labeling, queries)
        first = placement_from_look(question, laid, look)
        places.append(first)
        if first.score > found.best.score and are_apart(first, found.best):
            second = second_placement(question, look, queries, rng)
            places += [found.best, second]
            found = found_of_two(first, second, (elsewhere.energy, labeling.energy, by_chance))
    return _with_rival(found, places)


def beside_relief(
    found: Found, labeling: Labeling, queries: Queries, rng: np.random.Generator
) -> Found:
    """The better of what was found and of where a labeling by relief leads.

    The energy of the first labeling stays, which says how well the part suits wherever it lies, and
    in one and the same place that of the last one as well.
    """
    question, (start, _, by_chance) = found.best.question, found.energies
    laid, look = seen_by_labeling(question, labeling, queries)
    led = found_of_two(
        placement_from_look(question, laid, look),
        second_placement(question, look, queries, rng),
        found.energies,
    )
    if are_apart(led.best, found.best):
        led = replace(led, energies=(start, labeling.energy, by_chance))
    places = [led.best, found.best] + ([] if found.rival is None else [found.rival])
    return _with_rival(led if led.best.score > found.best.score else found, places)


def _with_rival(found: Found, places: Sequence[WorkingPlacement]) -> Found:
    """The same with the best of the places where most of the part lies elsewhere."""
    apart = [place for place in places if are_apart(place, found.best)]
    rival = max(apart, key=lambda place: place.score, default=None)
    return replace(found, rival=rival)


def _worse_last(placement: WorkingPlacement) -> float:
    return -placement.score
