"""Which side of an open surface is outside, as far as its shape tells."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from sherd.mesh.sides import bulge, turned_over
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes.creature import creature
from sherd.shapes.fragment import cut_by_plane, largest_piece, whole

SPHERE = trimesh.creation.icosphere(4)


def test_a_ball_has_one_and_half_a_ball_as_much_as_with_a_lid():
    ball = TriangleMesh(SPHERE.vertices, SPHERE.faces)
    assert bulge(ball) == pytest.approx(1.0, rel=0.01)
    assert bulge(turned_over(ball)) == pytest.approx(-bulge(ball))
    half, _ = ball.submesh((ball.vertices[ball.faces][:, :, 2] > -0.01).all(axis=1))
    # V = 2/3 pi, A = 3 pi
    assert bulge(half) == pytest.approx(36 * (2 / 3) ** 2 / 27, rel=0.15)


def test_a_flat_patch_has_none_and_half_an_animal_tells_its_outside():
    rows, columns = np.meshgrid(np.arange(5.0), np.arange(5.0))
    points = np.column_stack([rows.ravel(), columns.ravel(), np.zeros(25)])
    corner = np.arange(20)[np.arange(20) % 5 < 4]
    faces = np.column_stack([corner, corner + 1, corner + 5])
    assert bulge(TriangleMesh(points, faces)) == pytest.approx(0.0, abs=1e-12)
    animal = creature(5000)
    half = largest_piece(cut_by_plane(whole(animal, animal), [0.0, 0.0, 0.0], [1.0, 0.3, 0.1]))
    assert bulge(half.mesh) > 0.05
