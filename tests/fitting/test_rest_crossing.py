"""What pierces itself in the full shape pierces itself likewise in the fit, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.fitting.as_rigid_as_possible import Elasticity
from sherd.fitting.deformation import Deformation, with_rings
from sherd.fitting.mending.crossing import new_crossings, without_new_crossings
from sherd.fitting.mending.rest_crossing import rest_crossings, with_rest_crossings
from sherd.fitting.mending.self_intersection import intersecting_faces, intersecting_pairs
from sherd.mesh.triangle_mesh import TriangleMesh


@pytest.fixture(scope="module")
def lips() -> Elasticity:
    """Two layers that lie above each other, tied at one edge, and touch through a bump of each."""
    count = 41
    along, across = np.meshgrid(np.linspace(-1, 1, count), np.linspace(-1, 1, count), indexing="ij")
    bump = 0.17 * np.exp(-((along - 0.01) ** 2 + (across - 0.1) ** 2) / 0.03)
    other = 0.16 * np.exp(-((along + 0.02) ** 2 + (across - 0.13) ** 2) / 0.03)
    lower = np.stack([along, across, -0.15 + bump], axis=-1).reshape(-1, 3)
    # not vertex above vertex, where edges would only touch
    upper = np.stack([along + 0.013, across + 0.017, 0.15 - other], axis=-1).reshape(-1, 3)
    k, j = np.meshgrid(np.arange(count - 1), np.arange(count - 1), indexing="ij")
    a, b = (count * k + j).ravel(), (count * k + j + 1).ravel()
    c, d = a + count, b + count
    sheet = np.concatenate([np.stack([a, c, d], -1), np.stack([a, d, b], -1)])
    edge = count * np.arange(count)
    low, next_low = edge[:-1], edge[1:]
    tie = np.concatenate(
        [
            np.stack([low, next_low + len(lower), next_low], -1),
            np.stack([low, low + len(lower), next_low + len(lower)], -1),
        ]
    )
    faces = np.concatenate([sheet, sheet[:, ::-1] + len(lower), tie])
    mesh = TriangleMesh(np.concatenate([lower, upper]), faces)
    return Elasticity(mesh.with_vertices(mesh.vertices / mesh.length))


def noisy(lips: Elasticity, amount: float) -> Deformation:
    """Turned and moved; the lower layer beside where it should be, most in its middle."""
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    positions, half = lips.rest.copy(), len(lips.rest) // 2
    there = np.exp(-(positions[:half, :2] ** 2).sum(axis=1) / 0.1**2)
    positions[:half] += amount * there[:, None] * np.array([0.6, 0.0, 0.8])
    positions = positions @ turn.T + [1.0, 2.0, 3.0]
    rotations = lips.fitted_rotations(positions)
    return Deformation(positions, rotations, np.ones(len(positions)))


def places_of(elasticity: Elasticity) -> list[np.ndarray]:
    """Where faces pierce each other in the shape itself."""
    return rest_crossings(elasticity, intersecting_pairs(elasticity.rest, elasticity.mesh.faces))


def test_a_place_is_both_of_its_layers(lips) -> None:
    (place,) = places_of(lips)
    crossing = intersecting_faces(lips.rest, lips.mesh.faces)
    assert 4 < crossing.sum() < 200
    assert (np.sort(place) == np.unique(lips.mesh.faces[crossing])).all()
    half = len(lips.rest) // 2
    assert (place < half).any()
    assert (place >= half).any()


def test_what_crossed_before_crosses_as_it_did(lips) -> None:
    found = noisy(lips, 0.004)
    assert new_crossings(lips, found) > 0
    seen = np.ones(len(lips.rest), dtype=bool)
    answer = without_new_crossings(lips, found, seen)
    faces = lips.mesh.faces
    before, after = (intersecting_faces(x, faces) for x in (lips.rest, answer.positions))
    assert (before == after).all()
    moved = np.linalg.norm(answer.positions - found.positions, axis=1)
    assert moved.max() < 0.004
    place = np.isin(np.arange(len(lips.rest)), places_of(lips)[0])
    assert (moved[~with_rings(lips, place, 4 + 8 + 1)] == 0).all()


def test_what_bent_is_no_body(lips) -> None:
    found = noisy(lips, 0.05)
    crossing = np.flatnonzero(intersecting_faces(found.positions, lips.mesh.faces))
    places = places_of(lips)
    assert with_rest_crossings(lips, found, places, crossing, 1) is found


def test_places_near_no_fault_stay(lips) -> None:
    found = noisy(lips, 0.004)
    nothing = np.empty(0, dtype=np.int64)
    assert with_rest_crossings(lips, found, places_of(lips), nothing, 1) is found


def test_a_shape_that_pierces_nothing_has_no_places() -> None:
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    assert places_of(Elasticity(TriangleMesh(corners, faces))) == []
