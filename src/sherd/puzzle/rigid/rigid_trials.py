"""Where a rigid piece may lie: motions voted for, drawn to the surface, and how likely each is.

References
----------
Wales, Doye, *Global optimization by basin-hopping and the lowest energy structures of Lennard-Jones
clusters containing up to 110 atoms*, 1997: from what fits best the search hops on.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.special import expit

from sherd.correspondence.confidence import LEAST, MOST
from sherd.correspondence.elastic_kernel import fit_rotations
from sherd.correspondence.placements import anchor_problem
from sherd.correspondence.question import Question
from sherd.correspondence.registration import Deformation
from sherd.correspondence.working_placement import Queries, judged_placement, look_inside
from sherd.mesh.surface_finder import SurfaceFinder
from sherd.output import Stages
from sherd.place import AskedPart, PlacedPart, asked_part
from sherd.puzzle.partition import Partition
from sherd.puzzle.rigid.motion import RigidMotion, best_motion, extent
from sherd.puzzle.rigid.surface_fit import (
    FEW_ROUNDS,
    Probe,
    SurfaceFit,
    drawn_to_surface,
    drawn_to_vertices,
    fit_of,
    roughness,
)
from sherd.puzzle.rigid.voting import voted_motions
from sherd.puzzle.trials import Trial, each_tried, sure_of_side, trial_at
from sherd.results.advice import FOREIGN, SURE
from sherd.results.match_options import MatchOptions
from sherd.scan.either_side import better_side
from sherd.scan.intake import Intake
from sherd.surface.template import Template

__all__ = ["RigidPart", "rigid_chance", "rigid_trials"]

# Motions that are drawn to the nearest vertices, by so few vertices of the piece, 0.02 s each. With
# 40 one of seven sherds of a vase was not found, with 80 all were.
VOTED, FIRST_SAMPLES = 100, 500
# All neighborhoods of a small piece have a face of fracture in them, so no vote of it may be right.
# But what is round fits about as closely along a band, on which the place is where the relief fits
# as well. So where no place stands out the search hops on from the closest ones, by as much as
# below, while none does (basin hopping), unless it fits all around. Of 22 sherds that have a
# twentieth of the area of three vases votes find 14, one and two rounds the others, 2 s each.
HOPS, HOPPED, HOPS_EACH = 3, 20, 6
# A piece that does not lie on the whole with more than this share of its area lies on no band of
# it: it is seen from the wrong side, or crosses it.
LYING = 0.5
# Places that are drawn to the surface, 0.3 s each: the right one, its twin if it has one, and what
# fits by accident.
CLOSEST = 6
# But no more motions than this, if many lead to one place.
MOST_DRAWN = 20
# What fits by accident is known from so many places. Where votes and fits lead to fewer, as a foot
# of a vase fits on its foot only, the piece is nudged from the best one so often: what is round
# fits about as closely beside it then, and what is the same falls back. By about as much as its
# relief is wide, in sqrt(area) and radians.
ENOUGH_PLACES, NUDGED, NUDGE, NUDGE_TURN = 3, 12, 0.1, 0.3
# Vertices of the piece that say how well it fits, and those that say where it lies at last.
SAMPLES, LAST_SAMPLES = 1500, 10_000
# Motions that bring the piece to places closer than this, on average, in sqrt(area), are one. But a
# small piece that is turned in place moves by less; half of what voting tells apart.
SAME_PLACE, TURNED = 0.03, 0.25
# Places of one piece that take part in the joint choice: the right one and its twin.
PLACES = 2
# A surface that is the same, meshed anew, is off by 0.1 to 0.75 of what its meshes may be off by
# (sherds of vases: 0.00004 to 0.0004), one of another vase of that profile by 1.5 to 4 times that,
# or 0.0004 to 0.002. Half way by ratio; a scan that is off as a whole needs a larger tolerance.
EXACTLY, FINE, SHARPNESS = 1.1, 1 / 30, 0.15
# Meshes so coarse that they may be off by more than this tell nothing finer; in the tolerance.
COARSEST = 1 / 8
# Right places of sherds of nine vases fit 3.1 to 39 times as closely as the next place, and sherds
# of another vase of the same form 1.0 to 2.3 times. Half way by ratio.
BESIDE_ACCIDENT, SHARPNESS_BESIDE = 2.65, 0.1
# What fits more closely than a scanner measures, 0.05 mm on a vase of 30 cm, fits no better for it:
# a flat chip lies on everything flat, by 0.00004 here and by 0.00012 there. In sqrt(area).
SCANNED = 1e-4


@dataclass(frozen=True, eq=False)
class RigidPart(PlacedPart):
    """A rigid piece where it was laid; how surely is known from how closely it fits.

    Attributes
    ----------
    rigid_chance
        That the place is right, in [0, 1].
    anywhere
        Whether it fits closely, but about as closely elsewhere.
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

    return each_tried(template, intakes, tried)


