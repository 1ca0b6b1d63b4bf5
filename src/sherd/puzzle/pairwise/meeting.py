"""What two pieces share, or two unions of pieces, and the chance that they belong together.

As :func:`sherd.overlap` finds it, but for the chance, which asks for one thing more: where both are
cut from one whole, what they share ends where one of both does. Where that is not sure, further
places, those whose form is most alike, are laid and judged the same way.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from sherd.arrays import Bools, Ints
from sherd.correspondence.confidence import LEAST
from sherd.correspondence.labels.labeling import Problem
from sherd.correspondence.labels.places import followed, not_said_before
from sherd.correspondence.labels.relief_similarity import with_relief
from sherd.correspondence.labels.two_way import Both, TwoLabelings
from sherd.correspondence.question import NO_PINS, Question
from sherd.correspondence.shared.judgment import likeness_of_both, share_of_both, shared_area
from sherd.correspondence.shared.likeness import recognized_by_relief
from sherd.correspondence.shared.places_by_form import finished_place, labelings_by_form
from sherd.correspondence.shared.relief_correlation import alike_in_relief
from sherd.correspondence.shared.two_way_placement import (
    SharedPlacement,
    first_look,
    looked_closer,
    share_something,
)
from sherd.correspondence.working_placement import Queries
from sherd.descriptors.relief import form
from sherd.mesh.surface_points import closest_points
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.overlap import (
    STRETCH,
    labeled_both_ways,
    prepare_both_ways,
    problems_both_ways,
    queries_both_ways,
    questions_of,
)
from sherd.puzzle.pairwise.answer import JOINED, RECOGNIZED, Meeting, one_place
from sherd.puzzle.pairwise.join_chance import (
    HANDEDNESS,
    WORTH_A_SLIDE,
    enough_lead,
    fills_a_gap,
    fits_a_twin,
    join_chance,
    join_features,
    lies_within,
    may_be_right,
    may_lie_right,
)
from sherd.puzzle.pairwise.skin_chance import SlidChance, chance_as_it_lies, chance_where_it_slid
from sherd.puzzle.pairwise.sliding import slid
from sherd.puzzle.pairwise.twin import beside_their_twins
from sherd.results.overlap_options import OverlapOptions
from sherd.surface.described import DescribedSurface
from sherd.surface.prepared import described_part
from sherd.surface.transformed import mirrored, sampled_within
from sherd.threads import cached_property, one_blas_thread, side_by_side

__all__ = [
    "NOTHING_KNOWN",
    "Describe",
    "PairQuestion",
    "free_vertices",
    "pair_question",
]

Describe = Callable[[TriangleMesh, float], DescribedSurface]
NOTHING_KNOWN = np.empty((0, 2), dtype=np.int64)


@one_blas_thread()
def pair_question(
    first: TriangleMesh,
    second: TriangleMesh,
    seed: int,
    known: Ints = NOTHING_KNOWN,
    taken: Bools | None = None,
    describe: Describe = described_part,
    unit: float = 0.0,
) -> PairQuestion:
    """Ask what two surfaces share, in units of sqrt(area) of their whole, as far as that is known.

    Parameters
    ----------
    first, second
        Without what needs repair, in one unit of length.
    seed
        Of all random choices.
    known
        (p, 2) vertices of the first and the second that lie on each other. They rule labels out;
        places are found without them. Those on taken places do not count.
    taken
        (n,) vertices of the first where nothing of the second may be laid; none if None.
    describe
        Describes a surface where nothing is known; it may recall one.
    unit
        What sqrt(area) of the whole may be, in that unit of length. That of the larger one is the
        least that it can be, and counts if it is more.
    """
    unit = max(first.length, second.length, unit)
    surfaces = described = _described(first, second, unit, known, describe)
    free = None if taken is None else free_vertices(surfaces[0], first, taken)
    if free is not None and free[surfaces[0].sparse.vertices].any():
        known = known[free[surfaces[0].working.working_vertices(known[:, 0])]]
        surfaces = (sampled_within(surfaces[0], free), surfaces[1])
    return PairQuestion.of(surfaces, unit, seed, described, known, free)


def _described(
    first: TriangleMesh, second: TriangleMesh, unit: float, known: Ints, describe: Describe
) -> Both[DescribedSurface]:
    """Both in one unit, ready to be asked; sampled at what is known."""
    if len(known):
        surfaces = (
            described_part(first, unit, sampled_at=known[:, 0]),
            described_part(second, unit, sampled_at=known[:, 1]),
        )
    else:
        surfaces = (describe(first, unit), describe(second, unit))
    for surface in surfaces:
        prepare_both_ways(surface)
    return surfaces


@dataclass(frozen=True, eq=False)
class PairQuestion:
    """What two surfaces share is asked: both, and their labels on each other.

    Attributes
    ----------
    questions, queries, problems
        Of both directions.
    labelings
        What saves most.
    unit
        Of length, in that of the meshes.
    seed
        Of all random choices.
    described
        Both surfaces where no place is taken.
    """

    questions: Both[Question]
    queries: Both[Queries]
    problems: Both[Problem]
    labelings: TwoLabelings
    unit: float
    seed: int
    described: Both[DescribedSurface]

    @classmethod
    def of(
        cls,
        surfaces: Both[DescribedSurface],
        unit: float,
        seed: int,
        described: Both[DescribedSurface],
        known: Ints = NOTHING_KNOWN,
        free: Bools | None = None,
    ) -> PairQuestion:
        """Label both by normals and by relief; what is known and what is taken rules labels out."""
        there, back = questions_of(surfaces, known, unknown=False)
        guided = (replace(there.with_stretch(STRETCH), free=free), back.with_stretch(STRETCH))
        by_normals = problems_both_ways(guided, seed)
        problems = (with_relief(by_normals[0]), with_relief(by_normals[1]))
        questions = (
            replace(guided[0], pins=NO_PINS, free=None),
            replace(guided[1], pins=NO_PINS),
        )
        return cls(
            questions,
            queries_both_ways(questions, seed),
            problems,
            labeled_both_ways(problems, seed),
            unit,
            seed,
            described,
        )

    @one_blas_thread()
    def at_a_glance(self) -> Meeting:
        """Laid where labels save most and nowhere else, nor of the mirror image.

        A third of the time of the full answer where that is not sure, and as much where it is.
        """
        return self._first_answer

    @one_blas_thread()
    def in_full(self) -> Meeting:
        """The answer; if the first one is not sure, of all places, and by the mirror image, too."""
        answers = [self._first_answer]
        if self._first_answer.chance < JOINED:
            answers = one_place([self._first_answer, *self._further_answers()])
        met = beside_their_twins(answers, self._mirrored_answer)
        filling = [each for each in answers if each.fills]
        return replace(
            met,
            in_gap=max(filling, key=lambda each: each.filling, default=None),
            recognized=max(each.recognized for each in answers),
        )

    @cached_property
    def led(self) -> TwoLabelings:
        """What saves most, one direction led by the other where that keeps far less."""
        return followed(self.problems, self.labelings)

    @cached_property
    def _first_answer(self) -> Meeting:
        """Laid where labels save most."""
        return self._answer(self.led)

    def _further_answers(self) -> list[Meeting]:
        """Laid at other places, those most alike in form."""
        forms = (form(self.questions[0].part.mesh), form(self.questions[1].part.mesh))
        begun = labelings_by_form(self.problems, forms, self.labelings)
        tried = [followed(self.problems, finished_place(self.problems, each)) for each in begun]
        if self.led is not self.labelings:
            tried.append(self.labelings)
        further = not_said_before(tried, self.led)
        return side_by_side(partial(self._answer, each) for each in further)

    def _mirrored_answer(self) -> Meeting:
        """Of the mirror image of the second; nothing is known of it, and no place is taken."""
        image = mirrored(self.described[1])
        prepare_both_ways(image)
        both = (self.described[0], image)
        return PairQuestion.of(both, self.unit, self.seed, both)._first_answer

    def _answer(self, labelings: TwoLabelings) -> Meeting:
        """Both laid on each other by one labeling of both, and how likely that is right.

        What comes back nowhere at a first look is not looked at closer: of 126 such places of four
        puzzles 16 shared something then, and none was likelier than 0.006.
        """
        questions, queries, unit = self.questions, self.queries, self.unit
        strain = OverlapOptions().strain
        laid = first_look(questions, labelings, queries, strain=strain)
        if not share_something(laid):
            unlike = (_unlike(laid[0], queries[0]), _unlike(laid[1], queries[1]))
            return Meeting(questions, queries, unlike, unit, LEAST, twin=False)
        placements = looked_closer(questions, queries, laid, strain=strain)
        likeness = likeness_of_both(questions, placements)
        features = join_features(labelings, questions, placements, likeness, self.seed)
        skin, recognized = SlidChance(0.0, 0.0), 0.0
        may_be = may_be_right(features)
        if may_lie_right(features):
            skin = chance_as_it_lies(questions, placements, likeness)
            recognized = self._recognized(placements)
        twin = fits_a_twin(features) or skin.turned
        chance, leads = join_chance(features), enough_lead(features)
        met = Meeting(
            questions,
            queries,
            placements,
            unit,
            chance,
            twin,
            fitting=skin.fitting,
            filling=skin.filling,
            leads=leads,
            handedness=float(features[HANDEDNESS]),
            fills=may_be and skin.alike and fills_a_gap(questions, placements),
            recognized=recognized,
        )
        return self._slid(met, skin) if may_be or skin.fitting >= WORTH_A_SLIDE else met

    def _slid(self, met: Meeting, skin: SlidChance) -> Meeting:
        """The same where reliefs are most alike; what is sure there is not laid on its twin.

        As it was where that is sure by its `skin`, and the other is not; and where the slide
        neither makes it likelier nor reliefs more alike, at a width finer than those it slides by.
        """
        found = slid(met.questions, met.placements, strain=OverlapOptions().strain)
        met = replace(met, recognized=max(met.recognized, self._recognized(found)))
        likeness = likeness_of_both(met.questions, found)
        said = chance_where_it_slid(met.chance, met.questions, found, likeness)
        if skin.chance >= JOINED > said.chance:
            return _judged(met, skin)
        there = _judged(replace(met, placements=found), said)
        if max(said.chance, said.by_skin) > met.chance:
            return there
        before, after = (alike_in_relief(met.questions, each) for each in (met.placements, found))
        return there if after > before else replace(met, chance=said.chance, by_skin=skin.by_skin)

    def _recognized(self, placements: Both[SharedPlacement]) -> float:
        """How much of the area that is shared, see `Meeting`; 0 where that is too little to count.

        Nobody belongs by less than `RECOGNIZED`, which the larger of both alone is too large for.
        """
        area = shared_area(self.questions, placements)
        larger = max(float(each.part.mesh.area) for each in self.questions)
        if 0.5 * area < RECOGNIZED * larger or lies_within(self.questions, placements):
            return 0.0
        share = share_of_both(recognized_by_relief, self.questions, placements)
        return 0.0 if share is None else area * (share - 0.5) * self.unit**2


def _unlike(place: SharedPlacement, queries: Queries) -> SharedPlacement:
    """A placement that nothing is known of but that it is wrong: no neighborhoods are alike."""
    return replace(place, similarity=np.zeros(len(queries.vertices)))


def _judged(met: Meeting, said: SlidChance) -> Meeting:
    """What lies where skin made it sure is not laid on its twin."""
    twin = met.twin and said.chance < JOINED
    return replace(
        met,
        chance=said.chance,
        twin=twin,
        by_skin=said.by_skin,
        fitting=said.fitting,
        filling=said.filling,
    )


def free_vertices(surface: DescribedSurface, mesh: TriangleMesh, taken: Bools) -> Bools:
    """Vertices (m,) of the working mesh that do not lie where a surface's own are taken."""
    at = closest_points(surface.placed, surface.mesh.vertices)
    free: Bools = ~taken[at.nearest_vertices(mesh)]
    return free
