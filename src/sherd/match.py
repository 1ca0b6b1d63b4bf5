"""match(full, part): where the part belongs, and which point is which."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TypeVar, Unpack

import numpy as np

from sherd.arrays import Bools, Floats
from sherd.correspondence.confidence import (
    LEAST,
    confidence_features,
    confidences,
    foreign_vertices,
    lies_elsewhere,
    matched_vertices,
    share_laid_double,
)
from sherd.correspondence.plausibility import (
    FEATURELESS,
    self_likeness,
)
from sherd.correspondence.question import Question
from sherd.correspondence.unfollowed import unfollowed_landmarks
from sherd.correspondence.working_placement import (
    Queries,
    WorkingPlacement,
)
from sherd.mesh.sides import bulge
from sherd.mesh.units import unit_proposal
from sherd.output import Stages
from sherd.place import VIEWED_MARGIN, PlacedPart, placed_part
from sherd.region.coverage import covered_region
from sherd.results.advice import Doubts
from sherd.results.keywords import options_of
from sherd.results.match_options import MatchKeywords, MatchOptions
from sherd.results.match_result import MatchResult
from sherd.results.placement import Placement
from sherd.results.status import Status
from sherd.results.way_back import WayBack
from sherd.scan.either_side import SURE_BULGE, better_side
from sherd.scan.intake import Intake, MeshSource, ScanSource, scan_intake
from sherd.scan.numbering import original_normals, turned_as_repaired
from sherd.surface.described import DescribedSurface
from sherd.surface.prepared import as_template
from sherd.surface.template import Template
from sherd.threads import begun, one_blas_thread

__all__ = ["STAGES", "PlacedPart", "match", "match_one_side", "match_result", "placed_part"]

Number = TypeVar("Number", float, Floats)

STAGES = (
    "full shape", "part", "scale", "anchors", "first placement", "second placement",
    "elsewhere", "relief", "mirrored twin", "confidence", "region",
)  # fmt: skip

# A twin whose score is this close to the best could be the right one without its handedness.
PLAUSIBLE = 0.1
# Repeated runs on remeshed copies of one pair differ by about as much: a twin that is better by
# more explains the part better than the answer does.
TWIN_MARGIN = 0.02
# When answers are promised to be near for fewer than half of the vertices, another shape would do.
POOR = 0.5
# No place can be used twice; up to this share of the part it may be noise.
DOUBLE = 0.2
# Turned over, parts of animals and people scored at most 0.43 where the right side had 0.5 to 0.95.
SURE_SCORE = 0.6


def match(
    full: MeshSource | Template,
    part: ScanSource,
    options: MatchOptions | None = None,
    *,
    stages: Stages | None = None,
    **keywords: Unpack[MatchKeywords],
) -> MatchResult:
    """Find for every vertex of the part its point on the full shape.

    Parameters
    ----------
    full
        The full shape: a mesh, the path of a file, a pair (vertices, faces), a
        ``trimesh.Trimesh``, or a :class:`sherd.Template` when many parts are to be matched.
    part
        The part: deformed, incomplete, in any position and vertex order; points will do.
    options
        See :class:`MatchOptions`; the defaults if None.
    stages
        Collects timings and shows progress; a silent one if None.
    keywords
        The fields of :class:`MatchOptions`, instead of `options`.

    Returns
    -------
    MatchResult
        Numbered as `full` and `part` are, whatever was repaired; ``result.check()`` proves it.

    Raises
    ------
    OptionError
        If a landmark or ignored vertex does not exist, a keyword is unknown, or both `options` and
        keywords are given.
    InfeasibleError
        If the part is larger than the full shape or a dot on it, or everything is ignored.
    MeshFileError, InvalidMeshError, InputError
        If a shape cannot be read or is no mesh.

    Examples
    --------
    >>> from sherd.shapes import creature, cut_by_ball, whole
    >>> full = creature(5000)
    >>> part = cut_by_ball(whole(creature(5000, pose="walk"), full), 0, 0.5).mesh
    >>> match(full, part).check().passed
    True
    """
    options = options_of(MatchOptions, options, keywords)
    stages = stages or Stages(visible=False)
    template = as_template(full)
    return better_side(
        scan_intake(part),
        options.side,
        lambda side: match_one_side(template, side, options, stages),
        score=lambda result: result.best.score,
        sure=_sure_of_side,
    )


def match_one_side(
    template: Template, part: Intake, options: MatchOptions, stages: Stages
) -> MatchResult:
    """Match a part whose faces look outward: the method; see :func:`match`."""
    with one_blas_thread():  # sums over 10,000 vertices would depend on how many there are
        return match_result(placed_part(template, part, options, stages), stages)


def match_result(placed: PlacedPart, stages: Stages) -> MatchResult:
    """The answer for a placed part: confidence, region and what to think of it."""
    return judged_result(placed, placed.chance, stages)


def judged_result(placed: PlacedPart, chance: float, stages: Stages) -> MatchResult:
    """The answer for a placed part whose place is right with this chance, whatever says so."""
    template, part, options = placed.template, placed.part, placed.options
    question, best, twin = placed.question, placed.best, placed.twin
    surface, rival = question.part, placed.equal_rival
    way_back = WayBack(template.intake, part, placed.kept)
    alternatives = begun(lambda: _alternatives(way_back, best, placed.rival, twin))
    points = begun(lambda: best.points)
    with stages("confidence"):
        trust = _trust(question, placed.queries, best, placed.other, rival)
    with stages("region"):
        membership, mask = _region(question, best, trust.matched)
    result = MatchResult(
        full=template.full,
        part=turned_as_repaired(part),
        best=way_back.placement(
            points(),
            mask,
            membership,
            score=best.score,
            matched=trust.matched,
            confidence=trust.confidence,
        ),
        alternatives=alternatives(),
        scale=placed.scale,
        second_score=placed.other.score,
        twin_score=None if twin is None else twin.score,
        status=Status.GOOD,
        timings=MappingProxyType(dict(stages.seconds)),
        options=options,
        working_vertices=MappingProxyType(
            {"full": template.mesh.vertex_count, "part": surface.mesh.vertex_count}
        ),
        notices=MappingProxyType({"full": template.intake.notices, "part": part.notices}),
        chance=chance if rival is None else _chance_of_either(chance),
    )
    original_normals(template.intake)  # known now, the check need not repair the full shape again
    unknown = options.scale == "unknown"
    doubts = Doubts(
        chance=chance,
        featureless=self_likeness(surface) > FEATURELESS,
        elsewhere=rival is not None,
        twin=twin is not None and twin.score > best.score + _twin_margin(surface),
        unchecked=result.check().failures,
        unlike=_fits_poorly(trust),
        doubled=_too_much(share_laid_double(surface, best.deformation)),
        scale_unknown=unknown,
        scale_bound=placed.scale if placed.estimate.at_bound else None,
        scale_rival=_scale_rival(placed),
        unfollowed=unfollowed_landmarks(question, placed.pins, best.points),
        units=_unit_proposal(template, part, options),
    )
    return replace(
        result,
        status=doubts.status,
        advice=doubts.advice,
        unfollowed_landmarks=doubts.unfollowed,
    )


def _chance_of_either(chance: Number) -> Number:
    """The chance of one of two places that fit as well, as one at most is right: o / (1 + 2 o).

    With odds o = p / (1 - p) of each against lying nowhere.
    """
    return chance / (1.0 + chance)


def _twin_margin(part: DescribedSurface) -> float:
    """By how much a twin must be better to say that the answer is its mirror image.

    The twin of what one camera saw was placed without knowing what the viewer could not see, and
    what does not know that may be right with a lower score.
    """
    return TWIN_MARGIN if part.viewer is None else -VIEWED_MARGIN


def _scale_rival(placed: PlacedPart) -> float | None:
    rival = placed.estimate.rival
    return None if rival is None else placed.options.factor * rival


@dataclass(frozen=True, eq=False)
class _Trust:
    """Which vertices (n',) of the kept part have a place, and how sure each answer is."""

    matched: Bools
    confidence: Floats


def _trust(
    question: Question,
    queries: Queries,
    best: WorkingPlacement,
    other: WorkingPlacement,
    rival: WorkingPlacement | None,
) -> _Trust:
    features = confidence_features(question.part, queries, best, other)
    foreign = foreign_vertices(question.part, queries, best)
    confidence = confidences(features)
    if rival is not None:
        far = lies_elsewhere(question.part, best, rival)
        confidence = np.where(far, _chance_of_either(confidence), confidence)
    confidence = np.where(foreign, LEAST, confidence)
    return _Trust(matched_vertices(features) & ~foreign, confidence)


def _region(question: Question, best: WorkingPlacement, matched: Bools) -> tuple[Floats, Bools]:
    """Membership and mask of what the matched part covers."""
    full, part = question.full.placed, question.part.placed
    # its area is that in the pose of the full shape; the part may be some percent smaller
    share = float(part.vertex_areas @ matched) / part.area
    return covered_region(full, best.mask, share * float(full.vertex_areas @ best.mask))


def _fits_poorly(trust: _Trust) -> bool:
    sure = float(trust.confidence[trust.matched].mean()) if trust.matched.any() else 0.0
    return not sure > POOR


def _too_much(double: float) -> float:
    """The share of a part that is laid double; 0 where it may be noise."""
    return double if double >= DOUBLE else 0.0


def _unit_proposal(template: Template, part: Intake, options: MatchOptions) -> str:
    """Units that would explain the sizes, unless the user has said how they compare."""
    if options.scale != "same" or options.part_unit is not None:
        return ""
    return unit_proposal(part.mesh.length / template.length)


def _alternatives(
    way_back: WayBack,
    best: WorkingPlacement,
    rival: WorkingPlacement | None,
    twin: WorkingPlacement | None,
) -> tuple[Placement, ...]:
    """Another place and the mirrored twin, if their scores are near the best; the better first."""
    others = [
        (other, mirrored)
        for other, mirrored in ((rival, False), (twin, True))
        if other is not None and other.score >= best.score - PLAUSIBLE
    ]
    return tuple(
        way_back.placement(
            other.points,
            other.mask,
            other.mask.astype(np.float64),
            score=other.score,
            mirrored=mirrored,
        )
        for other, mirrored in sorted(others, key=lambda each: -each[0].score)
    )


def _sure_of_side(part: Intake, result: MatchResult) -> bool:
    """Whether the answer need not be tried on the other side."""
    if part.side_known:  # the faces may still be turned over all together, if there is a border
        return result.status is Status.GOOD or len(part.mesh.boundary_vertices) == 0
    return result.best.score >= SURE_SCORE and bulge(part.mesh) >= SURE_BULGE
