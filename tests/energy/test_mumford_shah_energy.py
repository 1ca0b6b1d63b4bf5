from __future__ import annotations

import numpy as np
import pytest

from sherd.energy import mumford_shah as ms
from sherd.energy.batched_energy import BatchedEnergy
from sherd.energy.problem import EnergyWeights, region_problem
from sherd.errors import InfeasibleError, InputError, OptionError
from sherd.mesh.triangle_mesh import TriangleMesh


def fields(count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.random(count), rng.random(count)


def taylor_slope(function, gradient, point, direction) -> float:
    """Order in h of `f(x + h d) - f(x) - h g.d`: 2 for a right gradient, 1 for a wrong one."""
    steps = np.array([1e-3, 1e-4, 1e-5])
    base, slope = function(point), float(gradient @ direction)
    rest = [abs(function(point + h * direction) - base - h * slope) for h in steps]
    return float(np.polyfit(np.log(steps), np.log(rest), 1)[0])


def test_gradients_have_second_order_remainders(cap_problem) -> None:
    problem = cap_problem.with_evidence(np.linspace(-1, 1, cap_problem.vertex_count))
    u, rho = fields(problem.vertex_count)

    def of_u(v: np.ndarray) -> float:
        return ms.energy(problem, v, rho).total

    def of_rho(v: np.ndarray) -> float:
        return ms.energy(problem, u, v).total

    for function, gradient, point in (
        (of_u, ms.membership_gradient(problem, u, rho), u),
        (of_rho, ms.phase_gradient(problem, u, rho), rho),
    ):
        direction = gradient / np.linalg.norm(gradient)  # where a wrong factor shows
        assert taylor_slope(function, gradient, point, direction) > 1.95
        assert taylor_slope(function, 1.01 * gradient, point, direction) < 1.2


def test_smoothness_is_one_number_seen_from_both_steps(cap_problem) -> None:
    u, rho = fields(cap_problem.vertex_count)
    from_u = u @ (ms.smoothness_matrix(cap_problem, rho) @ u)
    from_rho = rho @ (ms.gradient_weight(cap_problem, u) * rho)
    assert from_u == pytest.approx(from_rho, rel=1e-12)
    ones = np.ones_like(rho)
    plain = ms.smoothness_matrix(cap_problem, ones) - cap_problem.stiffness
    assert abs(plain).max() < 1e-12
    energy = BatchedEnergy(cap_problem)
    value, _ = energy(u[:, None], energy.edge_weights(rho[:, None]), 0.0)
    terms = ms.energy(cap_problem, u, rho)
    assert value[0] == pytest.approx(terms.data + terms.smoothness, rel=1e-12)
    batched = energy.gradient_weights(u[:, None])[:, 0]
    assert np.allclose(batched, ms.gradient_weight(cap_problem, u), rtol=1e-10, atol=1e-14)


def test_phase_quadratic_is_the_energy(cap_problem) -> None:
    u, rho = fields(cap_problem.vertex_count)
    matrix, linear, constant = ms.phase_quadratic(cap_problem, u)
    quadratic = rho @ (matrix @ rho) + linear @ rho + constant
    terms = ms.energy(cap_problem, u, rho)
    weights = cap_problem.weights
    assert weights.regularity * quadratic == pytest.approx(terms.smoothness + terms.boundary)


def test_energy_has_no_unit(bumpy_sphere, cap, cap_problem) -> None:
    scale, strength = 37.0, 0.01
    big = bumpy_sphere.with_vertices(scale * bumpy_sphere.vertices)
    descriptors = strength * cap_problem.descriptors
    rescaled = region_problem(
        big,
        full_descriptors=descriptors,
        part_integral=descriptors.T @ (big.vertex_areas * cap),
        part_area=scale**2 * cap_problem.part_area,
        weights=cap_problem.weights,
    )
    u, rho = fields(cap_problem.vertex_count)
    first, second = ms.energy(cap_problem, u, rho), ms.energy(rescaled, u, rho)
    assert first.data == pytest.approx(second.data)
    assert first.smoothness == pytest.approx(second.smoothness)
    assert first.boundary == pytest.approx(second.boundary)


def test_boundary_term_measures_length() -> None:
    """The optimal profile `1 - exp(-|x| / 2 eps)` across a line costs its length (Gamma limit)."""
    count = 401
    x = np.linspace(-1, 1, count)
    vertices = np.concatenate([np.column_stack([x, 0 * x + y, 0 * x]) for y in (0.0, 0.01)])
    i = np.arange(count - 1)
    faces = np.concatenate(
        [
            np.column_stack([i, i + 1, i + 1 + count]),
            np.column_stack([i, i + 1 + count, i + count]),
        ]
    )
    strip = TriangleMesh(vertices, faces)
    width = 0.1  # of sqrt(s) = 0.1: 0.01 in x, two mesh widths
    problem = region_problem(
        strip,
        full_descriptors=np.ones((2 * count, 1)),
        part_integral=[0.01],
        part_area=0.01,
        weights=EnergyWeights(regularity=1.0, phase_width=width),
    )
    profile = 1 - np.exp(-np.abs(np.tile(x, 2)) / (2 * width * 0.1))
    # the line has length 0.01, a tenth of sqrt(s); the mesh resolves the kink to a few percent
    assert ms.boundary_term(problem, profile) == pytest.approx(0.1, rel=0.05)


def test_questions_without_answer_are_refused(bumpy_sphere) -> None:
    count, area = bumpy_sphere.vertex_count, bumpy_sphere.area
    good = {"full_descriptors": np.ones((count, 2)), "part_integral": [1.0, 1.0]}
    with pytest.raises(InfeasibleError, match=r"1\.100 times the area"):
        region_problem(bumpy_sphere, **good, part_area=1.1 * area)
    assert region_problem(bumpy_sphere, **good, part_area=1.04 * area).part_area == area
    for bad in (0.0, -1.0, np.nan):
        with pytest.raises(InfeasibleError, match="positive area"):
            region_problem(bumpy_sphere, **good, part_area=bad)
    with pytest.raises(InputError, match="zero"):
        region_problem(bumpy_sphere, **{**good, "part_integral": [0, 0]}, part_area=1.0)
    with pytest.raises(InputError, match="NaN"):
        region_problem(bumpy_sphere, **{**good, "part_integral": [np.nan, 0]}, part_area=1.0)
    with pytest.raises(InputError, match=r"\(642, d\)"):
        region_problem(
            bumpy_sphere, full_descriptors=np.ones((3, 2)), part_integral=[1, 1], part_area=1.0
        )
    with pytest.raises(OptionError, match="phase_width"):
        EnergyWeights(phase_width=0.0)
