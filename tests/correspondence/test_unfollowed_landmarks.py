"""Which landmarks are to blame when they cannot all be true."""

from __future__ import annotations

import numpy as np

from sherd.correspondence.unfollowed import contradictions, culprits
from sherd.results.advice import NAMED, Doubts, UnfollowedLandmark
from sherd.results.status import Status


def clash(*pairs: tuple[int, int], count: int = 5) -> np.ndarray:
    matrix = np.zeros((count, count), dtype=bool)
    for first, second in pairs:
        matrix[first, second] = matrix[second, first] = True
    return matrix


def test_the_one_that_contradicts_the_others_is_to_blame() -> None:
    assert not culprits(clash()).any()
    assert np.flatnonzero(culprits(clash((0, 3), (1, 3), (2, 3)))).tolist() == [3]
    # nobody knows which of two is wrong
    assert np.flatnonzero(culprits(clash((0, 3)))).tolist() == [0, 3]
    # two exchanged ones contradict all others
    exchanged = [(wrong, right) for wrong in (0, 1) for right in (2, 3, 4)]
    assert np.flatnonzero(culprits(clash(*exchanged))).tolist() == [0, 1]


def test_the_full_shape_may_be_shorter_but_not_longer() -> None:
    """Across a cut the part's way is longer; more than stretch and slack is a contradiction."""
    part = np.array([[0, 0.5], [0.5, 0]])
    assert not contradictions(part, part).any()
    assert not contradictions(part, 0.1 * part).any()
    assert not contradictions(part, 1.2 * part).any()
    assert contradictions(part, 1.3 * part).tolist() == [[False, True], [True, False]]
    assert not contradictions(np.full((2, 2), np.inf), part).any()  # in two pieces


def test_the_advice_names_landmarks_but_not_hundreds() -> None:
    few = Doubts(unfollowed=(UnfollowedLandmark(7, 9, 0.31, (4, 5)),))
    assert few.status is Status.DOUBTFUL
    assert "part vertex 7 on full vertex 9 (0.31 sqrt(area) from the answer" in few.advice
    assert "contradicts that of part vertex 4, 5)" in few.advice
    many = Doubts(unfollowed=tuple(UnfollowedLandmark(k, k, 0.1) for k in range(300)))
    assert f"{300 - NAMED} more" in many.advice
    assert len(many.advice) < 1000


def test_advice_is_that_of_the_status_if_there_is_no_more_to_say() -> None:
    assert Doubts().advice == Status.GOOD.advice
    assert Doubts(unlike=True).advice == Status.DOUBTFUL.advice
    assert Doubts(units="the sizes would fit if ...").status is Status.GOOD
    assert "would fit if" in Doubts(unlike=True, units="the sizes would fit if ...").advice
    assert "check the scale" not in Doubts(unlike=True, scale_unknown=True).advice
    assert Doubts(doubled=0.26).advice.startswith("doubtful: 26% of the part lie where another")
