"""Values carried over a map that is known exactly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from sherd.arrays import Bools
from sherd.errors import InvalidMeshError
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results import transfer
from sherd.results.transfer import nearest_part_points
from sherd.shapes.creature import landmarks


def test_linear_fields_arrive_exactly(known) -> None:
    """Interpolation is exact for coordinates, the most demanding of linear fields."""
    carried = known.field_to_part(known.full.vertices)
    np.testing.assert_allclose(carried[3:], known.positions[3:], atol=1e-12)
    assert np.isnan(carried[:3]).all()
    one = known.field_to_part(known.full.vertices[:, 1])
    np.testing.assert_allclose(one, carried[:, 1], rtol=1e-12, atol=1e-12)


def test_fields_return_to_where_they_came_from(known) -> None:
    there = known.field_to_part(known.full.vertices[:, 0])
    there[:3] = known.positions[:3, 0]
    back = known.field_to_full(there)
    found = np.isfinite(back)
    share = known.full.vertex_areas[found].sum() / known.part.area
    assert share == pytest.approx(1, abs=0.06)
    error = np.abs(back - known.full.vertices[:, 0])[found]
    assert error.max() < 2 * known.full.mean_edge_length
    assert error.mean() < 0.1 * known.full.mean_edge_length
    # nothing arrives where the part is not, but for the faces along its cut
    assert not found[~known.best.mask].mean() > 0.05


def test_labels_stay_labels(known) -> None:
    height = known.full.vertices[:, 2]
    labels = (height > np.median(height[known.best.mask])).astype(int) * 7
    carried = known.labels_to_part(labels)
    assert set(np.unique(carried)) == {-1, 0, 7}
    assert (carried[:3] == -1).all()
    back = known.labels_to_full(np.maximum(carried, 0))
    inside = back >= 0
    assert (back[inside] == labels[inside]).mean() > 0.97
    assert (back == -1).any()


def test_landmarks_both_ways(known) -> None:
    nose = landmarks(known.full)["nose"]
    points, miss = known.landmarks_to_part([nose])
    assert miss[0] < 0.01
    vertex = points.nearest_vertices(known.part)
    place = known.landmarks_to_full(vertex).positions(known.full)[0]
    assert np.linalg.norm(place - known.full.vertices[nose]) < 2 * known.full.mean_edge_length
    _, miss = known.landmarks_to_part([landmarks(known.full)["tail_tip"]])
    assert miss[0] > 0.3  # the part has no tail


def test_methods_are_the_functions(known) -> None:
    values, labels = known.full.vertices, np.arange(known.full.vertex_count)
    np.testing.assert_array_equal(
        known.field_to_part(values), transfer.field_to_part(known, values)
    )
    np.testing.assert_array_equal(
        known.labels_to_part(labels), transfer.labels_to_part(known, labels)
    )


def test_refusals(known) -> None:
    with pytest.raises(InvalidMeshError, match=r"values has shape \(3,\), but the full shape has"):
        known.field_to_part(np.zeros(3))
    with pytest.raises(InvalidMeshError, match=r"values has shape \(4, 2\), but the part has"):
        known.field_to_full(np.zeros((4, 2)))
    with pytest.raises(InvalidMeshError, match="whole numbers"):
        known.labels_to_part(np.full(known.full.vertex_count, 0.5))
    with pytest.raises(InvalidMeshError, match="whole numbers"):
        known.labels_to_full(np.zeros((known.part.vertex_count, 2)))
    with pytest.raises(InvalidMeshError, match="vertex 999999 does not exist; the part has 0"):
        known.landmarks_to_full([999999])
    with pytest.raises(InvalidMeshError, match="vertex -1 does not exist; the full shape has 0"):
        known.landmarks_to_part([0, -1])


@dataclass(frozen=True, eq=False)
class OnSheet:
    """A sheet of 10 x 10 squares laid on itself."""

    full: TriangleMesh
    part: TriangleMesh
    points: SurfacePoints
    matched: Bools
    scale: float = 1.0


def sheet() -> TriangleMesh:
    row, column = np.mgrid[:11, :11]
    vertices = np.stack([column.ravel(), row.ravel(), 0 * row.ravel()], axis=1).astype(float)
    first = (row[:-1, :-1] * 11 + column[:-1, :-1]).ravel()
    low = np.stack([first, first + 1, first + 12], axis=1)
    high = np.stack([first, first + 12, first + 11], axis=1)
    return TriangleMesh(vertices, np.concatenate([low, high]))


def laid_on_itself(image: np.ndarray, matched: Bools) -> OnSheet:
    """Each vertex of the sheet on the vertex `image` (n,) of the same sheet."""
    mesh = sheet()
    face, corner = np.full(121, -1), np.zeros(121, dtype=int)
    for k in range(3):
        face[mesh.faces[:, k]], corner[mesh.faces[:, k]] = np.arange(mesh.face_count), k
    points = SurfacePoints(face[image], np.eye(3)[corner[image]])
    return OnSheet(mesh, mesh, points, matched)


def test_faces_that_the_map_tears_carry_nothing() -> None:
    """The right half lies on the rightmost column: faces between it and the left half span both."""
    column = np.arange(121) % 11
    image = np.where(column >= 5, np.arange(121) - column + 10, np.arange(121))
    torn = laid_on_itself(image, np.ones(121, dtype=bool))
    _, found = nearest_part_points(torn)
    # the left image ends at column 4, the right one begins at 10; an edge from there is near
    np.testing.assert_array_equal(found, (column <= 5) | (column >= 9))


def test_faces_with_an_unmatched_corner_carry_nothing() -> None:
    column = np.arange(121) % 11
    result = laid_on_itself(np.arange(121), column < 5)
    points, found = nearest_part_points(result)
    np.testing.assert_array_equal(found, column <= 5)
    assert result.matched[result.part.faces[points.faces]].all()
    values = transfer.field_to_full(result, np.arange(121.0))
    np.testing.assert_allclose(values[column < 5], np.arange(121.0)[column < 5])
    assert np.isnan(values[column > 5]).all()


def test_if_nothing_is_matched_nothing_arrives() -> None:
    result = laid_on_itself(np.arange(121), np.zeros(121, dtype=bool))
    _, found = nearest_part_points(result)
    assert not found.any()
