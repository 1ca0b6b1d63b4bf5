"""Targets that lie beside their places come home by relief; exact and coarse ones stay."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.fitting import drift
from sherd.fitting.drift import without_drift
from sherd.fitting.targets import Targets
from sherd.mesh.surface_points import closest_points
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes import creature
from sherd.spectral.sampling import decimate


@pytest.fixture(scope="module")
def whole() -> TriangleMesh:
    mesh = creature(9000)
    return mesh.with_vertices(mesh.vertices / mesh.length)


def half(whole: TriangleMesh) -> tuple[TriangleMesh, np.ndarray]:
    """The half of the animal on one side of a plane, and which vertices it has."""
    axis = np.ptp(whole.vertices, axis=0).argmax()
    seen = whole.vertices[:, axis] > np.median(whole.vertices[:, axis])
    faces = whole.faces[seen[whole.faces].all(axis=1)]
    used, corners = np.unique(faces, return_inverse=True)
    mask = np.zeros(whole.vertex_count, dtype=bool)
    mask[used] = True
    return TriangleMesh(whole.vertices[used], corners.reshape(-1, 3)), mask


def drifted(whole: TriangleMesh, surface: TriangleMesh, seen: np.ndarray, by: float) -> Targets:
    """Targets that lie `by` beside their places, along the surface."""
    axis = np.ptp(whole.vertices, axis=0).argmax()
    beside = closest_points(surface, whole.vertices + by * np.eye(3)[axis]).positions(surface)
    return Targets(beside, seen.astype(np.float64))


def error(whole: TriangleMesh, targets: Targets) -> float:
    off = np.linalg.norm(targets.positions - whole.vertices, axis=1)
    return float(off[targets.seen].mean())


def test_what_drifted_comes_home(whole) -> None:
    surface, seen = half(whole)
    targets = drifted(whole, surface, seen, -0.015)
    found = without_drift(whole, targets, surface)
    assert error(whole, found) < 0.7 * error(whole, targets)
    assert (found.confidence == targets.confidence).all()
    assert (found.positions[~seen] == targets.positions[~seen]).all()


def test_what_is_exact_stays(whole) -> None:
    surface, seen = half(whole)
    targets = Targets(whole.vertices.copy(), seen.astype(np.float64))
    assert error(whole, without_drift(whole, targets, surface)) < 1e-4


def test_large_shapes_are_asked_at_a_moderate_size(whole, monkeypatch) -> None:
    surface, seen = half(whole)
    targets = drifted(whole, surface, seen, -0.015)
    monkeypatch.setattr(drift, "FINE", 4000)
    found = without_drift(whole, targets, surface)
    assert error(whole, found) < 0.85 * error(whole, targets)


def test_a_mesh_too_coarse_to_show_relief_moves_nothing(whole) -> None:
    coarse, _ = decimate(whole, 600)
    surface, seen = half(coarse)
    targets = drifted(coarse, surface, seen, -0.015)
    assert (without_drift(coarse, targets, surface).positions == targets.positions).all()


def test_a_piece_without_a_border_is_seen_all_over(whole) -> None:
    targets = drifted(whole, whole, np.ones(whole.vertex_count, dtype=bool), -0.015)
    found = without_drift(whole, targets, whole)
    assert error(whole, found) < 0.7 * error(whole, targets)
