"""placed_part(): a part placed on the full shape twice, and its mirror image; half of a match."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import partial

import numpy as np

from sherd.arrays import Bools, Ints
from sherd.correspondence.by_relief import labeled_by_relief
from sherd.correspondence.elsewhere import LabeledElsewhere, labeled_elsewhere
from sherd.correspondence.found import Found, beside_elsewhere, beside_relief, found_of_two
from sherd.correspondence.hints import check_hints, pins_of, without_ignored, working_pins
from sherd.correspondence.labels.anchors import chance_energy, find_anchors, first_labeling
from sherd.correspondence.labels.labeling import SAME_SCALE, UNKNOWN_SCALE, Labeling
from sherd.correspondence.placements import (
    anchor_problem,
    mirrored_placement,
    second_placement,
    viewed_placement,
)
from sherd.correspondence.question import Pins, Question
from sherd.correspondence.scale import (
    SAME,
    ScaleEstimate,
    estimated_scale,
    factors_that_fit,
)
from sherd.correspondence.working_placement import (
    Queries,
    WorkingPlacement,
    described_queries,
    placement_from_look,
    query_vertices,
    seen_by_labeling,
)
from sherd.mesh.sizes import check_areas, check_sizes
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import Stages
from sherd.results.match_options import MatchOptions
from sherd.scan.intake import Intake
from sherd.surface.described import DescribedSurface
from sherd.surface.prepared import described_part
from sherd.surface.template import Template
from sherd.threads import begun

__all__ = [
    "VIEWED_MARGIN", "AskedPart", "LabeledPart", "PlacedPart", "asked_part", "labeled_again",
    "labeled_part", "laid_part", "placed_part",
]  # fmt: skip

# In sqrt(area), of a part whose scale is unknown: whatever its file says, it is described as if it
# covered a third of the full shape, so that its unit does not matter.
TRIAL_SIZE = 0.6
# A placement that knows what a viewer saw is believed even if its score is lower by so much, half
# a unit of unlikeness: what others do not know they cannot be right about, but where the first one
# lies wrongly the viewer is sought in a wrong place.
VIEWED_MARGIN = 0.05


@dataclass(frozen=True, eq=False)
class AskedPart:
    """What is asked of one part.

    Attributes
    ----------
    template, part, kept, options
        The full shape, the part and which of its vertices, and how.
    pins, question
        The same on the working meshes.
    estimate, scale
        What lengths of the part were multiplied by, and how that was found.
    """

    template: Template
    part: Intake
    kept: Ints
    options: MatchOptions
    pins: Pins
    question: Question
    estimate: ScaleEstimate
    scale: float


@dataclass(frozen=True, eq=False)
class LabeledPart:
    """A part that was labeled and is not laid on the full shape yet: a third of the work.

    Attributes
    ----------
    asked
        What was asked.
    queries
        Waits for what looks for similar places.
    labeling, start_energy
        The last labeling, and the energy of the first one.
    chance_level
        Waits for the energy of one where nothing belongs together.
    elsewhere
        Waits for a labeling in another place.
    by_relief
        Finds a labeling by relief as well, when it is asked for.
    twin
        Waits for the placement of the mirror image; for None if it is not asked.
    rng
        What is drawn next.
    """

    asked: AskedPart
    queries: Callable[[], Queries]
    labeling: Labeling
    start_energy: float
    chance_level: Callable[[], float]
    elsewhere: Callable[[], LabeledElsewhere | None]
    by_relief: Callable[[], Labeling]
    twin: Callable[[], WorkingPlacement | None]
    rng: np.random.Generator

    @property
    def energy(self) -> float:
        """Of the last labeling, per node."""
        return self.labeling.energy


@dataclass(frozen=True, eq=False)
class PlacedPart(AskedPart, Found):
    """The placements of one part, and what was asked.

    Attributes
    ----------
    queries
        What looks for similar places.
    twin
        Of the mirror image; None if not asked.
    labeling_energy
        Of the last labeling, whatever a viewer saw.
    """

    queries: Queries
    twin: WorkingPlacement | None
    labeling_energy: float


def placed_part(
    template: Template, part: Intake, options: MatchOptions, stages: Stages, *, twin: bool = True
) -> PlacedPart:
    """Place a part whose faces look outward: the first half of the method.

    Parameters
    ----------
    template, part, options, stages
        As in :func:`match`.
    twin
        Whether the mirror image is placed as well.
    """
    return laid_part(labeled_part(template, part, options, stages, twin=twin), stages)


def labeled_part(
    template: Template, part: Intake, options: MatchOptions, stages: Stages, *, twin: bool
) -> LabeledPart:
    """The part described, and labeled once; parameters as in :func:`placed_part`."""
    rng, twin_rng = _generators(options)
    asked, waiting = asked_part(template, part, options, rng, stages)
    mirror: Callable[[], WorkingPlacement | None] = _no_twin
    if twin:
        mirror = begun(lambda: mirrored_placement(asked.question, waiting(), twin_rng))
    return _labeled(asked, waiting, mirror, rng, stages)


def asked_part(
    template: Template,
    part: Intake,
    options: MatchOptions,
    rng: np.random.Generator,
    stages: Stages,
) -> tuple[AskedPart, Callable[[], Queries]]:
    """The part described, its size known, and what waits for what looks for similar places.

    Parameters
    ----------
    template, part, options, stages
        As in :func:`placed_part`.
    rng
        What is drawn.
    """
    unknown = options.scale == "unknown"
    check_hints(template.intake, part, options)
    if unknown:
        check_areas(template.intake.mesh, part.mesh)
    else:
        check_sizes(template.intake.mesh, part.mesh, factor=options.factor, options=True)
    kept, kept_vertices = without_ignored(part, options)
    pins = pins_of(template, part, kept_vertices, options)
    unit = kept.length / TRIAL_SIZE if unknown else template.length / options.factor
    surface = _both_described(template, partial(_described, kept, unit, pins), stages)
    comparison = UNKNOWN_SCALE if unknown else SAME_SCALE
    question = Question(template, surface, comparison, working_pins(surface, pins))
    with stages("scale"):
        own = unit * options.factor / template.length
        estimate = _scale(question, rng, own) if unknown else SAME
        scale = options.factor * estimate.factor
        if unknown:
            unit = template.length / scale
            surface = _described(kept, unit, pins)
            question = question.with_part(surface)
        waiting = begun(partial(described_queries, question, query_vertices(question, rng)))
    asked = AskedPart(
        template=template,
        part=part,
        kept=kept_vertices,
        options=options,
        pins=pins,
        question=question,
        estimate=estimate,
        scale=scale,
    )
    return asked, waiting


def labeled_again(placed: PlacedPart, free: Bools, stages: Stages) -> LabeledPart:
    """A placed part labeled once more, without its mirror image, where its nodes may lie.

    What was computed of the part is kept, and what is drawn is drawn again.

    Parameters
    ----------
    placed
        Of a part whose scale is known.
    free
        (n,) bool, vertices of the template's working mesh where nodes may be placed.
    stages
        As in :func:`match`.
    """
    shared = {each.name: getattr(placed, each.name) for each in fields(AskedPart)}
    asked = replace(AskedPart(**shared), question=replace(placed.question, free=free))
    rng, _ = _generators(placed.options)
    query_vertices(asked.question, rng)
    return _labeled(asked, lambda: placed.queries, _no_twin, rng, stages)


def laid_part(labeled: LabeledPart, stages: Stages) -> PlacedPart:
    """A labeled part laid on the full shape, and again by another labeling of what it sees there.

    Once only: it goes on with the random numbers of the labeling.
    """
    asked, question, rng = labeled.asked, labeled.asked.question, labeled.rng
    with stages("first placement"):
        queries = labeled.queries()
        laid, look = seen_by_labeling(question, labeled.labeling, queries)
        first = begun(partial(placement_from_look, question, laid, look))
    with stages("second placement"):
        second = second_placement(question, look, queries, rng)
        by_chance = labeled.chance_level()
        found = found_of_two(first(), second, (labeled.start_energy, labeled.energy, by_chance))
        viewer = question.part.viewer
        if viewer is not None:
            viewed = viewed_placement(question, viewer, found.best, queries, rng)
            if viewed.placement.score > found.best.score - VIEWED_MARGIN:
                found = Found(viewed.placement, found.best, None, viewed.energies)
    # what knows of a viewer and what does not cannot be compared by their scores
    with stages("elsewhere"):
        elsewhere = labeled.elsewhere()
        if viewer is None and elsewhere is not None:
            found = beside_elsewhere(found, elsewhere, queries, rng)
    with stages("relief"):
        # one try more would make what does not belong a little likelier
        if viewer is None and found.doubtful:
            found = beside_relief(found, labeled.by_relief(), queries, rng)
    with stages("mirrored twin"):
        twin = labeled.twin()
    return PlacedPart(
        **vars(asked),
        **vars(found),
        queries=queries,
        twin=twin,
        labeling_energy=labeled.energy,
    )


def _generators(options: MatchOptions) -> list[np.random.Generator]:
    """For the part and for its mirror image."""
    return np.random.default_rng(options.seed).spawn(2)


def _no_twin() -> None:
    """In place of what waits for the mirror image, where nobody asks for it."""


def _labeled(
    asked: AskedPart,
    queries: Callable[[], Queries],
    twin: Callable[[], WorkingPlacement | None],
    rng: np.random.Generator,
    stages: Stages,
) -> LabeledPart:
    with stages("anchors"):
        problem = anchor_problem(asked.question, rng)
        start = first_labeling(problem)
        labeling = find_anchors(problem, start=start)
        # a generator of its own: what follows stays what it would be without this
        own_rng = np.random.default_rng(asked.options.seed)
        chance_level = begun(partial(chance_energy, problem, own_rng))
        elsewhere = begun(partial(labeled_elsewhere, problem, labeling))
    return LabeledPart(
        asked=asked,
        queries=queries,
        labeling=labeling,
        start_energy=start.energy,
        chance_level=chance_level,
        elsewhere=elsewhere,
        by_relief=partial(labeled_by_relief, problem),
        twin=twin,
        rng=rng,
    )


def _both_described(
    template: Template, describe: Callable[[], DescribedSurface], stages: Stages
) -> DescribedSurface:
    """The part, described beside the full shape, which is made ready."""
    if template.prepared:  # the file of which may still be read on another core
        with stages("part"):
            surface = describe()
        with stages("full shape"):
            template.prepare()
        return surface
    described = begun(describe)
    with stages("full shape"):
        template.prepare()
    with stages("part"):
        return described()


def _scale(question: Question, rng: np.random.Generator, own: float) -> ScaleEstimate:
    """By what to enlarge the part as its file says; as it is described here, `own` does that."""
    found = estimated_scale(question, rng, factors_that_fit(question), own=own)
    rival = None if found.rival is None else found.rival / own
    return replace(found, factor=found.factor / own, rival=rival)


def _described(kept: TriangleMesh, unit: float, pins: Pins) -> DescribedSurface:
    surface = described_part(kept, unit, sampled_at=pins.vertices)
    _ = surface.sparse  # computed on first use, and now another core may have time
    return surface
