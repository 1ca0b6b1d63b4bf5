"""The elastic shape: what it leaves alone, what it minimizes, how rotations and sizes go on."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sherd.fitting.as_rigid_as_possible import Elasticity
from sherd.fitting.sizes import STRETCH, mean_growth, sizes_of

TURN = Rotation.from_rotvec([0.3, -0.8, 0.5]).as_matrix()


@pytest.fixture(scope="module")
def elasticity(exhibit) -> Elasticity:
    full = exhibit.full
    return Elasticity(full.with_vertices(full.vertices / full.length))


def energy(elasticity, positions, turns, pulls, targets) -> float:
    """The formula of the module, edge by edge."""
    pointers, neighbors, weights, rest = elasticity.surface
    total = float((pulls * ((positions - targets) ** 2).sum(axis=1)).sum())
    for i in range(len(rest)):
        for entry in range(pointers[i], pointers[i + 1]):
            j = neighbors[entry]
            mean = 0.5 * (turns[i] + turns[j])
            off = positions[i] - positions[j] - mean @ (rest[i] - rest[j])
            total += 0.5 * weights[entry] * float(off @ off)
    return total


def test_a_turned_and_sized_shape_has_no_strain(elasticity) -> None:
    moved = 1.2 * elasticity.rest @ TURN.T + [1.0, 2.0, 3.0]
    rotations = elasticity.fitted_rotations(moved)
    assert np.allclose(rotations, TURN, atol=1e-9)
    assert np.allclose(elasticity.fitted_sizes(moved), 1.2)
    assert elasticity.strains(moved, 1.2 * rotations).max() < 1e-9
    assert elasticity.strains(moved, rotations) == pytest.approx(0.2)


def test_relaxation_is_where_the_energy_is_least(elasticity) -> None:
    rng = np.random.default_rng(3)
    count = len(elasticity.rest)
    turns = np.einsum("n,nij->nij", rng.uniform(0.9, 1.1, count), np.tile(TURN, (count, 1, 1)))
    pulls = rng.uniform(0, 5, count) * (rng.random(count) < 0.3)
    targets = elasticity.rest + 0.1 * rng.normal(size=(count, 3))
    least = elasticity.relaxation(pulls)(turns, targets, elasticity.rest)
    lowest = energy(elasticity, least, turns, pulls, targets)
    step = 1e-3 * rng.normal(size=(count, 3))
    ahead = energy(elasticity, least + step, turns, pulls, targets)
    behind = energy(elasticity, least - step, turns, pulls, targets)
    assert ahead > lowest
    assert abs(ahead - behind) < 1e-3 * (ahead + behind - 2 * lowest)  # the slope is zero


def test_smoothing_keeps_constants_and_continues_what_is_known(elasticity) -> None:
    count = len(elasticity.rest)
    known = (elasticity.rest[:, 0] > 0).astype(float)
    lengths = np.full(count, 0.1)
    ones = np.ones((count, 1))
    assert np.allclose(elasticity.smoothing(known, lengths)(7 * ones, 0 * ones), 7, atol=1e-4)
    slope = elasticity.rest[:, :1]
    smooth = elasticity.smoothing(known, lengths)(slope, 0 * ones)[:, 0]
    beyond = known == 0
    assert smooth[beyond].max() < slope[~beyond].max()
    assert smooth[beyond].min() > -0.05  # nothing new beyond the cut
    nobody = elasticity.smoothing(0 * known, lengths)(7 * ones, 3 * ones)
    assert np.allclose(nobody, 3, atol=1e-6)


def test_a_continuation_goes_on_as_values_change_and_comes_to_rest(elasticity) -> None:
    """A value that grows by 1 per length goes on by about the given length, and no farther."""
    height = elasticity.rest[:, 0]
    known = height < 0.05
    firm = known / 0.003**2
    ones = np.ones((len(height), 1))
    assert np.allclose(elasticity.continuation(firm, 0.1)(7 * ones, 0 * ones), 7, atol=1e-3)
    value = height[:, None]

    def farthest(length: float) -> float:
        found = elasticity.continuation(firm, length)(value, 0 * ones)[:, 0]
        assert np.abs(found - height)[known].max() < 0.01
        return float(found[~known].mean() - height[known].max())

    steps = [farthest(length) for length in (0.0, 0.03, 0.1)]
    assert steps[0] < steps[1] < steps[2]
    assert steps[0] < 0.0  # nothing new beyond what is known
    assert 0.02 < steps[2] < 0.15
    nobody = elasticity.continuation(0 * firm, 0.1)(7 * ones, 3 * ones)
    assert np.allclose(nobody, 3, atol=1e-4)


def test_what_was_seen_tells_its_rotation_whatever_lies_beyond(elasticity) -> None:
    seen = elasticity.rest[:, 0] > 0
    moved = elasticity.rest @ TURN.T
    moved[~seen] = 0.0
    rotations, known = elasticity.seen_rotations(moved, seen)
    assert np.allclose(rotations[known], TURN, atol=1e-9)
    assert not known[~seen].any()
    assert known[seen].mean() > 0.9
    assert not np.allclose(elasticity.fitted_rotations(moved)[known], TURN, atol=1e-3)


def test_a_pose_has_no_size_and_another_body_has(elasticity) -> None:
    seen = (elasticity.rest[:, 0] > 0).astype(float)
    stretched = elasticity.rest * [1.0, 1.0 + 0.5 * STRETCH, 1.0]
    assert np.array_equal(sizes_of(elasticity, stretched, seen, sizing="local"), np.ones(len(seen)))
    sizes = sizes_of(elasticity, 1.5 * elasticity.rest, seen, sizing="local")
    assert sizes == pytest.approx(1.5, rel=1e-3)


def test_the_size_of_another_individual_is_believed_as_it_is(elasticity) -> None:
    """What a pose could do as well; regions that differ from it by little stay at the mean."""
    seen = (elasticity.rest[:, 0] > 0).astype(float)
    larger = np.exp(0.5 * STRETCH) * elasticity.rest
    assert mean_growth(elasticity, larger, seen) == pytest.approx(0.5 * STRETCH, rel=1e-3)
    assert np.array_equal(sizes_of(elasticity, larger, seen, sizing="local"), np.ones(len(seen)))
    sizes = sizes_of(elasticity, larger * [1, 1.02, 1], seen, sizing="individual")
    assert np.ptp(sizes) < 1e-9
    assert sizes[0] == pytest.approx(np.exp(0.5 * STRETCH + 0.01), rel=0.005)
    assert mean_growth(elasticity, larger, 0 * seen) == 0
