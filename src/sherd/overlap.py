"""overlap(first, second): what two incomplete shapes share, and which point is which."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from types import MappingProxyType
from typing import Unpack

import numpy as np

from sherd.arrays import Ints
from sherd.correspondence.labels.labeling import SAME_SCALE, UNKNOWN_SCALE, Problem
from sherd.correspondence.labels.two_way import Both, TwoLabelings, two_way_labelings
from sherd.correspondence.placements import anchor_problem
from sherd.correspondence.question import Question
from sherd.correspondence.registration import surface_points
from sherd.correspondence.scale import (
    SAME,
    ScaleEstimate,
    estimated_scale,
    factors_about_one,
)
from sherd.correspondence.shared.answer import shared_answer
from sherd.correspondence.shared.hints import (
    KeptShape,
    check_overlap_hints,
    kept_shape,
    landmarks_on,
    pins_on,
)
from sherd.correspondence.shared.judgment import (
    shared_confidence,
    strain_curve,
    unfollowed_pairs,
)
from sherd.correspondence.shared.two_way_placement import SharedPlacement
from sherd.correspondence.working_placement import Queries, part_queries
from sherd.errors import InfeasibleError
from sherd.mesh.sizes import SMALLEST_PART, check_areas
from sherd.output import Stages
from sherd.region.coverage import smoothed
from sherd.results.advice import OverlapDoubts
from sherd.results.keywords import options_of
from sherd.results.overlap_options import OverlapKeywords, OverlapOptions
from sherd.results.overlap_result import Overlap, SharedMap
from sherd.results.status import Status
from sherd.scan.either_side import looking_outward
from sherd.scan.intake import ScanSource, scan_intake
from sherd.surface.described import DescribedSurface
from sherd.surface.prepared import described_part
from sherd.threads import begun, one_blas_thread

__all__ = [
    "HALF",
    "STAGES",
    "check_overlap_sizes",
    "described_pair",
    "labeled_both_ways",
    "overlap",
    "prepare_both_ways",
    "problems_both_ways",
    "queries_both_ways",
    "questions_of",
    "shared_by",
]

STAGES = ("first shape", "second shape", "scale", "labels", "placement", "region")

# A vertex that lies between those of the working mesh is shared if half of it is.
HALF = 0.5
# Lengths of limbs of different animals differ by a fifth and more, those of one animal by a tenth.
# On pairs of cuts of one animal in two poses labels are as good with either.
STRETCH = 0.2


@one_blas_thread()  # or sums over 10,000 vertices would depend on how many there are
def overlap(
    first: ScanSource,
    second: ScanSource,
    options: OverlapOptions | None = None,
    *,
    stages: Stages | None = None,
    **keywords: Unpack[OverlapKeywords],
) -> Overlap:
    """Find what two incomplete shapes share, and for every vertex its point on the other.

    Parameters
    ----------
    first, second
        The shapes: deformed, cut anywhere, in any position and vertex order; whatever
        :func:`sherd.match` takes for a part. Neither needs to be whole, and swapping them swaps the
        answer.
    options
        See :class:`OverlapOptions`; the defaults if None.
    stages
        Collects timings and shows progress; a silent one if None.
    keywords
        The fields of :class:`OverlapOptions`, instead of `options`.

    Returns
    -------
    Overlap
        Numbered as the shapes are, whatever was repaired. That nothing is shared is an answer too:
        its status says so.

    Raises
    ------
    OptionError
        If a landmark or ignored vertex does not exist, a keyword is unknown, or both `options` and
        keywords are given.
    InfeasibleError
        If everything is ignored, or one shape is a dot beside the other.
    MeshFileError, InvalidMeshError, InputError
        If a shape cannot be read or is no mesh.

    Notes
    -----
    Costs 0.7 to 1.6 times what :func:`sherd.match` does, and two to three times as much as that
    does where the first answer is not sure.

    Examples
    --------
    >>> from sherd.shapes import creature, cut_by_ball, whole
    >>> standing, walking = creature(5000), creature(5000, pose="walk")
    >>> front = cut_by_ball(whole(standing, standing), 0, 0.7).mesh
    >>> rear = cut_by_ball(whole(walking, standing), 3000, 0.9).mesh
    >>> answer = overlap(front, rear)
    >>> len(answer.second_to_first.points) == rear.vertex_count
    True
    """
    options = options_of(OverlapOptions, options, keywords)
    stages = stages or Stages(visible=False)
    intakes = (looking_outward(scan_intake(first)), looking_outward(scan_intake(second)))
    check_overlap_hints(*intakes, options)
    shapes = (
        kept_shape(intakes[0], options.ignore_first, name="first"),
        kept_shape(intakes[1], options.ignore_second, name="second"),
    )
    check_overlap_sizes(shapes, options.factor)
    landmarks = landmarks_on(*shapes, options)
    with stages("first shape"):
        surfaces = described_pair(shapes, options.factor, landmarks)
        second_prepared = begun(partial(prepare_both_ways, surfaces[1]))
        prepare_both_ways(surfaces[0])
    with stages("second shape"):
        second_prepared()
    questions = questions_of(surfaces, landmarks, unknown=options.scale == "unknown")
    with stages("scale"):
        estimate = _scale(questions, options)
        scale = options.factor * estimate.factor
        if estimate.factor != 1.0:
            surfaces = described_pair(shapes, scale, landmarks)
            questions = questions_of(surfaces, landmarks, unknown=True)
    return shared_by(shapes, surfaces, questions, options, stages, scale=scale, estimate=estimate)


@one_blas_thread()
def shared_by(
    shapes: Both[KeptShape],
    surfaces: Both[DescribedSurface],
    questions: Both[Question],
    options: OverlapOptions,
    stages: Stages,
    *,
    scale: float = 1.0,
    estimate: ScaleEstimate = SAME,
) -> Overlap:
    """What two described shapes share: the second half of the method; see :func:`overlap`."""
    intakes = (shapes[0].intake, shapes[1].intake)
    landmarks = landmarks_on(*shapes, options)
    questions = (questions[0].with_stretch(STRETCH), questions[1].with_stretch(STRETCH))
    with stages("labels"):
        problems = problems_both_ways(questions, options.seed)
        labelings = labeled_both_ways(problems, options.seed)
    with stages("placement"):
        queries = queries_both_ways(questions, options.seed)
        answer = shared_answer(
            questions, problems, labelings, queries, strain=options.strain, seed=options.seed
        )
    with stages("region"):
        maps = tuple(
            _shared_map(shapes[side], shapes[1 - side], questions[side], queries[side], place)
            for side, place in enumerate(answer.placements)
        )
        curve = strain_curve(questions, answer.placements)
    result = Overlap(
        first=intakes[0].original,
        second=intakes[1].original,
        second_to_first=maps[0],
        first_to_second=maps[1],
        scale=scale,
        status=Status.GOOD,
        chance=answer.chance,
        curve=curve,
        timings=MappingProxyType(dict(stages.seconds)),
        options=options,
        working_vertices=MappingProxyType(
            {"first": surfaces[0].mesh.vertex_count, "second": surfaces[1].mesh.vertex_count}
        ),
        notices=MappingProxyType({"first": intakes[0].notices, "second": intakes[1].notices}),
    )
    doubts = OverlapDoubts(
        chance=answer.chance,
        shared=all(bool(each.matched.any()) for each in maps),
        checked=result.check().passed,
        twin=answer.twin,
        scale_bound=scale if estimate.at_bound else None,
        scale_rival=None if estimate.rival is None else options.factor * estimate.rival,
        unfollowed=unfollowed_pairs(
            landmarks[:, 2:], intakes[0].original, maps[0].points, _unit(shapes, scale)
        ),
    )
    return replace(
        result,
        status=doubts.status,
        advice=doubts.advice,
        unfollowed_landmarks=doubts.unfollowed,
    )


def check_overlap_sizes(shapes: Both[KeptShape], factor: float) -> None:
    """Refuse shapes without area and pairs of which one is a dot beside the other."""
    check_areas(*(shape.mesh for shape in shapes))
    ratio = shapes[1].mesh.area * factor**2 / shapes[0].mesh.area
    if not SMALLEST_PART < ratio < 1 / SMALLEST_PART:
        raise InfeasibleError(
            f"{shapes[1].mesh.name} has {ratio:.4g} times the area of {shapes[0].mesh.name}, so "
            "nothing can be found; if the two are in different units, give the scale between them: "
            f"{factor / np.sqrt(ratio):.4g} would make them equally large"
        )


def _unit(shapes: Both[KeptShape], scale: float) -> float:
    """Length in the first shape's unit that counts as 1: sqrt(area) of the larger shape."""
    return max(shapes[0].mesh.length, shapes[1].mesh.length * scale)


