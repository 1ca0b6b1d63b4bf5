"""Identification: which of several full shapes a part belongs to, or none."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from sherd._version import __version__
from sherd.arrays import FrozenState
from sherd.errors import InputError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.display import table_html
from sherd.results.many.identify_options import IdentifyOptions
from sherd.results.match_result import MatchResult
from sherd.results.status import Status

__all__ = ["CLOSE_RATIO", "CandidateAnswer", "Identification", "identification_of"]

# Scores that differ by less may come out in the other order on another meshing of the part.
EQUAL_SCORE = 0.02
# A second shape whose ratio is larger by more is not matched if the first is good. Of 35 parts
# among eleven shapes 34 had their own first, and one, of a cat, another cat, better by 0.04.
CLOSE_RATIO = 0.08
# A shape that was not matched fits as well if its ratio is hardly larger, and is likely as such. In
# these 35 cases shapes of other kinds were behind by 0.15 and more, half of those of the same kind
# (cats, people) by less.
KIND_RATIO, FITS = 0.13, 0.5
NAMED = 4
ORDER = {Status.GOOD: 0, Status.DOUBTFUL: 1, Status.FOREIGN: 2}


@dataclass(frozen=True, eq=False, repr=False)
class CandidateAnswer(FrozenState):
    """What was found out about one full shape.

    Attributes
    ----------
    name
        Of the full shape.
    evidence
        The chance in [0, 1] that the part belongs there, by cheap evidence: comparable between
        shapes, but less sure than that of a match.
    ratio
        What it is made of: cost of the best labeling over the cost by chance; 1 if refused.
    refused
        Why the shape is out of the question; empty if it is not.
    match
        The part matched with this shape; None if it was not asked, as others were likelier.

    Examples
    --------
    >>> CandidateAnswer("cat.ply", evidence=0.97, ratio=0.3)
    CandidateAnswer('cat.ply': evidence 0.97, not matched)
    """

    name: str
    evidence: float
    ratio: float
    refused: str = ""
    match: MatchResult | None = None

    def __repr__(self) -> str:
        return f"CandidateAnswer({self.name!r}: evidence {self.evidence:.2f}, {self.said})"

    @property
    def said(self) -> str:
        """What came out, in a few words."""
        if self.refused:
            return "impossible by its size"
        if self.match is None:
            return "not matched"
        chance = "" if self.match.chance is None else f", chance {self.match.chance:.2f}"
        return f"{self.match.status.name.lower()}{chance}, score {self.match.best.score:.3f}"


@dataclass(frozen=True, eq=False, repr=False)
class Identification(FrozenState):
    """The answer of :func:`sherd.identify`.

    Attributes
    ----------
    part
        As given.
    candidates
        All full shapes, the likeliest first: matched ones by status and score, then the others by
        evidence.
    status
        Good: the part belongs to the first. Doubtful: the first is the likeliest. Foreign: it
        belongs to none of them.
    advice
        The status in words, with names.
    options, version, timings
        As given, of sherd, and seconds by stage.

    Examples
    --------
    >>> tiny = TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], name="part.ply")
    >>> refused = CandidateAnswer("cat.ply", 0.0, 1.0, refused="too small")
    >>> identification_of(tiny, [refused], IdentifyOptions(), {})
    Identification('part.ply': foreign; cat.ply)
    """

    part: TriangleMesh
    candidates: tuple[CandidateAnswer, ...]
    status: Status
    advice: str
    options: IdentifyOptions
    timings: Mapping[str, float] = field(default_factory=dict)
    version: str = field(default=__version__)

    def __post_init__(self) -> None:
        if not self.candidates:
            raise InputError("an identification needs a full shape at least")

    def __repr__(self) -> str:
        names = ", ".join(each.name for each in self.candidates[:NAMED])
        return f"Identification({self.part.name!r}: {self.status.name.lower()}; {names})"

    def _repr_html_(self) -> str:
        rows = {"status": self.advice}
        rows |= {
            each.name: f"evidence {each.evidence:.2f}, {each.said}" for each in self.candidates
        }
        return table_html(f"Which shape is {self.part.name} of?", rows)

    @property
    def best(self) -> CandidateAnswer | None:
        """The full shape that the part belongs to, surely or likely; None if to none."""
        return None if self.status is Status.FOREIGN else self.candidates[0]

    @property
    def match(self) -> MatchResult | None:
        """The part on that shape; None if it belongs to none."""
        return None if self.best is None else self.best.match

    @property
    def also(self) -> tuple[CandidateAnswer, ...]:
        """Other full shapes that the part fits as well, such as individuals of one kind."""
        return _also(self.candidates)


def identification_of(
    part: TriangleMesh,
    answers: Sequence[CandidateAnswer],
    options: IdentifyOptions,
    timings: Mapping[str, float],
) -> Identification:
    """Rank the answers and say what to think of the first."""
    ranked = sorted(answers, key=_rank)
    status, advice = _verdict(ranked)
    return Identification(part, tuple(ranked), status, advice, options, timings)


def _rank(answer: CandidateAnswer) -> tuple[int, float]:
    if answer.match is None:
        return (4 if answer.refused else 3, answer.ratio)
    return ORDER[answer.match.status], -answer.match.best.score


def _verdict(ranked: Sequence[CandidateAnswer]) -> tuple[Status, str]:
    first = ranked[0]
    if first.match is None or first.match.status is Status.FOREIGN:
        return Status.FOREIGN, _said_of_none(ranked)
    others = _also(ranked)
    also = f"; it also fits {_names(others)}" if others else ""
    if first.match.status is Status.DOUBTFUL:
        words = f"doubtful: likeliest {first.name}, but there it is {first.match.advice}"
        return Status.DOUBTFUL, words + also
    equal = [
        each
        for each in others
        if each.match is not None and each.match.best.score > first.match.best.score - EQUAL_SCORE
    ]
    if equal:
        return Status.DOUBTFUL, (
            f"doubtful: fits {_names([first, *equal])} about equally well; look at both, or ask "
            "with a larger part"
        )
    return Status.GOOD, f"good: belongs to {first.name}{also}"


def _also(ranked: Sequence[CandidateAnswer]) -> tuple[CandidateAnswer, ...]:
    """Shapes after the first that fit: good matches and, not matched, those hardly behind it."""
    most = ranked[0].ratio + KIND_RATIO
    return tuple(
        each
        for each in ranked[1:]
        if (each.evidence >= FITS and each.ratio <= most and not each.refused)
        if each.match is None or each.match.status is Status.GOOD
    )


def _said_of_none(ranked: Sequence[CandidateAnswer]) -> str:
    refused = [each for each in ranked if each.refused]
    said = "does not belong to any of the full shapes: "
    if len(refused) == len(ranked):
        first = refused[0]
        return (
            f"{said}all are out of the question by size ({first.name}: {first.refused}); check "
            "the units, or give the scale"
        )
    asked = [each for each in ranked if each.match is not None]
    return (
        f"{said}on the likeliest, {_names(asked)}, it is no more alike than chance; ask with other "
        "shapes, or check the scale"
    )


def _names(answers: Sequence[CandidateAnswer]) -> str:
    names = [each.name for each in answers[:NAMED]]
    more = f" and {len(answers) - NAMED} more" if len(answers) > NAMED else ""
    return (", ".join(names) if len(names) > 2 or more else " and ".join(names)) + more
