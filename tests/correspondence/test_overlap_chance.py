"""The chance that an overlap is right, and what lowers it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from sherd.correspondence.shared import judgment
from sherd.correspondence.shared.judgment import mirror_is_better, overlap_chance

COUNT = 20
WELL = {
    "agreement": 0.9, "worth": 0.15, "apart": 0.012, "first": 0.4, "mirrored": 0.4, "open": 0.3
}  # fmt: skip


@pytest.fixture(autouse=True)
def _open_as_told(monkeypatch) -> None:
    monkeypatch.setattr(judgment, "open_seam", lambda _, place: place.open)


def chance(**changes: float) -> float:
    """Of an answer that is right, but for the changes."""
    told = {**WELL, **changes}
    mesh = SimpleNamespace(vertex_areas=np.full(COUNT, 1.0 / COUNT))
    question = SimpleNamespace(part=SimpleNamespace(mesh=mesh))
    place = SimpleNamespace(
        shared=np.ones(COUNT, bool), apart=np.full(COUNT, told["apart"]), open=told["open"]
    )
    labelings = SimpleNamespace(
        agreement=told["agreement"], worth=told["worth"], first_ratio=told["first"]
    )
    return overlap_chance(labelings, told["mirrored"], (question, question), (place, place))


def test_what_agrees_is_alike_and_misses_nothing_is_sure() -> None:
    assert chance(worth=0.35, apart=0.005, open=0.0) > 0.9


@pytest.mark.parametrize(
    "worse",
    [{"agreement": 0.5}, {"worth": -1.0}, {"apart": 0.02}, {"mirrored": 0.3}, {"open": 2.0}],
)
def test_each_thing_that_is_worse_lowers_the_chance(worse: dict[str, float]) -> None:
    assert chance(**worse) < chance() - 0.1


def test_a_limb_of_the_other_side_is_not_believed_however_well_it_agrees() -> None:
    """As far as measured: the mirror image of a leg is better by 0.07 and more."""
    assert chance(first=0.7, mirrored=0.45, apart=0.01) < 0.2
    assert mirror_is_better(0.7, 0.5)
    assert not mirror_is_better(0.7, 0.68)


def test_a_chance_is_never_certain() -> None:
    best = {"agreement": 1.0, "worth": 1.0, "apart": 0.0, "mirrored": 1.0}
    worst = {"agreement": 0.0, "worth": -5.0, "apart": 0.3, "mirrored": 0.0}
    assert 0.0 < chance(**worst) < 0.01
    assert 0.99 < chance(**best) < 1.0