def described_pair(
    shapes: Both[KeptShape], scale: float, landmarks: Ints
) -> Both[DescribedSurface]:
    """Both shapes in units of sqrt(area) of the larger one, lengths of the second times `scale`."""
    unit = _unit(shapes, scale)
    return (
        described_part(shapes[0].mesh, unit, sampled_at=landmarks[:, 0]),
        described_part(shapes[1].mesh, unit / scale, sampled_at=landmarks[:, 1]),
    )


def questions_of(
    surfaces: Both[DescribedSurface], landmarks: Ints, *, unknown: bool
) -> Both[Question]:
    """The second shape on the first, and the first on the second."""
    first, second = surfaces
    comparison = UNKNOWN_SCALE if unknown else SAME_SCALE
    there = pins_on(first, second, landmarks[:, 0], landmarks[:, 1])
    back = pins_on(second, first, landmarks[:, 1], landmarks[:, 0])
    return (
        Question(first, second, comparison, there),
        Question(second, first, comparison, back),
    )


def _scale(questions: Both[Question], options: OverlapOptions) -> ScaleEstimate:
    """Geometric mean of what both directions find, so that swapping the shapes inverts it."""
    if options.scale != "unknown":
        return SAME
    there, back = (
        estimated_scale(question, np.random.default_rng(options.seed), factors_about_one())
        for question in questions
    )
    return ScaleEstimate(
        float(np.sqrt(there.factor / back.factor)),
        at_bound=there.at_bound or back.at_bound,
        rival=there.rival if back.rival is None else 1 / back.rival,
    )


