"""Maps that lie beside their place slide back to it; elsewhere there is nothing to slide to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sherd.arrays import Floats
from sherd.correspondence.elastic_kernel import fit_rotations
from sherd.correspondence.labels.two_way import Both
from sherd.correspondence.question import Question
from sherd.correspondence.registration import Deformation
from sherd.correspondence.shared import accident
from sherd.correspondence.shared.judgment import likeness_of_both
from sherd.correspondence.shared.likeness import Likeness
from sherd.correspondence.shared.relief_correlation import alike_in_relief
from sherd.correspondence.shared.round_trip import round_trip
from sherd.correspondence.shared.two_way_placement import SharedPlacement
from sherd.mesh.surface_points import closest_points
from sherd.overlap import questions_of
from sherd.puzzle.pairwise import skin_chance
from sherd.puzzle.pairwise.answer import HALF_LIKELY, JOINED, LIKELY
from sherd.puzzle.pairwise.join_chance import UNLIKE, ends_with_one, may_be_right
from sherd.puzzle.pairwise.skin_chance import SlidChance, chance_as_it_lies, chance_where_it_slid
from sherd.puzzle.pairwise.sliding import slid
from sherd.results.advice import SURE
from sherd.results.overlap_options import OverlapOptions
from sherd.shapes import creature
from sherd.surface.prepared import described_part

# As far off as right answers are where skin stretches.
BESIDE = 0.04
HALF_TURN = np.array([1.0, -1.0, -1.0])


@pytest.fixture(scope="module")
def questions() -> Both[Question]:
    """Walking on standing, and back."""
    standing, walking = creature(5000), creature(5000, pose="walk")
    surfaces = tuple(described_part(mesh, standing.length) for mesh in (standing, walking))
    return questions_of(surfaces, np.empty((0, 2), dtype=np.int64), unknown=False)


def true_places(question: Question) -> Floats:
    """Where each vertex of the part's working mesh lies; both shapes have the same vertices."""
    at = closest_points(question.part.placed, question.part.mesh.vertices)
    return at.interpolate(question.part.placed, question.full.placed.vertices)


def laid(questions: Both[Question], images: Both[Floats]) -> Both[SharedPlacement]:
    """Both shapes with their vertices at the places under their images."""
    deformations = []
    for question, image in zip(questions, images, strict=True):
        places = closest_points(question.full.mesh, image).positions(question.full.mesh)
        deformations.append(Deformation(places, fit_rotations(question.part.elastic, places)))
    placements = []
    for question, own, other in zip(questions, deformations, deformations[::-1], strict=True):
        count = question.part.mesh.vertex_count
        trip = round_trip(question, own, other)
        none = np.zeros(count)
        placements.append(
            SharedPlacement(own, trip, np.ones(count, dtype=bool), none, none, np.empty(0))
        )
    return placements[0], placements[1]


def error(questions: Both[Question], placements: Both[SharedPlacement]) -> float:
    return float(
        np.mean(
            [
                np.linalg.norm(place.trip.there - true_places(question), axis=1)[
                    place.shared
                ].mean()
                for question, place in zip(questions, placements, strict=True)
            ]
        )
    )


def moved(questions: Both[Question], placements: Both[SharedPlacement]) -> Both[SharedPlacement]:
    return slid(questions, placements, strain=OverlapOptions().strain)


def likeness(questions: Both[Question], placements: Both[SharedPlacement]) -> Likeness:
    found = likeness_of_both(questions, placements)
    assert found is not None
    return found


# Placements and what they look like take seconds each, and no test changes them.


@pytest.fixture(scope="module")
def home(questions) -> Both[SharedPlacement]:
    return laid(questions, (true_places(questions[0]), true_places(questions[1])))


@pytest.fixture(scope="module")
def home_likeness(questions, home) -> Likeness:
    return likeness(questions, home)


@pytest.fixture(scope="module")
def half(home) -> Both[SharedPlacement]:
    return half_shared(home)


@pytest.fixture(scope="module")
def half_likeness(questions, half) -> Likeness:
    return likeness(questions, half)


@pytest.fixture(scope="module")
def beside(questions) -> Both[SharedPlacement]:
    truths = [true_places(question) for question in questions]
    forward = np.eye(3)[np.ptp(truths[0], axis=0).argmax()]
    return laid(questions, (truths[0] + BESIDE * forward, truths[1] - BESIDE * forward))


@pytest.fixture(scope="module")
def slid_home(questions, beside) -> Both[SharedPlacement]:
    return moved(questions, beside)


