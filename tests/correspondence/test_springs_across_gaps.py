"""The elastic surface: springs across gaps between components, and only there."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.surface.elastic_surface import WIDEST_GAP, elastic_surface

SPACING = 0.02


def plates(gap: float) -> TriangleMesh:
    """Two plates of 6 x 11 vertices side by side."""
    rows, columns = np.meshgrid(np.arange(6), np.arange(11), indexing="ij")
    plate = SPACING * np.stack([rows.ravel(), columns.ravel(), np.zeros(66)], axis=1)
    first = (rows[:-1, :-1] * 11 + columns[:-1, :-1]).ravel()
    faces = np.concatenate(
        [
            np.stack([first, first + 11, first + 1], axis=1),
            np.stack([first + 11, first + 12, first + 1], axis=1),
        ]
    )
    other = plate + np.array([5 * SPACING + gap, 0.0, 0.0])
    return TriangleMesh(np.concatenate([plate, other]), np.concatenate([faces, faces + 66]))


def springs(mesh: TriangleMesh) -> list[tuple[int, int, float]]:
    surface = elastic_surface(mesh)
    ends = np.repeat(np.arange(mesh.vertex_count), np.diff(surface.pointers))
    rows = zip(ends.tolist(), surface.neighbors.tolist(), surface.weights.tolist(), strict=True)
    return [(i, j, weight) for i, j, weight in rows if (i < 66) != (j < 66)]


def test_borders_are_tied_across_a_gap_more_weakly_the_wider_it_is():
    for gap in (0.03, 0.06):
        found = springs(plates(gap))
        assert {(j, i) for i, j, _ in found} == {(i, j) for i, j, _ in found}
        facing = {(55 + k, 66 + k) for k in range(11)}
        assert facing <= {(i, j) for i, j, _ in found}
        straight = [weight for i, j, weight in found if (i, j) in facing]
        np.testing.assert_allclose(straight, SPACING / gap, rtol=0.2)


@pytest.mark.parametrize("gap", [1.01 * WIDEST_GAP, 3.0])
def test_components_far_apart_are_not_tied(gap):
    assert springs(plates(gap)) == []


def test_a_mesh_of_one_component_has_only_its_own_edges():
    mesh, _ = plates(3.0).submesh(np.arange(200) < 100)
    assert len(elastic_surface(mesh).neighbors) == 2 * len(mesh.edges)
