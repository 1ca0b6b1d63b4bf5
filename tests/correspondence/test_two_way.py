"""Both directions of a pair of which one shape holds the other: each hears of the other."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from sherd.correspondence.labels import two_way
from sherd.correspondence.labels.inverse import (
    COVERED,
    closing_nodes,
    following,
    inverse_labeling,
)
from sherd.correspondence.labels.labeling import Labeling, Problem, labeling_problem
from sherd.correspondence.labels.saved import PRICE_SHARE
from sherd.correspondence.labels.two_way import (
    Agreed,
    TwoLabelings,
    finished,
    labeled_around,
    two_way_labelings,
)

SHIFTS = 16
SPACING = 0.05


@pytest.fixture(scope="module")
def there(planted) -> Problem:
    """The nodes of the piece know their labels on the blob."""
    nodes, labels = len(planted.labels), len(planted.question.full.dense)
    similarity = np.random.default_rng(1).uniform(0.0, 0.4, (nodes, labels, SHIFTS))
    grid = 2 * np.pi * np.arange(SHIFTS) / SHIFTS
    turns = np.cos(grid - planted.rotations[:, None])
    similarity[np.arange(nodes), planted.labels] = 0.5 + 0.35 * turns
    return labeling_problem(
        planted.question, similarity.astype(np.float32), np.random.default_rng(2)
    )


@pytest.fixture(scope="module")
def truth(planted) -> Labeling:
    count = len(planted.labels)
    return Labeling(planted.labels, planted.rotations, np.zeros(count), 0.0)


def misplaced(planted, labeling: Labeling) -> np.ndarray:
    """(k,) how far the label of each node of the blob lies from the node itself."""
    full, part = planted.question.full, planted.question.part
    places = full.mesh.vertices[planted.kept[part.dense.vertices[labeling.labels]]]
    return np.linalg.norm(places - full.mesh.vertices[full.sparse.vertices], axis=1)


def inside(planted) -> np.ndarray:
    """(k,) distance of each node of the blob to the piece."""
    full = planted.question.full
    tree = cKDTree(full.mesh.vertices[planted.kept])
    return tree.query(full.mesh.vertices[full.sparse.vertices])[0]


def test_an_inverse_labeling_covers_what_the_other_direction_does(planted, back, truth) -> None:
    labeling = inverse_labeling(back, truth)
    off = inside(planted)
    assert labeling.placed[off == 0].mean() > 0.97
    assert not labeling.placed[off > COVERED].any()  # far beyond the border it is nowhere
    assert misplaced(planted, labeling)[labeling.placed].max() < COVERED + SPACING
    assert closing_nodes(back, labeling, truth)[off == 0].mean() > 0.9


def test_an_inverse_of_nothing_is_nowhere(back, truth) -> None:
    nothing = replace(truth, placed=np.zeros(len(truth.labels), dtype=bool))
    assert not inverse_labeling(back, nothing).placed.any()


def test_a_direction_that_keeps_nothing_is_the_inverse_of_the_other_again(
    there, back, truth
) -> None:
    problems, inverse = (there, back), inverse_labeling(back, truth)
    nothing = replace(inverse, placed=np.zeros(len(inverse.labels), dtype=bool))
    kept = following(problems, (truth, nothing))
    assert kept[0] is truth
    assert (kept[1].placed == inverse.placed).all()
    assert (kept[1].labels == inverse.labels).all()
    lost = replace(truth, placed=np.zeros(len(truth.labels), dtype=bool))
    assert following(problems, (lost, inverse))[0].placed.any()
    for pair in ((truth, inverse), (lost, nothing)):
        assert following(problems, pair) == pair


@pytest.fixture(scope="module")
def both(there, back) -> TwoLabelings:
    return two_way_labelings(there, back, (np.random.default_rng(5), np.random.default_rng(5)))


def test_a_direction_that_knows_nothing_follows_the_other(planted, both) -> None:
    full = planted.question.full
    assert both.forward_agrees.mean() > 0.8
    there = full.dense.between[both.forward.labels, planted.labels][both.forward_agrees]
    assert there.max() < SPACING
    deep = inside(planted) == 0
    assert both.backward_agrees[deep].mean() > 0.6
    assert misplaced(planted, both.backward)[both.backward_agrees].max() < COVERED + SPACING


def test_swapping_the_shapes_swaps_the_labelings(there, back, both) -> None:
    rngs = (np.random.default_rng(5), np.random.default_rng(5))
    swapped = two_way_labelings(back, there, rngs)
    assert (swapped.forward_agrees == both.backward_agrees).all()
    assert (swapped.backward.labels == both.forward.labels).all()
    assert swapped.agreement == both.agreement


def saving(monkeypatch, *, again: list[float], filled: float) -> tuple[Agreed, list[float]]:
    """What is left of an answer that saves 1, by what rounds save, and the price of each round."""
    left, prices = list(again), []

    def round_of(*_: Any, labeled: Any, price: float = PRICE_SHARE, **__: Any) -> Agreed:
        prices.append(price)
        if labeled is labeled_around:
            return Agreed(nothing, nothing, 0.9, filled)
        return Agreed(nothing, nothing, 0.4, left.pop(0))

    nothing: Any = (None, None)
    monkeypatch.setattr(two_way, "_agreed", round_of)
    begun = Agreed(nothing, nothing, 0.3, 1.0)
    return finished(nothing, (1.0, 1.0), begun), prices


def test_what_is_kept_grows_at_last_into_what_did_not_agree(monkeypatch) -> None:
    """Where nowhere costs as much as at the start, if that saves more by the price of half."""
    best, prices = saving(monkeypatch, again=[2.0, 1.5], filled=3.0)
    assert best.saved == 3.0
    assert best.agreement == 0.4  # what only hears of what agrees does agree
    assert prices == [PRICE_SHARE, PRICE_SHARE, two_way.STARTING_PRICE]
    best, _ = saving(monkeypatch, again=[2.0, 1.5], filled=1.8)
    assert best.saved == 2.0
