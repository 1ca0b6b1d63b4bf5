"""Small groups to start from where right labels are similar, but not the most similar ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sherd.correspondence.labels.consistent import PLACE_WIDTH, node_areas, same_place
from sherd.correspondence.labels.inverse import inverse_labeling
from sherd.correspondence.labels.labeling import Labeling, Problem, labeling_problem
from sherd.correspondence.labels.local_groups import CANDIDATES, local_groups
from sherd.correspondence.labels.places import SAID, UNEQUAL, followed, not_said_before
from sherd.correspondence.labels.two_way import TwoLabelings, two_way_labelings
from sherd.correspondence.shared import places_by_form
from sherd.correspondence.shared.places_by_form import finished_place, labelings_by_form
from sherd.correspondence.shared.relief_correlation import alike_at_labels

SHIFTS = 16
CHANCE = 20.0
CLOSE = 0.05


def patch_of(planted) -> np.ndarray:
    """(k,) bool: a third of the nodes, which know where they lie; the others know nothing."""
    part = planted.question.part
    height = part.mesh.vertices[part.sparse.vertices][:, 2]
    return height < np.quantile(height, 0.33)


def forward_problem(planted) -> Problem:
    """Of each node two thirds of the candidates look more like it than its right label does."""
    rng = np.random.default_rng(1)
    nodes, labels = len(planted.labels), len(planted.question.full.dense)
    similarity = rng.uniform(0.0, 0.4, (nodes, labels, SHIFTS))
    grid = 2 * np.pi * np.arange(SHIFTS) / SHIFTS
    for node in range(nodes):
        wrong = rng.choice(labels, 2 * CANDIDATES // 3, replace=False)
        similarity[node, wrong, rng.integers(SHIFTS, size=len(wrong))] = 0.75
    known = np.flatnonzero(patch_of(planted))
    turns = np.cos(grid - planted.rotations[known, None])
    similarity[known, planted.labels[known]] = 0.4 + 0.3 * turns
    return labeling_problem(planted.question, similarity.astype(np.float32), rng)


@pytest.fixture(scope="module")
def there(planted) -> Problem:
    return forward_problem(planted)


def test_the_first_group_is_where_neighbors_agree_and_not_where_likeness_is_highest(
    planted, there
) -> None:
    first = local_groups(there, CHANCE, 4)[0]
    assert first.placed.sum() > 10
    off = there.labels.between[first.labels, planted.labels][first.placed]
    assert (off < CLOSE).mean() > 0.9
    assert patch_of(planted)[first.placed].mean() > 0.9


def test_no_group_begins_where_an_earlier_one_lies(there) -> None:
    groups = local_groups(there, CHANCE, 8)
    assert len(groups) == 8
    for count, group in enumerate(groups):
        new = group.placed.copy()
        for earlier in groups[:count]:
            near = there.labels.between[group.labels, earlier.labels] < PLACE_WIDTH
            new &= ~(earlier.placed & near)
        assert new.any()


@pytest.fixture(scope="module")
def known(there, back) -> TwoLabelings:
    return two_way_labelings(there, back, (np.random.default_rng(5), np.random.default_rng(5)))


@pytest.fixture(scope="module")
def nowhere(known) -> TwoLabelings:
    """Nothing is known but what chance costs."""
    return replace(
        known,
        forward_agrees=np.zeros_like(known.forward_agrees),
        backward_agrees=np.zeros_like(known.backward_agrees),
    )


def most_right(planted, places: list[TwoLabelings]) -> float:
    """Of the nodes that know where they lie the share that one of the places has right."""
    between = planted.question.full.dense.between
    patch = patch_of(planted)
    shares = [0.0]
    for found in places:
        off = between[found.forward.labels, planted.labels]
        shares.append((found.forward_agrees & (off < CLOSE))[patch].mean())
    return max(shares)


@pytest.fixture(scope="module")
def forms(planted) -> tuple[np.ndarray, np.ndarray]:
    """Something that changes over the blob, and over the piece as it does there."""
    x, y, z = planted.question.full.mesh.vertices.T
    field = np.sin(20 * x + 5 * y) + np.sin(17 * z - 8 * x) + np.sin(15 * y + 4 * z)
    return field[planted.kept], field


def test_the_place_that_goes_on_is_the_one_whose_form_is_alike(
    planted, there, back, nowhere, forms, monkeypatch
) -> None:
    """What the right place saves is the same with either form."""
    monkeypatch.setattr(places_by_form, "LEFT", (1, 1))
    problems = (there, back)
    assert most_right(planted, labelings_by_form(problems, forms, nowhere)) > 0.8
    reverse = (forms[0], -forms[1])
    assert most_right(planted, labelings_by_form(problems, reverse, nowhere)) < 0.2


def test_the_starts_that_are_labeled_are_those_most_alike_in_form(
    planted, there, back, nowhere, forms, monkeypatch
) -> None:
    """Groups know before any round whether their form is alike; most are never labeled."""
    monkeypatch.setattr(places_by_form, "BEGUN", 2)
    problems = (there, back)
    assert most_right(planted, labelings_by_form(problems, forms, nowhere)) > 0.8
    reverse = (forms[0], -forms[1])
    assert most_right(planted, labelings_by_form(problems, reverse, nowhere)) < 0.2


def test_places_by_form_are_different_and_not_known(there, back, nowhere, forms) -> None:
    problems = (there, back)
    found = labelings_by_form(problems, forms, nowhere)
    assert 0 < len(found) <= places_by_form.LEFT[-1]
    for count, one in enumerate(found):
        assert not any(alike(problems, one, other) for other in found[:count])
    again = labelings_by_form(problems, forms, found[0])
    assert not any(alike(problems, each, found[0]) for each in again)


def test_a_place_that_may_be_believed_has_its_last_rounds(
    planted, there, back, nowhere, forms, monkeypatch
) -> None:
    problems = (there, back)
    begun = labelings_by_form(problems, forms, nowhere)[0]
    done = finished_place(problems, begun)
    assert alike(problems, done, begun)
    assert most_right(planted, [done]) >= most_right(planted, [begun])
    # what saves no more is what it was, so what was laid by it need not be laid again
    monkeypatch.setattr(places_by_form, "finished", lambda _, __, agreed: agreed)
    assert finished_place(problems, begun) is begun


def test_forms_are_alike_at_right_labels_and_prove_more_on_more_nodes(
    planted, there, back, forms
) -> None:
    right = all_right(planted, there, back)
    kept = (right.forward_agrees, right.backward_agrees)
    labelings = (right.forward, right.backward)

    def proved(found, agrees) -> float:
        return alike_at_labels(forms, (there, back), found, agrees)

    whole = proved(labelings, kept)
    assert whole > 0.8 * np.sqrt(np.mean(kept_areas((there, back), right)))
    half = (kept[0] & patch_of(planted), kept[1])
    assert proved(labelings, half) < 0.9 * whole
    wrong = tuple(replace(each, labels=np.roll(each.labels, 7)) for each in labelings)
    assert proved(wrong, kept) < 0.5 * whole
    nothing = tuple(np.zeros_like(each) for each in kept)
    assert proved(labelings, nothing) == 0.0


def alike(problems: tuple[Problem, Problem], one: TwoLabelings, other: TwoLabelings) -> bool:
    found = ((one.forward, one.backward), (other.forward, other.backward))
    kept = (
        (one.forward_agrees, one.backward_agrees),
        (other.forward_agrees, other.backward_agrees),
    )
    return same_place(problems, found, kept)


def kept_areas(problems: tuple[Problem, Problem], found: TwoLabelings) -> list[float]:
    kept = (found.forward_agrees, found.backward_agrees)
    return [float(node_areas(each)[own].sum()) for each, own in zip(problems, kept, strict=True)]


def all_right(planted, there, back) -> TwoLabelings:
    """Both directions where they belong, with the first one's rotations."""
    forward = Labeling(
        planted.labels,
        planted.rotations,
        np.zeros(len(planted.labels)),
        0.0,
        np.ones(len(planted.labels), dtype=bool),
    )
    backward = inverse_labeling(back, forward)
    return TwoLabelings(
        forward, backward, forward.placed, backward.placed, (20.0, 20.0), 1.0, 0.5, 0.0, 0.5
    )


