"""Which of several full shapes a part of a batch belongs to, by identification."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial

from sherd.batching.templates import FullShape, loaded_template
from sherd.errors import InfeasibleError, MeshFileError, OptionError
from sherd.library.candidate import Candidate
from sherd.library.fitted_scale import at_fitted_scale, match_with_fitted_scale
from sherd.library.folder import Library
from sherd.library.identify import identify_among
from sherd.match import match
from sherd.output import Stages
from sherd.results.many.identify_options import IdentifyOptions
from sherd.results.match_options import MatchOptions
from sherd.results.match_result import MatchResult
from sherd.results.status import Status
from sherd.scan.intake import Intake
from sherd.surface.coarse import coarse_surface

__all__ = ["Chosen", "best_match"]

# What evidence needs of a full shape has 4 MB, a twentieth of its template.
KEPT_CANDIDATES = 64


@dataclass(frozen=True, eq=False)
class Chosen:
    """The full shape that a part fits best, and the match with it.

    Attributes
    ----------
    full, match
        As said.
    doubt
        Why another full shape may be the right one although the match is good; empty if it is not.
    """

    full: FullShape
    match: MatchResult
    doubt: str = ""


def best_match(
    fulls: Sequence[FullShape], part: Intake, options: MatchOptions, *, fit_scale: bool = False
) -> Chosen:
    """The part matched with the full shape that it belongs to; see :func:`sherd.identify`.

    With `fit_scale` matched again with that one, at the size that this answer has.

    Raises
    ------
    InfeasibleError
        If the part fits none by its size.
    OptionError
        If a landmark or ignored vertex does not exist, or landmarks are given for several shapes.
    """
    if len(fulls) == 1:
        ask = match_with_fitted_scale if fit_scale else match
        return Chosen(fulls[0], ask(loaded_template(fulls[0]), part, options))
    chosen = _identified(fulls, part, options)
    if not fit_scale:
        return chosen
    template = loaded_template(chosen.full)
    return replace(chosen, match=at_fitted_scale(chosen.match, template, part, options))


def _identified(fulls: Sequence[FullShape], part: Intake, options: MatchOptions) -> Chosen:
    if len(options.landmarks):
        raise OptionError(
            "landmarks name vertices of one full shape; say which one the part belongs to (column "
            "full of the list), or leave them out"
        )
    asked = IdentifyOptions(
        scale=options.scale,
        ignore=options.ignore,
        side=options.side,
        seed=options.seed,
        part_unit=options.part_unit,
        full_unit=options.full_unit,
    )
    known = [_candidate(full) for full in fulls]
    found = identify_among(known, part, asked, Stages(visible=False))
    first = found.candidates[0]
    if first.match is None:
        raise InfeasibleError(found.advice)
    unsure = found.status is Status.DOUBTFUL and first.match.status is Status.GOOD
    full = next(full for full in fulls if full.name == first.name)
    return Chosen(full, first.match, found.advice if unsure else "")


@lru_cache(maxsize=KEPT_CANDIDATES)
def _candidate(full: FullShape) -> Candidate:
    if full.library is not None:  # its labels alone have a file there
        library = Library.open(full.library)
        shelf = next((each for each in library.shelves if each.mesh == full.content), None)
        if shelf is None:
            raise MeshFileError(f"{full.library}: holds {full.name} no longer; start again")
        return replace(library.candidate(shelf), template=partial(loaded_template, full))
    template = loaded_template(full)
    coarse = coarse_surface(template)
    return Candidate(full.name, template.length**2, coarse, partial(loaded_template, full))
