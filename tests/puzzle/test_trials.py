"""Which trials are chosen, and what their chances are among the other places of the same piece."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from sherd.assemble import assemble
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.output import Stages
from sherd.puzzle import against, trials
from sherd.puzzle.company import choice_in_company
from sherd.puzzle.joint_choice import Candidate
from sherd.puzzle.trials import Trial, chosen_together
from sherd.results.match_options import MatchOptions
from sherd.scan.intake import scan_intake
from sherd.shapes import creature, cut_by_ball, whole

from .test_joint_choice import MESH, candidate


def trial(piece: int, lies: Candidate) -> Trial:
    """A piece that lies there, wherever it came from."""
    return Trial(piece, None, None, lies)


def chances(*some: Trial) -> dict[int, float]:
    count = 1 + max(each.piece for each in some)
    chosen = chosen_together(some, count, MESH.vertex_areas).trials
    return {piece: each.chance for piece, each in chosen.items()}


def test_a_piece_that_could_lie_in_another_place_as_well_is_in_doubt() -> None:
    left, right = candidate(0.0, 0.4, 0.7), candidate(0.6, 1.0, 0.5)
    assert chances(trial(0, left)) == {0: pytest.approx(0.7)}
    # odds of 7 : 3 and of 1 : 1 against nowhere
    both = chances(trial(0, left), trial(0, right))
    assert both == {0: pytest.approx((7 / 3) / (1 + 7 / 3 + 1))}


def test_a_place_that_another_piece_has_and_the_same_place_again_raise_no_doubt() -> None:
    left, right = candidate(0.0, 0.25, 0.7), candidate(0.75, 1.0, 0.5)
    sure = candidate(0.75, 1.0, 0.95)
    assert chances(trial(0, left), trial(0, right), trial(1, sure))[0] == pytest.approx(0.7)
    again = candidate(0.0, 0.26, 0.6)
    assert chances(trial(0, left), trial(0, again))[0] == pytest.approx(0.7)


def test_what_is_chosen_for_a_gap_but_does_not_belong_there_is_refused(monkeypatch) -> None:
    def with_doubt(pieces, areas, *, may_overlap):
        choice, judged = choice_in_company(pieces, areas, may_overlap=may_overlap)
        # what fills a gap is likely enough to be chosen, and the chance that is given is less
        lower = [[replace(each, chance=each.chance / 10) for each in some] for some in judged[1:]]
        return choice, [judged[0], *lower]

    monkeypatch.setattr(trials, "choice_in_company", with_doubt)
    sure, left, right = (
        trial(0, candidate(0.0, 0.4, 0.9)),
        trial(1, candidate(0.4, 0.7, 0.6)),
        trial(1, candidate(0.7, 1.0, 0.5)),
    )
    assert chances(sure, left, right) == {0: pytest.approx(0.9)}
    monkeypatch.setattr(trials, "FOREIGN", 0.04)
    assert set(chances(sure, left, right)) == {0, 1}


def test_where_something_speaks_against_it_a_piece_must_be_likelier() -> None:
    unlikely = trial(0, candidate(0.0, 0.4, 0.5))
    lowered = 1 / (1 + np.exp(1.0))
    assert chances(replace(unlikely, against=-1.0)) == {0: pytest.approx(lowered)}
    assert chances(replace(unlikely, against=-2.0)) == {}
    # the place that something speaks against may not be chosen for being the larger one
    left, right = trial(0, candidate(0.0, 0.5, 0.7)), trial(0, candidate(0.6, 1.0, 0.6))
    chosen = chosen_together([replace(left, against=-3.0), right], 1, MESH.vertex_areas)
    assert chosen.trials[0].candidate.region is right.candidate.region


def test_what_hardly_speaks_against_a_piece_does_not_raise_the_bar() -> None:
    there = trial(0, candidate(0.0, 0.4, 0.15))
    assert not replace(there, against=-0.9).is_unlikely
    assert replace(there, against=-1.1).is_unlikely


@pytest.mark.parametrize(
    ("alike", "double", "said"),
    [(None, 0.0, 0.0), (0.9, 0.1, 0.0), (0.18, 0.0, -1.5), (0.9, 0.3, -2.6), (0.18, 0.3, -4.1)],
)
def test_skin_and_folds_speak_against_a_place_or_say_nothing(
    monkeypatch, alike, double, said
) -> None:
    monkeypatch.setattr(against, "share_laid_double", lambda part, deformation: double)
    placement = SimpleNamespace(question=SimpleNamespace(part=None), deformation=None)
    assert against.log_odds_against(placement, alike) == pytest.approx(said)


def test_a_rival_elsewhere_is_no_trial_of_its_own(monkeypatch) -> None:
    def placement(score: float, *rows: int) -> SimpleNamespace:
        return SimpleNamespace(score=score, mask=np.isin(np.arange(4), rows))

    monkeypatch.setattr(trials, "_seen_there", lambda trial: trial)
    monkeypatch.setattr(trials, "trial_at", lambda piece, placed, *_, **__: placed.best)
    best = placement(0.8, 0, 1)
    placed = SimpleNamespace(
        chance=0.5, best=best, other=placement(0.7, 0, 1), rival=placement(0.79, 2, 3)
    )
    assert trials.trials_of(0, placed, None) == [best]


@pytest.mark.parametrize(("energy", "asked"), [(1.2, ["one", "other"]), (1.4, ["one"])])
def test_a_piece_in_doubt_is_laid_turned_over_if_its_labels_may_be_as_good(
    monkeypatch, energy, asked
) -> None:
    laid = []

    def lay(side: str) -> SimpleNamespace:
        laid.append(side)
        best = SimpleNamespace(score=len(laid))  # the second is better
        return SimpleNamespace(best=best, chance=0.3, labeling_energy=1.0)

    monkeypatch.setattr(trials, "placed_part", lambda *_, **__: lay("one"))
    monkeypatch.setattr(trials, "labeled_part", lambda *_, **__: SimpleNamespace(energy=energy))
    monkeypatch.setattr(trials, "laid_part", lambda *_: lay("other"))
    monkeypatch.setattr(trials, "trials_of", lambda *found: [found[1]])
    full = creature(5000)
    intake = scan_intake(cut_by_ball(whole(full, full), 0, 0.4).mesh)
    template = SimpleNamespace(intake=scan_intake(full))
    found, _ = trials.trials_alone(template, [intake], MatchOptions(), Stages(visible=False), None)
    assert laid == asked
    assert [each.best.score for each in found] == [len(asked)]


def test_a_piece_that_is_inside_out_is_placed() -> None:
    full = creature(5000)
    part = cut_by_ball(whole(creature(5000, pose="walk"), full), 0, 0.4).mesh
    inside_out = TriangleMesh(part.vertices, part.faces[:, ::-1])
    right, turned = (assemble(full, [mesh]).pieces[0] for mesh in (part, inside_out))
    assert right.placed
    assert turned.placed
    assert turned.match.best.score == pytest.approx(right.match.best.score, abs=0.02)