@pytest.fixture(scope="module")
def elsewhere(questions) -> Both[SharedPlacement]:
    """What was laid turned over slides to what is most alike there."""
    images = []
    for question in questions:
        center = question.full.mesh.vertices.mean(axis=0)
        images.append((true_places(question) - center) * HALF_TURN + center)
    return moved(questions, laid(questions, (images[0], images[1])))


def test_what_lies_beside_its_place_slides_to_it(questions, beside, slid_home) -> None:
    found = slid_home
    assert error(questions, beside) > 0.6 * BESIDE
    assert error(questions, found) < 0.4 * error(questions, beside)
    assert alike_in_relief(questions, found) > alike_in_relief(questions, beside) + 0.2
    for place in found:
        assert place.shared.mean() > 0.8


def test_what_lies_right_stays(questions, home) -> None:
    assert error(questions, moved(questions, home)) < 0.01


def test_what_lies_elsewhere_finds_no_relief_to_slide_to(questions, elsewhere) -> None:
    assert alike_in_relief(questions, elsewhere) < UNLIKE


def test_where_nothing_is_shared_nothing_moves(questions, home) -> None:
    apart = tuple(replace(place, shared=np.zeros_like(place.shared)) for place in home)
    assert moved(questions, apart) is apart


def slid_chance(
    before: float, questions: Both[Question], placements: Both[SharedPlacement]
) -> SlidChance:
    found = likeness_of_both(questions, placements)
    return chance_where_it_slid(before, questions, placements, found)


@pytest.fixture(autouse=True)
def cut(monkeypatch) -> None:
    """What is shared ends where a piece does, which `half_shared` does not cut."""
    monkeypatch.setattr(skin_chance, "ends_with_one", lambda *_: 1.0)


