"""The shared region is the minimum of its energy; there and back of the identity is no way."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from sherd.correspondence.labels.labeling import SAME_SCALE
from sherd.correspondence.question import Question
from sherd.correspondence.registration import Deformation
from sherd.correspondence.shared.region_cut import (
    INSIDE,
    WIDTH,
    mutual_components,
    shared_region,
)
from sherd.correspondence.shared.round_trip import on_border, round_trip
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.spectral.operators import stiffness
from sherd.surface.described import DescribedSurface
from sherd.surface.working import working_surface


def flat(count: int, size: float = 1.0) -> TriangleMesh:
    x, y = np.meshgrid(*2 * [np.linspace(0, size, count)], indexing="ij")
    number = np.arange(count * count).reshape(count, count)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    faces = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    return TriangleMesh(np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3), faces)


def energy(mesh: TriangleMesh, inside: np.ndarray, cost: np.ndarray, dear: np.ndarray) -> float:
    first, second = mesh.edges.T
    weights = -np.asarray(stiffness(mesh.vertices, mesh.faces).tocsr()[first, second]).ravel()
    lengths = np.linalg.norm(mesh.vertices[first] - mesh.vertices[second], axis=1)
    border = (dear * weights * lengths)[inside[first] != inside[second]].sum()
    return float(mesh.vertex_areas[inside] @ (cost[inside] - 1) + WIDTH * border)


@pytest.mark.parametrize("seed", range(5))
def test_no_other_set_of_vertices_has_less_energy(seed: int) -> None:
    mesh = flat(3, size=0.1)  # so small that borders matter
    rng = np.random.default_rng(seed)
    cost, goes_on = rng.uniform(0, 2, 9), rng.random(9) < 0.7
    dear = np.where(goes_on[mesh.edges].all(axis=1), INSIDE, 1.0)
    found = shared_region(mesh, cost, goes_on)
    sets = [np.array(s, bool) for s in product((0, 1), repeat=9)]
    least = min(energy(mesh, each, cost, dear) for each in sets)
    assert energy(mesh, found, cost, dear) == pytest.approx(least, abs=1e-9)


def test_a_shred_narrower_than_the_width_goes_with_its_surroundings() -> None:
    mesh = flat(41)
    x, y = mesh.vertices[:, 0], mesh.vertices[:, 1]
    wide = np.abs(x - 0.5) < 0.2
    cost = np.where(wide & (np.hypot(x - 0.5, y - 0.5) > 0.01), 0.5, 1.5)
    ends = np.zeros(len(x), dtype=bool)
    found = shared_region(mesh, cost, ends)
    assert found[wide].all()
    assert found.mean() == pytest.approx(wide.mean(), abs=0.05)
    assert not shared_region(mesh, np.full(len(x), 2.0), ends).any()


def test_a_component_that_the_other_shape_does_not_share_is_not_shared() -> None:
    mesh = flat(21)
    x, y = mesh.vertices[:, 0], mesh.vertices[:, 1]
    left, right = x < 0.35, x > 0.65
    # of the left one three fifths is mutual, of the right one two fifths
    mutual = np.where(left, y < 0.6, y < 0.4).astype(float)
    np.testing.assert_array_equal(mutual_components(mesh, left | right, mutual), left)
    assert not mutual_components(mesh, left, np.zeros(len(x))).any()
    assert mutual_components(mesh, left | right, np.ones(len(x))).sum() == (left | right).sum()


def test_a_region_goes_farther_where_the_other_shape_goes_on() -> None:
    mesh = flat(61)
    x, y = mesh.vertices[:, 0], mesh.vertices[:, 1]
    hole = np.hypot(x - 0.5, y - 0.5) < 0.1
    cost = np.where(hole, 1.6, 0.4)
    ends, goes_on = np.zeros(len(x), dtype=bool), np.ones(len(x), dtype=bool)
    assert not shared_region(mesh, cost, ends)[hole].all()
    assert shared_region(mesh, cost, goes_on).all()


def test_there_and_back_of_the_identity_is_no_way_and_over_the_border_is_told() -> None:
    mesh = flat(61)  # fine enough for no edge to be split
    surface = DescribedSurface(working_surface(mesh))
    question = Question(surface, surface, SAME_SCALE)
    still = np.tile(np.eye(3), (mesh.vertex_count, 1, 1))
    trip = round_trip(
        question, Deformation(mesh.vertices, still), Deformation(mesh.vertices, still)
    )
    assert trip.gap.max() < 1e-9
    assert trip.missed.max() < 1e-9
    assert not trip.beyond.any()
    shift = np.array([0.2, 0.0, 0.0])
    there = Deformation(mesh.vertices + shift, still)
    back = Deformation(mesh.vertices - shift, still)
    trip = round_trip(question, there, back)
    over = mesh.vertices[:, 0] + 0.2 > 1 + mesh.mean_edge_length
    assert np.array_equal(trip.beyond[over], np.ones(over.sum(), bool))
    inside = mesh.vertices[:, 0] + 0.2 < 1 - 1e-9
    assert trip.gap[inside].max() < 1e-9
    assert not trip.beyond[inside].any()


def test_a_point_is_on_the_border_if_all_corners_that_count_are() -> None:
    mesh = flat(4)
    middle = int(np.flatnonzero((mesh.faces == 5).any(axis=1))[0])
    corner = np.eye(3)[np.flatnonzero(mesh.faces[middle] == 5)[0]]
    assert not on_border(mesh, SurfacePoints([middle], [corner]))[0]
    outer = np.flatnonzero(np.isin(mesh.faces, mesh.boundary_vertices).sum(axis=1) >= 2)[0]
    weights = np.isin(mesh.faces[outer], mesh.boundary_vertices).astype(float)
    if weights.all():
        weights[2] = 0
    assert on_border(mesh, SurfacePoints([outer], [weights / weights.sum()]))[0]