def problems_both_ways(questions: Both[Question], seed: int) -> Both[Problem]:
    """What is to be labeled in both directions; the shapes may be swapped, with one seed."""
    there, back = (anchor_problem(question, np.random.default_rng(seed)) for question in questions)
    return there, back


def labeled_both_ways(problems: Both[Problem], seed: int) -> TwoLabelings:
    """The nodes of each shape labeled by the other."""
    rngs = (np.random.default_rng(seed + 1), np.random.default_rng(seed + 1))
    return two_way_labelings(*problems, rngs)


def queries_both_ways(questions: Both[Question], seed: int) -> Both[Queries]:
    """What looks for similar places on each shape."""
    there, back = (part_queries(question, np.random.default_rng(seed)) for question in questions)
    return there, back


def prepare_both_ways(surface: DescribedSurface) -> None:
    """Compute now what is needed on first use."""
    _ = (surface.spectra, surface.dense, surface.sparse)


def _shared_map(
    full: KeptShape,
    part: KeptShape,
    question: Question,
    queries: Queries,
    place: SharedPlacement,
) -> SharedMap:
    """The answer for the vertices of `part` as the user counts; what was left out is unmatched."""
    surface = question.part
    at_own = surface.working.at_own_vertices
    points = surface_points(question, question.full.own_finder, place.deformation)
    source, known = part.sources()
    matched = (at_own(place.shared.astype(np.float64)) >= HALF)[source] & known
    soft = at_own(smoothed(surface.mesh, place.shared))[source]
    sure = at_own(shared_confidence(surface.mesh, queries, place))[source]
    return SharedMap(
        points=full.to_original_points(points[source]),
        matched=matched,
        membership=np.where(known, soft, 0.0),
        confidence=np.where(known, sure, 0.0),
    )