def half_shared(placements: Both[SharedPlacement]) -> Both[SharedPlacement]:
    """Neither shape lies within the other."""
    first, second = (
        replace(
            place, shared=place.shared & (np.arange(len(place.shared)) >= len(place.shared) // 2)
        )
        for place in placements
    )
    return first, second


@pytest.fixture(scope="module")
def half_elsewhere(questions, elsewhere) -> tuple[Both[SharedPlacement], Likeness | None]:
    """Neither shape lies within the other there, and how alike they are."""
    half = half_shared(elsewhere)
    return half, likeness_of_both(questions, half)


def test_what_slid_home_is_sure_and_what_slid_elsewhere_is_not(
    questions, slid_home, half_elsewhere
) -> None:
    assert slid_chance(0.0, questions, half_shared(slid_home)).chance > SURE
    assert chance_where_it_slid(0.0, questions, *half_elsewhere).chance < 0.1


def test_what_was_sure_is_refused_where_its_slide_says_it_is_something_else(
    questions, half_elsewhere, half, half_likeness
) -> None:
    assert chance_where_it_slid(0.9, questions, *half_elsewhere).chance < 0.5
    assert chance_where_it_slid(0.9, questions, half, half_likeness).chance >= 0.9


def test_what_bulges_elsewhere_is_refused_though_all_else_is_right(
    questions, half, half_likeness, monkeypatch
) -> None:
    """A leg of a cat fits a horse that lacks one, bumps and all."""
    monkeypatch.setattr(skin_chance, "alike_in_form", lambda *_: 0.0)
    for before in (0.9, 0.0):
        assert chance_where_it_slid(before, questions, half, half_likeness).chance < SURE


def test_what_is_no_more_alike_than_mirrored_is_not_sure(
    questions, half, half_likeness, monkeypatch
) -> None:
    """A foreleg on a hind leg, which is as thick, bulges as it does and is hardly strained."""
    assert chance_as_it_lies(questions, half, half_likeness).chance > SURE
    mirrored = replace(half_likeness, handed=0.6)
    monkeypatch.setattr(skin_chance, "handed_by_relief", lambda *_: 0.65)
    assert chance_as_it_lies(questions, half, mirrored).chance < 0.1
    assert chance_where_it_slid(0.0, questions, half, mirrored).chance < 0.1


def test_what_goes_on_in_both_beyond_what_they_share_is_not_sure(
    questions, half, half_likeness, monkeypatch
) -> None:
    """Two forelegs with their shoulders: the legs are alike, and the shoulders lie apart."""
    monkeypatch.setattr(skin_chance, "ends_with_one", ends_with_one)
    assert chance_as_it_lies(questions, half, half_likeness).chance < 0.1
    assert chance_where_it_slid(0.0, questions, half, half_likeness).chance < 0.1


@pytest.mark.parametrize(("handed", "turned"), [(0.45, True), (0.55, False)])
def test_what_is_more_alike_mirrored_lies_on_its_twin(
    questions, home, half, home_likeness, monkeypatch, handed: float, turned: bool
) -> None:
    """A left leg on a right one, within what is joined, with all of its bumps."""
    monkeypatch.setattr(skin_chance, "handed_by_relief", lambda *_: handed)
    mirrored = replace(home_likeness, handed=handed)
    assert chance_as_it_lies(questions, home, mirrored).turned is turned
    assert not chance_as_it_lies(questions, half, mirrored).turned


@pytest.mark.parametrize(("form", "sure"), [(1.0, True), (0.4, False)])
def test_few_places_need_not_lead_where_the_skin_is_surer_than_of_another_one(
    questions, half, half_likeness, monkeypatch, form: float, sure: bool
) -> None:
    """Of a leg as much looks like the other leg as of another person like oneself."""
    few = replace(half_likeness, handed=0.85, leading=0.75)
    monkeypatch.setattr(skin_chance, "alike_in_form", lambda *_: form)
    said = chance_as_it_lies(questions, half, few)
    assert (said.chance >= JOINED) is sure
    assert said.by_skin > SURE


def test_what_lies_within_the_other_is_not_sure_by_its_skin(questions, home, home_likeness) -> None:
    said = chance_as_it_lies(questions, home, home_likeness)
    assert said.chance < 0.1
    assert said.by_skin > SURE


def test_what_was_likely_is_refused_where_it_slides_to_nothing_alike(
    questions, half_elsewhere
) -> None:
    """By accident a small place may have a relief that is alike before, at one width."""
    assert chance_where_it_slid(0.6, questions, *half_elsewhere).chance < 0.1


def test_of_what_lies_wholly_within_the_other_the_chance_only_falls(
    questions, home, home_likeness, elsewhere
) -> None:
    said = chance_where_it_slid(0.3, questions, home, home_likeness)
    assert said.chance == pytest.approx(0.3, abs=1e-3)
    assert slid_chance(0.9, questions, elsewhere).chance < 0.5


def test_what_lies_within_the_other_is_one_s_own_only_if_the_skin_is_sure(
    questions, home, home_likeness, monkeypatch
) -> None:
    """An arm of another person in the same pose is laid on an arm, and is as likely before."""
    monkeypatch.setattr(skin_chance, "alike_in_form", lambda *_: 0.7)
    other = replace(home_likeness, handed=0.72, leading=0.95)
    said = chance_where_it_slid(0.9, questions, home, other)
    assert said.by_skin > SURE
    assert said.chance < 0.1


def test_a_place_as_small_as_a_few_bumps_is_alike_by_accident(
    questions, half, half_likeness, monkeypatch
) -> None:
    """On a ring of a horse's leg a cat's may have the same three bumps."""
    monkeypatch.setattr(skin_chance, "alike_in_reliefs", lambda *_: 0.8)
    for area, sure in ((0.1, True), (0.02, False)):
        monkeypatch.setattr(skin_chance, "shared_area", lambda *_, area=area: area)
        assert (chance_as_it_lies(questions, half, half_likeness).chance >= JOINED) is sure


def test_skin_without_features_is_alike_by_accident(
    questions, half, half_likeness, monkeypatch
) -> None:
    """On a smooth trunk all that is seen is alike, and there is little to see."""
    for places, sure in ((40.0, True), (6.0, False)):
        monkeypatch.setattr(accident, "independent_places", lambda *_, places=places: places)
        assert (chance_as_it_lies(questions, half, half_likeness).chance >= JOINED) is sure
        assert (chance_where_it_slid(0.9, questions, half, half_likeness).chance >= JOINED) is sure


def test_what_is_not_as_thick_is_not_the_same_skin(
    questions, half, half_likeness, monkeypatch
) -> None:
    """Bumps are where they should be, but of another size."""
    monkeypatch.setattr(accident, "concordance_in", lambda *_: 0.3)
    said = chance_as_it_lies(questions, half, half_likeness)
    assert HALF_LIKELY <= said.by_skin < LIKELY
    assert chance_where_it_slid(0.9, questions, half, half_likeness).chance < LIKELY


@pytest.mark.parametrize(
    ("feature", "value", "expected"),
    [(7, 0.0, True), (7, 0.6, True), (4, -0.5, False), (5, 0.5, False), (6, 0.5, False)],
)
def test_what_is_likely_slides(feature: int, value: float, expected: bool) -> None:
    features = np.array([1.0, 0.72, 0.3, 0.0, 0.57, 0.07, 0.95, 0.1])
    features[feature] = value
    assert may_be_right(features) is expected
