"""A part sought from further starts: what fits better is the answer, the other place its rival."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sherd import place
from sherd.correspondence.by_relief import labeled_by_relief
from sherd.correspondence.found import Found, beside_relief
from sherd.correspondence.placements import anchor_problem
from sherd.output import Stages
from sherd.place import PlacedPart, labeled_again, labeled_part, laid_part, placed_part
from sherd.results.match_options import MatchOptions
from sherd.scan.intake import scan_intake
from sherd.shapes import Fragment, creature, cut_by_ball, whole
from sherd.surface.template import Template

SILENT = Stages(visible=False)


@pytest.fixture(scope="module")
def template() -> Template:
    return Template(creature(5000))


@pytest.fixture(scope="module")
def part(template: Template) -> Fragment:
    return cut_by_ball(whole(creature(5000, pose="walk"), template.full), 0, 0.3)


@pytest.fixture(scope="module")
def right(template: Template, part: Fragment) -> PlacedPart:
    return placed_part(template, scan_intake(part.mesh), MatchOptions(), SILENT, twin=False)


@pytest.fixture(scope="module")
def wrong(right: PlacedPart) -> PlacedPart:
    """The same part, laid where it does not belong."""
    return laid_part(labeled_again(right, ~right.best.mask, SILENT), SILENT)


def beside(placed: PlacedPart) -> Found:
    """As `place.py` asks by relief, wherever labels may lie."""
    question = replace(placed.question, free=None)
    labeling = labeled_by_relief(anchor_problem(question, np.random.default_rng(0)))
    best = replace(placed.best, question=question)
    found = Found(best, placed.other, placed.rival, placed.energies)
    return beside_relief(found, labeling, placed.queries, np.random.default_rng(0))


def error(found: Found | PlacedPart, part: Fragment) -> float:
    away = found.best.points.positions(part.full) - part.truth.positions(part.full)
    return float(np.linalg.norm(away, axis=1).mean() / part.full.length)


def test_relief_leads_from_a_wrong_place_to_the_right_one(right, wrong, part) -> None:
    assert error(wrong, part) > 0.1
    found = beside(wrong)
    assert error(found, part) < 1.2 * error(right, part)
    assert found.best.score > wrong.best.score
    assert found.chance > wrong.chance


def test_the_wrong_place_is_kept_as_the_rival_and_is_no_equal_one(wrong) -> None:
    found = beside(wrong)
    assert found.rival is not None
    np.testing.assert_array_equal(
        found.rival.deformation.positions, wrong.best.deformation.positions
    )
    assert found.equal_rival is None


def test_what_relief_leads_to_counts_only_where_the_part_fits_better(right) -> None:
    question = replace(right.question, free=~right.best.mask)
    astray = labeled_by_relief(anchor_problem(question, np.random.default_rng(0)))
    best = replace(right.best, question=question)
    found = Found(best, right.other, None, right.energies)
    after = beside_relief(found, astray, right.queries, np.random.default_rng(0))
    assert after.best is best
    assert after.energies == right.energies
    assert after.equal_rival is None


def test_in_one_place_the_energies_stay(right) -> None:
    worse = replace(right.best, score=right.best.score - 0.1)
    found = beside(replace(right, best=worse))
    assert found.best.score > worse.score
    assert found.energies == right.energies
    assert found.rival is None


def test_the_energy_of_labels_by_relief_is_that_of_normals_alone(right) -> None:
    problem = anchor_problem(right.question, np.random.default_rng(0))
    assert labeled_by_relief(problem).energy == pytest.approx(right.labeling_energy, rel=0.1)


@pytest.mark.parametrize(
    ("chance", "has_rival", "asked"),
    [(0.05, False, False), (0.05, True, False), (0.3, False, True), (0.9, False, False),
     (0.9, True, True)],
)  # fmt: skip
def test_relief_is_asked_where_a_part_may_belong_and_is_not_sure(
    chance, has_rival, asked, template, part, monkeypatch
) -> None:
    """Not where it surely lies or does not belong: one try more would only cost, or mislead."""
    calls = []

    def counted(found: Found, *_: object) -> Found:
        calls.append(found)
        return found

    monkeypatch.setattr(Found, "chance", property(lambda _: chance))
    monkeypatch.setattr(
        Found, "equal_rival", property(lambda found: found.best if has_rival else None)
    )
    monkeypatch.setattr(place, "beside_relief", counted)
    labeled = labeled_part(template, scan_intake(part.mesh), MatchOptions(), SILENT, twin=False)
    laid_part(labeled, SILENT)
    assert bool(calls) == asked
