"""Which of several full shapes a part belongs to: all are asked, and the best answer is taken."""

from __future__ import annotations

from collections.abc import Sequence

from sherd.batching.templates import FullShape, loaded_template
from sherd.errors import InfeasibleError
from sherd.match import match
from sherd.results.match_options import MatchOptions
from sherd.results.match_result import MatchResult
from sherd.results.status import Status
from sherd.scan.intake import Intake

__all__ = ["best_match"]

RANKS = {Status.FOREIGN: 0, Status.DOUBTFUL: 1, Status.GOOD: 2}


def best_match(
    fulls: Sequence[FullShape], part: Intake, options: MatchOptions
) -> tuple[FullShape, MatchResult]:
    """The full shape that the part fits best, and the match with it.

    The status decides, then the chance, then the score. A full shape that the part is too large or
    too small for is passed over.

    Raises
    ------
    InfeasibleError
        If the part fits none by its size.
    OptionError
        If a landmark or ignored vertex does not exist.
    """
    found: list[tuple[FullShape, MatchResult]] = []
    refused: list[InfeasibleError] = []
    for full in fulls:
        try:
            found.append((full, match(loaded_template(full), part, options)))
        except InfeasibleError as error:
            refused.append(error)
    if not found:
        raise refused[0]
    return max(found, key=lambda pair: _merit(pair[1]))


def _merit(result: MatchResult) -> tuple[int, float, float]:
    return RANKS[result.status], result.chance or 0.0, result.best.score or 0.0
