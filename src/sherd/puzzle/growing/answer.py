"""What two surfaces share by one labeling of both, and how likely it is right."""

from __future__ import annotations

from dataclasses import dataclass

from sherd.correspondence.labels.two_way import Both
from sherd.correspondence.question import Question
from sherd.correspondence.shared.two_way_placement import SharedPlacement
from sherd.correspondence.working_placement import Queries

__all__ = ["Meeting"]


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
    twin
        Whether what they share is laid on its twin, as a left leg on a right one.
    by_skin
        The chance by the skin alone that is shared where it slid to; 0 where nothing slid.
    """

    questions: Both[Question]
    queries: Both[Queries]
    placements: Both[SharedPlacement]
    chance: float
    twin: bool
    by_skin: float = 0.0
