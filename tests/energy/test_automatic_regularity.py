from __future__ import annotations

import numpy as np
import pytest

from sherd.energy.automatic import REGULARITIES, chosen_regularity, crisp_energy
from sherd.energy.problem import RegionProblem
from sherd.energy.subspace import subspace_region
from sherd.errors import OptionError


def test_the_true_region_beats_ragged_and_shifted_ones(cap_problem, cap, bumpy_sphere) -> None:
    truth = cap.astype(bool)
    ragged = truth.copy()
    far = bumpy_sphere.vertices[:, 2] < -0.3
    swap = np.random.default_rng(0).permutation(np.flatnonzero(far))[:60]
    ragged[swap] = True
    shifted = bumpy_sphere.vertices[:, 0] > 0.55
    best = crisp_energy(cap_problem, truth)
    # the cap's rim is a circle of radius about 0.9, counted up to 1.3 times along edges
    rim = 2 * np.pi * 0.9 / np.sqrt(cap_problem.part_area)
    assert 0.2 * rim * 0.9 < best < 0.2 * rim * 1.4
    assert best < 0.7 * crisp_energy(cap_problem, ragged)
    assert best < 0.7 * crisp_energy(cap_problem, shifted)


def test_choice_avoids_the_useless_end(cap_problem, sphere_basis, cap) -> None:
    def solve(problem: RegionProblem) -> list[np.ndarray]:
        return [subspace_region(problem, sphere_basis, iterations=2).membership]

    choice = chosen_regularity(cap_problem, solve, candidates=(100.0, 0.01))
    assert choice.regularity == 0.01
    areas = cap_problem.vertex_areas
    assert areas @ (choice.core != cap.astype(bool)) < 0.15 * cap_problem.part_area
    assert choice.energies[1] < choice.energies[0]


def test_of_several_answers_the_best_is_named(cap_problem, cap, bumpy_sphere) -> None:
    wrong = (bumpy_sphere.vertices[:, 0] > 0.5).astype(float)
    choice = chosen_regularity(cap_problem, lambda _: [wrong, cap])
    assert choice.answer == 1
    assert choice.regularity == REGULARITIES[0]  # all tie, the first wins


def test_nothing_to_choose_from(cap_problem) -> None:
    with pytest.raises(OptionError, match="no candidate"):
        chosen_regularity(cap_problem, lambda _: [], candidates=())
    with pytest.raises(OptionError, match="no membership"):
        chosen_regularity(cap_problem, lambda _: [])