def test_a_direction_that_keeps_far_less_follows_the_other_one(planted, there, back) -> None:
    right = all_right(planted, there, back)
    few = np.flatnonzero(right.backward_agrees)[:3]
    lost = replace(
        right,
        backward=replace(
            right.backward, labels=np.roll(right.backward.labels, 1), placed=right.backward.placed
        ),
        backward_agrees=np.isin(np.arange(len(right.backward.labels)), few),
    )
    found = followed((there, back), lost)
    areas = kept_areas((there, back), found)
    assert min(areas) > 0.8 * max(areas)
    others = found.backward_agrees.copy()
    others[few] = False
    assert np.array_equal(found.backward.labels[others], right.backward.labels[others])
    # what agreed stays as it was
    assert np.array_equal(found.backward.labels[few], lost.backward.labels[few])
    assert found.forward is lost.forward


def test_directions_that_keep_about_as_much_stay_as_they_are(planted, there, back) -> None:
    right = all_right(planted, there, back)
    kept = np.flatnonzero(right.backward_agrees)
    some = np.isin(np.arange(len(right.backward.labels)), kept[: int(0.8 * len(kept))])
    assert kept_areas((there, back), replace(right, backward_agrees=some))[1] > UNEQUAL
    unchanged = replace(right, backward_agrees=some)
    assert followed((there, back), unchanged) is unchanged


def moved_labels(labelings: TwoLabelings, share: float) -> TwoLabelings:
    """The same, so large a share of the nodes that are kept forward at the next label."""
    kept = np.flatnonzero(labelings.forward_agrees)
    labels = labelings.forward.labels.copy()
    labels[kept[: int(np.ceil(share * len(kept)))]] += 1
    return replace(labelings, forward=replace(labelings.forward, labels=labels))


def test_what_was_said_before_is_not_said_again(planted, there, back) -> None:
    right = all_right(planted, there, back)
    assert right.forward_agrees.all()
    nearly = moved_labels(right, 0.5 * (1 - SAID))
    other = moved_labels(right, 1.0)
    assert not_said_before([replace(right), nearly], right) == []
    assert not_said_before([nearly, other, replace(other)], right) == [other]
    # both directions count
    few = replace(right, backward_agrees=np.zeros_like(right.backward_agrees))
    assert not_said_before([few], right) == [few]
    assert not_said_before([replace(few)], few) == []


def test_what_agrees_more_is_another_answer_and_comes_first(planted, there, back) -> None:
    right = all_right(planted, there, back)
    doubted, other = replace(right, agreement=0.4), replace(moved_labels(right, 1.0), agreement=0.5)
    surer = replace(right, agreement=0.6)
    assert not_said_before([other, surer], doubted) == [surer, other]
