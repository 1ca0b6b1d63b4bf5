"""identify(fulls, part): which of several full shapes the part belongs to, or none."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Unpack

from sherd.errors import InputError
from sherd.library.candidate import Candidate, candidates_of
from sherd.library.evidence import Evidence, gathered_evidence
from sherd.library.folder import Library
from sherd.match import match
from sherd.mesh.sides import bulge
from sherd.output import Stages
from sherd.results.keywords import options_of
from sherd.results.many.identification import (
    CLOSE_RATIO,
    CandidateAnswer,
    Identification,
    identification_of,
)
from sherd.results.many.identify_options import IdentifyKeywords, IdentifyOptions
from sherd.results.match_options import MatchOptions
from sherd.results.match_result import MatchResult
from sherd.results.status import Status
from sherd.scan.intake import Intake, MeshSource, ScanSource, scan_intake
from sherd.surface.template import Template

__all__ = ["STAGES", "FullShapes", "candidates", "identify", "identify_among"]

STAGES = ("full shapes", "evidence", "matches")

FullShapes = Library | str | os.PathLike[str] | Iterable[MeshSource | Template]

# Evidence of the best shape below this: perhaps the part is inside out, so the other side is asked.
SURE_EVIDENCE = 0.5


def identify(
    fulls: FullShapes,
    part: ScanSource,
    options: IdentifyOptions | None = None,
    *,
    stages: Stages | None = None,
    **keywords: Unpack[IdentifyKeywords],
) -> Identification:
    """Find which of several full shapes a part belongs to, and where it lies there.

    Parameters
    ----------
    fulls
        The full shapes: what :func:`sherd.match` takes for one, or templates, or a library: a
        folder that `sherd template` made, as a path or a :class:`sherd.Library`.
    part
        The part, as in :func:`sherd.match`.
    options
        See :class:`IdentifyOptions`; the defaults if None.
    stages
        Collects timings and shows progress; a silent one if None.
    keywords
        The fields of :class:`IdentifyOptions`, instead of `options`.

    Returns
    -------
    Identification
        All full shapes in order, the part matched with the likeliest ones, and what to think of it.

    Raises
    ------
    OptionError
        If a keyword is unknown, or both `options` and keywords are given.
    InputError
        If no full shape is given; otherwise as :func:`sherd.match` does.

    Notes
    -----
    Evidence takes 0.12 CPU seconds for each full shape of a library; then one match, rarely two.

    Examples
    --------
    >>> from sherd.shapes import creature, cut_by_ball, whole
    >>> full = creature(5000)
    >>> part = cut_by_ball(whole(creature(5000, pose="walk"), full), 0, 0.5).mesh
    >>> identify([full], part).status.name
    'GOOD'
    """
    options = options_of(IdentifyOptions, options, keywords)
    stages = stages or Stages(visible=False)
    with stages("full shapes"):
        known = candidates(fulls)
    return identify_among(known, scan_intake(part), options, stages)


def candidates(fulls: FullShapes) -> tuple[Candidate, ...]:
    """What can be asked of the full shapes, made once and asked about many parts.

    Raises
    ------
    InputError
        If there is none, or a library is damaged.
    """
    if isinstance(fulls, str | os.PathLike):
        if not Path(fulls).is_dir():
            raise InputError(f"{fulls}: is no library folder; give several full shapes as a list")
        fulls = Library.open(fulls)
    if not isinstance(fulls, Library):
        return candidates_of(fulls)
    if not fulls.shelves:
        raise InputError(f"{fulls.folder}: the library is empty; add shapes (sherd template)")
    return fulls.candidates()


def identify_among(
    known: Sequence[Candidate], part: Intake, options: IdentifyOptions, stages: Stages
) -> Identification:
    """The answer for one part among candidates that are made once; see :func:`identify`."""
    asked = options.match_options
    with stages("evidence"):
        evidence = _either_side(known, part, asked)
    order = sorted(range(len(known)), key=lambda k: (bool(evidence[k].refused), evidence[k].ratio))
    with stages("matches"):
        found = _matches(known, evidence, order, part, options)
    answers = [
        CandidateAnswer(
            name=each.name,
            evidence=said.chance,
            ratio=said.ratio,
            refused=said.refused,
            match=found.get(number),
        )
        for number, (each, said) in enumerate(zip(known, evidence, strict=True))
    ]
    return identification_of(
        part.original, answers, options, MappingProxyType(dict(stages.seconds))
    )


def _either_side(
    known: Sequence[Candidate], part: Intake, options: MatchOptions
) -> tuple[Evidence, ...]:
    """Evidence for the side of the part that fits some candidate best."""
    first = part
    if options.side == "either" and not part.side_known and bulge(part.mesh) < 0:
        first = part.turned_over()
    found = gathered_evidence(known, first, options)
    if options.side == "given" or _best(found) >= SURE_EVIDENCE:
        return found
    other = gathered_evidence(known, first.turned_over(), options)
    return other if _best(other) > _best(found) else found


def _best(evidence: Sequence[Evidence]) -> float:
    return max(each.chance for each in evidence)


def _matches(
    known: Sequence[Candidate],
    evidence: Sequence[Evidence],
    order: Sequence[int],
    part: Intake,
    options: IdentifyOptions,
) -> dict[int, MatchResult]:
    """The part matched with the likeliest shapes, by number, until one is found beyond doubt."""
    found: dict[int, MatchResult] = {}
    for number in order[: options.matches]:
        if evidence[number].refused:
            break
        ahead = evidence[number].ratio - evidence[order[0]].ratio
        good = any(result.status is Status.GOOD for result in found.values())
        if good and ahead > CLOSE_RATIO:
            break
        found[number] = match(known[number].template(), part, options.match_options)
    return found
