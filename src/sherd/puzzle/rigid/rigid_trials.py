"""Where a rigid piece may lie: motions voted for, drawn to the surface, and how likely each is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from sherd.correspondence.confidence import LEAST, MOST
from sherd.correspondence.elastic_kernel import fit_rotations
from sherd.correspondence.placements import anchor_problem
from sherd.correspondence.registration import Deformation
from sherd.correspondence.working_placement import Queries, judged_placement, look_inside
from sherd.output import Stages
from sherd.place import AskedPart, PlacedPart, asked_part
from sherd.puzzle.partition import Partition
from sherd.puzzle.rigid.motion import RigidMotion, best_motion
from sherd.puzzle.rigid.surface_fit import (
    FEW_ROUNDS,
    Probe,
    SurfaceFit,
    drawn_to_surface,
    drawn_to_vertices,
    fit_of,
)
from sherd.puzzle.rigid.voting import voted_motions
from sherd.puzzle.trials import Trial, each_tried, sure_of_side, trial_at
from sherd.results.advice import FOREIGN, SURE
from sherd.results.match_options import MatchOptions
from sherd.scan.either_side import better_side
from sherd.scan.intake import Intake
from sherd.surface.described import DescribedSurface
from sherd.surface.template import Template

__all__ = ["RigidPart", "rigid_chance", "rigid_trials"]

# Motions that are drawn to the nearest vertices, by so few vertices of the piece, 0.02 s each. With
# 40 one of seven sherds of a vase was not found, with 80 all were.
VOTED, FIRST_SAMPLES = 100, 500
# Places that are drawn to the surface, 0.3 s each: the right one, its twin if it has one, and what
# fits by accident.
CLOSEST = 6
# Vertices of the piece that say how well it fits, and those that say where it lies at last.
SAMPLES, LAST_SAMPLES = 1500, 10_000
# Motions that bring the piece to places closer than this, on average, in sqrt(area), are one.
SAME_PLACE = 0.03
# Places of one piece that take part in the joint choice: the right one and its twin.
PLACES = 2
# A surface that is the same, meshed anew, is off by 0.0001 to 0.0004 on geometric average (sherds
# of a vase with their faces of fracture, parts of an animal and of a skull), and at other places,
# or on another vase of that form, by 0.0006 and more, mostly 0.001 to 0.005. So what is off by an
# eighth of the tolerance, 0.0019, may be either, and a factor of e^0.5 decides.
FINE, SHARPNESS = 1 / 8, 0.25
# As meshes themselves are off by 0.0004, no smaller tolerance than this is asked for.
LEAST_TOLERANCE = 0.005
# Right places fit 3 to 20 times as closely as what fits by accident; sherds of another vase of the
# same form 1.0 to 1.4 times, as a form that is round fits alike all around.
BESIDE_ACCIDENT, SHARPNESS_BESIDE = 2.0, 0.1


@dataclass(frozen=True, eq=False)
class RigidPart(PlacedPart):
    """A rigid piece where it was laid; how surely is known from how closely it fits.

    Attributes
    ----------
    rigid_chance
        That the place is right, in [0, 1].
    anywhere
        Whether it fits closely, but about as closely in several other places.
    """

    rigid_chance: float
    anywhere: bool

    @property
    def chance(self) -> float:
        """That the place is right."""
        return self.rigid_chance


@dataclass(frozen=True, eq=False)
class _Laid:
    """One place of a piece."""

    placed: RigidPart
    motion: RigidMotion
    fit: SurfaceFit


def rigid_trials(
    template: Template,
    intakes: Sequence[Intake],
    options: MatchOptions,
    tolerance: float,
    stages: Stages,
    partition: Partition,
) -> tuple[list[Trial], dict[int, str]]:
    """Each rigid piece where it fits best, and at its twin; of those that cannot, the reason.

    Parameters
    ----------
    template, intakes, options, stages, partition
        As in :func:`sherd.puzzle.trials.trials_alone`.
    tolerance
        What is farther off is worn, in sqrt(area of the full shape).
    """
    tolerance = max(tolerance, LEAST_TOLERANCE)

    def tried(piece: int, intake: Intake) -> list[Trial]:
        found = better_side(
            intake,
            options.side,
            partial(_places, template, options, tolerance, stages),
            score=lambda laid: -laid[0].fit.distance,
            sure=lambda part, laid: sure_of_side(part, laid[0].placed.chance),
        )
        return [
            trial_at(piece, laid.placed, partition, laid.placed.chance, laid.motion)
            for laid in found
        ]

    return each_tried(intakes, tried)


def rigid_chance(distance: float, elsewhere: Sequence[float], tolerance: float) -> float:
    """The chance that a place is right where a piece is off by a geometric mean of `distance`.

    Parameters
    ----------
    distance, tolerance
        In sqrt(area); see :class:`SurfaceFit`.
    elsewhere
        The same at all other places, the closest first. What fits by accident is off by the second
        of them, or by the tolerance if there is none: so of two places that fit alike neither is
        refused, and what fits alike all around, as a plain vase does, lies nowhere.
    """
    accident = elsewhere[1] if len(elsewhere) > 1 else tolerance
    logits = (
        math.log(accident / (BESIDE_ACCIDENT * distance)) / SHARPNESS_BESIDE,
        math.log(FINE * tolerance / distance) / SHARPNESS,
    )
    chance = math.prod(1 / (1 + math.exp(-logit)) for logit in logits)
    return float(np.clip(chance, LEAST, MOST))


def _places(
    template: Template, options: MatchOptions, tolerance: float, stages: Stages, part: Intake
) -> list[_Laid]:
    """The places where a part whose faces look outward fits best, the best one first."""
    rng = np.random.default_rng(options.seed)
    asked, queries = asked_part(template, part, options, rng, stages)
    question = asked.question
    full, mesh = question.full, question.part.mesh
    with stages("anchors"):
        voted = voted_motions(anchor_problem(question, rng), VOTED)
    with stages("first placement"):
        few, probe = Probe.of(mesh, FIRST_SAMPLES, rng), Probe.of(mesh, SAMPLES, rng)
        finder = full.finder
        near = [drawn_to_vertices(each, few, full, tolerance) for each in voted]
        closest = _different(
            [fit_of(each, probe, finder, tolerance) for each in near], question.part
        )[:CLOSEST]
    with stages("second placement"):
        drawn = [
            drawn_to_surface(each.motion, probe, finder, tolerance, rounds=FEW_ROUNDS)
            for each in closest
        ]
        best = _different([fit_of(each, probe, finder, tolerance) for each in drawn], question.part)
        last = Probe.of(question.part.placed, LAST_SAMPLES, rng)
        found = []
        for fit in best[:PLACES]:
            elsewhere = [other.distance for other in best if other is not fit]
            chance = rigid_chance(fit.distance, elsewhere, tolerance)
            if fit is best[0] or chance >= FOREIGN:
                motion = drawn_to_surface(fit.motion, last, full.own_finder, tolerance)
                found.append(
                    _laid(asked, queries(), replace(fit, motion=motion), chance, tolerance)
                )
        return found


def _laid(
    asked: AskedPart, queries: Queries, fit: SurfaceFit, chance: float, tolerance: float
) -> _Laid:
    """The piece seen where it fits, as any placement is."""
    question, motion = asked.question, fit.motion
    own = question.part.placed
    points = question.full.own_finder.closest(
        motion(own.vertices), own.vertex_normals @ motion.rotation.T
    )
    positions = motion(question.part.mesh.vertices)
    deformation = Deformation(positions, fit_rotations(question.part.elastic, positions))
    look = look_inside(question, deformation, queries)
    judged = judged_placement(question, deformation, look)
    placement = replace(judged, known_points=points)
    placed = RigidPart(
        **vars(asked),
        best=placement,
        other=placement,
        rival=None,
        energies=(0.0, 0.0, 1.0),  # of labelings, of which there is none
        queries=queries,
        twin=None,
        labeling_energy=0.0,
        rigid_chance=chance,
        anywhere=chance < SURE <= rigid_chance(fit.distance, (), tolerance),
    )
    return _Laid(placed, _in_files(motion, placed), fit)


def _different(fits: Sequence[SurfaceFit], surface: DescribedSurface) -> list[SurfaceFit]:
    """One fit for each place, the closest one first."""
    nodes = surface.mesh.vertices[surface.sparse.vertices]
    found: list[SurfaceFit] = []
    for fit in sorted(fits, key=lambda each: each.distance):
        here = fit.motion(nodes)
        apart = [np.linalg.norm(here - each.motion(nodes), axis=1).mean() for each in found]
        if min(apart, default=np.inf) >= SAME_PLACE:
            found.append(fit)
    return found


def _in_files(motion: RigidMotion, placed: PlacedPart) -> RigidMotion:
    """The motion in the unit and the frames of the files, not in those of the working meshes."""
    template, question, length = placed.template, placed.question, placed.template.length
    own = best_motion(
        placed.scale * placed.part.mesh.vertices[placed.kept] / length,
        question.part.placed.vertices,
    )
    there = best_motion(template.intake.mesh.vertices / length, template.placed.vertices)
    small = there.inverse.after(motion.after(own))
    return RigidMotion(small.rotation, length * small.shift)
