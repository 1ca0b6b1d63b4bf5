"""Values carried over a map that is known exactly: the part is a piece of the full shape itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from sherd.correspondence.point_map import PointMap
from sherd.transfer import (
    field_to_full,
    field_to_part,
    labels_to_full,
    labels_to_part,
    landmarks_to_full,
    landmarks_to_part,
)

from sherd.errors import InvalidMeshError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes.creature import creature, landmarks
from sherd.shapes.fragment import cut_by_ball, moved, remeshed, whole


@dataclass(frozen=True)
class Known:
    full: TriangleMesh
    part: TriangleMesh
    point_map: PointMap
    scale: float = 1.0


@pytest.fixture(scope="module")
def known() -> Known:
    full = creature(5000)
    piece = cut_by_ball(whole(full, full), landmarks(full)["nose"], 0.6)
    fragment = moved(remeshed(piece, 1.2), np.random.default_rng(0))
    count = fragment.mesh.vertex_count
    matched = np.ones(count, dtype=bool)
    matched[:3] = False
    truth = fragment.truth
    point_map = PointMap(truth.faces, truth.barycentric, matched, np.ones(count))
    return Known(full, fragment.mesh, point_map)


def test_linear_fields_arrive_exactly(known) -> None:
    """Interpolation is exact for coordinates, the most demanding of linear fields."""
    carried = field_to_part(known, known.full.vertices)
    expected = known.point_map.points.positions(known.full)
    np.testing.assert_allclose(carried[3:], expected[3:], atol=1e-12)
    assert np.isnan(carried[:3]).all()


def test_fields_return_to_where_they_came_from(known) -> None:
    there = field_to_part(known, known.full.vertices[:, 0])
    there[:3] = known.point_map.points.positions(known.full)[:3, 0]
    back = field_to_full(known, there)
    found = np.isfinite(back)
    share = known.full.vertex_areas[found].sum() / known.part.area
    assert share == pytest.approx(1, abs=0.06)
    error = np.abs(back - known.full.vertices[:, 0])[found]
    assert error.max() < 2 * known.full.mean_edge_length
    assert error.mean() < 0.1 * known.full.mean_edge_length


def test_labels_stay_labels(known) -> None:
    labels = (known.full.vertices[:, 2] > 0).astype(int) * 7
    carried = labels_to_part(known, labels)
    assert set(np.unique(carried)) <= {-1, 0, 7}
    assert (carried[:3] == -1).all()
    back = labels_to_full(known, np.maximum(carried, 0))
    inside = back >= 0
    assert (back[inside] == labels[inside]).mean() > 0.97
    assert (back == -1).any()


def test_landmarks_both_ways(known) -> None:
    nose = landmarks(known.full)["nose"]
    points, miss = landmarks_to_part(known, [nose])
    assert miss[0] < 0.01
    vertex = points.nearest_vertices(known.part)
    place = landmarks_to_full(known, vertex).positions(known.full)[0]
    assert np.linalg.norm(place - known.full.vertices[nose]) < 2 * known.full.mean_edge_length
    _, miss = landmarks_to_part(known, [landmarks(known.full)["tail_tip"]])
    assert miss[0] > 0.3  # the part has no tail


def test_refusals(known) -> None:
    with pytest.raises(InvalidMeshError, match="but the full shape has"):
        field_to_part(known, np.zeros(3))
    with pytest.raises(InvalidMeshError, match="whole numbers"):
        labels_to_part(known, np.full(known.full.vertex_count, 0.5))
    with pytest.raises(InvalidMeshError, match="vertex 999999 does not exist"):
        landmarks_to_full(known, [999999])