def rigid_chance(
    distance: float, elsewhere: Sequence[float], exact: float, tolerance: float
) -> float:
    """The chance that a place is right where a piece is off by a geometric mean of `distance`.

    Parameters
    ----------
    distance, tolerance
        In sqrt(area); see :class:`SurfaceFit`.
    elsewhere
        The same at all other places, the closest first. The first of them fits by accident, or the
        tolerance does if there is none.
    exact
        What the same surface, meshed anew, may be off by, in the same way. If the place and the
        next one are off by less, that is no accident but a twin, and the one after it is: so
        neither is refused, and what fits alike all around, as a plain vase does, lies nowhere.
    """
    second, third = (*elsewhere, tolerance, tolerance)[:2]
    twin = expit(math.log(exact / max(distance, second)) / SHARPNESS_BESIDE)
    accident = twin * math.log(third) + (1.0 - twin) * math.log(second)
    beside = accident - math.log(BESIDE_ACCIDENT * max(distance, SCANNED))
    fine = math.log(max(EXACTLY * exact, FINE * tolerance) / distance)
    chance = expit(beside / SHARPNESS_BESIDE) * expit(fine / SHARPNESS)
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
    exact = min(roughness(mesh) + roughness(full.mesh), COARSEST * tolerance)
    with stages("first placement"):
        few, probe = Probe.of(mesh, FIRST_SAMPLES, rng), Probe.of(mesh, SAMPLES, rng)
        search = _Search(question, few, probe, exact, tolerance, rng)
        near = search.hopping_on(search.near(voted))
    with stages("second placement"):
        best = search.drawn(near)
        if len(best) < ENOUGH_PLACES:
            best = search.drawn(search.near(search.nudged(best[0].motion, NUDGED)), best)
        last = Probe.of(question.part.placed, LAST_SAMPLES, rng)
        found = []
        for fit in best[:PLACES]:
            chance = search.chance(fit, best)
            closely = search.chance(fit, ())
            if fit is best[0] or chance >= FOREIGN:
                motion = _drawn_at_last(fit.motion, last, full.own_finder, tolerance)
                found.append(_laid(asked, queries(), replace(fit, motion=motion), chance, closely))
        return found


