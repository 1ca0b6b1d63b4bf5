"""What two surfaces share by one labeling of both, and how likely it is right."""

from __future__ import annotations

from dataclasses import dataclass

from sherd.correspondence.labels.two_way import Both
from sherd.correspondence.question import Question
from sherd.correspondence.shared.two_way_placement import SharedPlacement
from sherd.correspondence.working_placement import Queries

__all__ = ["JOINED", "Meeting"]

# What is so likely is joined. More than is called good of a piece on its whole: what is joined is
# asked again as one, and a wrong piece draws others after it (a cat's leg on a horse that lacks it,
# and then the horse's own). That leg has 0.76, and so has an arm within another person's; of what
# is right 0.79 is the least that no larger union had to make surer (a half of the generated animal
# within the other one); of all right answers to nine puzzles above 0.65 two are below.
JOINED = 0.78


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