@dataclass(frozen=True, eq=False)
class _Search:
    """What looks for the places of one piece.

    Attributes
    ----------
    question
        The piece on the full shape.
    few, probe
        Vertices of it that draw it near, and those that say how well it fits.
    exact
        What a surface that lies on the full shape may be off by.
    tolerance
        What is farther off does not lie there.
    rng
        Of nudges.
    """

    question: Question
    few: Probe
    probe: Probe
    exact: float
    tolerance: float
    rng: np.random.Generator

    def near(
        self, motions: Sequence[RigidMotion], known: Sequence[SurfaceFit] = ()
    ) -> list[SurfaceFit]:
        """Motions drawn to the nearest vertices, and known ones: one a place, the closest first."""
        full = self.question.full
        drawn = [drawn_to_vertices(each, self.few, full, self.tolerance) for each in motions]
        return self._different([*known, *map(self._fit, drawn)])

    def hopping_on(self, places: list[SurfaceFit]) -> list[SurfaceFit]:
        """These places, and those that the search hops to from the closest of them."""
        for _ in range(HOPS):
            lying = [fit for fit in places[:HOPPED] if fit.share > LYING]
            if not lying or self._settled(places):
                break
            hops = [hop for fit in lying for hop in self.nudged(fit.motion, HOPS_EACH)]
            places = self.near(hops, places)
        return places

    def drawn(
        self, places: Sequence[SurfaceFit], known: Sequence[SurfaceFit] = ()
    ) -> list[SurfaceFit]:
        """Places drawn to the surface, beside those that are known, until there are `CLOSEST`."""
        found, finder = list(known), self.question.full.finder
        # what was apart may be drawn to one place
        for each in places[:MOST_DRAWN]:
            if len(found) >= CLOSEST:
                break
            motion = drawn_to_surface(
                each.motion, self.probe, finder, self.tolerance, rounds=FEW_ROUNDS
            )
            found = self._different([*found, self._fit(motion)])
        return found

    def nudged(self, motion: RigidMotion, count: int) -> list[RigidMotion]:
        """Motions beside one: the piece shifted and turned about its middle at random."""
        middle = np.average(motion(self.probe.points), axis=0, weights=self.probe.areas)
        found = []
        for _ in range(count):
            turn = Rotation.from_rotvec(NUDGE_TURN * self.rng.normal(size=3)).as_matrix()
            shift = middle + NUDGE * self.rng.normal(size=3) - turn @ middle
            found.append(RigidMotion(turn, shift).after(motion))
        return found

    def chance(self, fit: SurfaceFit, places: Sequence[SurfaceFit]) -> float:
        """The chance of one of several places."""
        elsewhere = [other.distance for other in places if other is not fit]
        # a distance counts what does not lie there as off by the tolerance
        counted = self.exact**fit.share * self.tolerance ** (1.0 - fit.share)
        return rigid_chance(fit.distance, elsewhere, counted, self.tolerance)

    def _settled(self, places: Sequence[SurfaceFit]) -> bool:
        """Whether nothing is left to search for: the closest place stands out, or never will.

        Where three places fit as the same surface does, a piece fits all around.
        """
        stands_out = self.chance(places[0], places) >= SURE
        return stands_out or all(self.chance(fit, ()) >= SURE for fit in places[:ENOUGH_PLACES])

    def _fit(self, motion: RigidMotion) -> SurfaceFit:
        return fit_of(motion, self.probe, self.question.full.finder, self.tolerance)

    def _different(self, fits: Sequence[SurfaceFit]) -> list[SurfaceFit]:
        """One fit for each place, the closest one first."""
        surface = self.question.part
        nodes = surface.mesh.vertices[surface.sparse.vertices]
        same = min(SAME_PLACE, TURNED * extent(nodes))
        found: list[SurfaceFit] = []
        for fit in sorted(fits, key=lambda each: each.distance):
            here = fit.motion(nodes)
            apart = [np.linalg.norm(here - each.motion(nodes), axis=1).mean() for each in found]
            if min(apart, default=np.inf) >= same:
                found.append(fit)
        return found


def _drawn_at_last(
    motion: RigidMotion, probe: Probe, finder: SurfaceFinder, tolerance: float
) -> RigidMotion:
    """The motion drawn by many points, unless these fit more closely where it was."""
    drawn = drawn_to_surface(motion, probe, finder, tolerance)
    fits = [fit_of(each, probe, finder, tolerance) for each in (drawn, motion)]
    return min(fits, key=lambda fit: fit.distance).motion


def _laid(
    asked: AskedPart, queries: Queries, fit: SurfaceFit, chance: float, closely: float
) -> _Laid:
    """The piece seen where it fits, as any placement is; `closely`: the chance but for others."""
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
        anywhere=chance < SURE <= closely,
    )
    return _Laid(placed, _in_files(motion, placed), fit)


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
