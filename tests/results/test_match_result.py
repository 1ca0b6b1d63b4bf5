"""MatchResult: matrices, trimesh objects, and a check that right answers pass, wrong ones not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sherd.errors import InvalidMeshError
from sherd.mesh.sides import turned_over
from sherd.mesh.surface_points import SurfacePoints
from sherd.results.placement import Placement


def test_the_matrix_carries_fields_to_the_part(known) -> None:
    matrix = known.matrix()
    assert matrix.shape == (known.part.vertex_count, known.full.vertex_count)
    rows = np.asarray(matrix.sum(axis=1)).ravel()
    np.testing.assert_allclose(rows[3:], 1.0, atol=1e-12)
    assert (rows[:3] == 0).all()  # unmatched
    assert matrix.nnz <= 3 * known.part.vertex_count
    assert matrix.data.min() >= 0
    values = np.random.default_rng(0).normal(size=(known.full.vertex_count, 2))
    carried = known.field_to_part(values)
    np.testing.assert_allclose((matrix @ values)[3:], carried[3:], atol=1e-12)
    np.testing.assert_allclose((matrix @ known.full.vertices)[3:], known.positions[3:], atol=1e-12)


def test_the_inverse_matrix_carries_fields_to_the_full_shape(known) -> None:
    matrix = known.inverse_matrix()
    assert matrix.shape == (known.full.vertex_count, known.part.vertex_count)
    values = np.random.default_rng(0).normal(size=known.part.vertex_count)
    carried = known.field_to_full(values)
    reached = np.isfinite(carried)
    rows = np.asarray(matrix.sum(axis=1)).ravel()
    np.testing.assert_allclose(rows[reached], 1.0, atol=1e-12)
    assert (rows[~reached] == 0).all()
    np.testing.assert_allclose((matrix @ values)[reached], carried[reached], atol=1e-12)
    assert 0.2 < reached.mean() < 0.8


def test_there_and_back_is_nearly_the_identity(known) -> None:
    """On the full shape, inside the part's place: smooth functions come back."""
    smooth = known.full.vertices[:, :1]
    there = known.matrix() @ smooth
    there[:3] = known.positions[:3, :1]
    back = known.inverse_matrix() @ there
    inside = np.asarray(known.inverse_matrix().sum(axis=1)).ravel() > 0
    assert np.abs(back - smooth)[inside].mean() < 0.1 * known.full.mean_edge_length


def test_trimesh_objects_have_the_same_numbering_and_their_own_arrays(known) -> None:
    full, part = known.to_trimesh()
    for mesh, ours in ((full, known.full), (part, known.part)):
        np.testing.assert_array_equal(mesh.vertices, ours.vertices)
        np.testing.assert_array_equal(mesh.faces, ours.faces)
    full.vertices[0] += 1.0
    assert not np.array_equal(full.vertices[0], known.full.vertices[0])


def test_positions_and_nearest_vertices_are_those_of_the_points(known, fragment) -> None:
    np.testing.assert_array_equal(known.positions, fragment.truth.positions(fragment.full))
    near = np.linalg.norm(known.full.vertices[known.nearest_vertices] - known.positions, axis=1)
    assert near.max() < 2 * known.full.mean_edge_length
    assert known.points is known.best.points


def test_a_right_answer_passes_its_check(known) -> None:
    check = known.check()
    assert check.passed
    assert check.area_ratio == pytest.approx(1.0, abs=0.03)
    assert check.edge_stretch < 1e-9
    assert check.preserved > 0.999


def test_where_nothing_is_matched_the_check_says_so_without_a_number(known) -> None:
    nowhere = replace(known.best, matched=np.zeros(known.part.vertex_count, dtype=bool))
    check = replace(known, best=nowhere).check()
    assert not check.passed
    assert "no edge of the part has a place" in check.failures
    assert "nan" not in check.failures


def test_wrong_answers_do_not_pass(known, fragment, answered) -> None:
    truth, count = fragment.truth, fragment.mesh.vertex_count
    shuffled = answered(truth[np.random.default_rng(0).permutation(count)]).check()
    assert not shuffled.passed
    assert shuffled.edge_stretch > 1.0
    one_place = answered(truth[np.zeros(count, dtype=int)]).check()
    assert not one_place.passed
    inside_out = replace(known, part=turned_over(known.part)).check()
    assert not inside_out.passed
    assert inside_out.preserved < 0.001
    assert inside_out.edge_stretch < 1e-9
    squeezed = known.part.vertices * [2.0, 0.5, 1.0]
    other = known.part.with_vertices(squeezed)
    other = other.with_vertices(squeezed * known.part.length / other.length)
    stretched = replace(known, part=other).check()
    assert not stretched.passed
    assert stretched.edge_stretch > 0.2
    assert stretched.area_ratio == pytest.approx(1.0, abs=0.03)
    assert stretched.preserved > 0.999
    too_large = replace(known, scale=1.5).check()
    assert not too_large.passed
    assert too_large.area_ratio == pytest.approx(1 / 1.5**2, rel=0.03)
    assert too_large.edge_stretch == pytest.approx(np.log(1.5))
    everything = np.ones(known.full.vertex_count)
    best = replace(known.best, mask=everything > 0, membership=everything)
    assert not replace(known, best=best).check().passed


def test_a_full_shape_inside_out_is_seen_from_outside_all_the_same(known) -> None:
    """Repair turned it; answers are stated for the faces as they were given."""
    weights = known.points.barycentric[:, ::-1]
    best = replace(known.best, points=SurfacePoints(known.points.faces, weights))
    turned = replace(known, full=turned_over(known.full), best=best)
    np.testing.assert_allclose(turned.positions, known.positions, atol=1e-12)
    np.testing.assert_allclose(turned.outward, known.outward, atol=1e-12)
    assert turned.check().preserved > 0.999


def test_placements_of_another_part_are_refused(known) -> None:
    short = Placement(
        mask=known.best.mask,
        membership=known.best.membership,
        score=0.1,
        points=known.points[np.arange(5)],
        matched=np.ones(5, dtype=bool),
        confidence=np.ones(5),
    )
    with pytest.raises(InvalidMeshError, match=r"a placement has 5 points, but the part has \d+"):
        replace(known, best=short)
    with pytest.raises(InvalidMeshError, match="a placement has 5 points"):
        replace(known, alternatives=(short,))
    region = Placement(mask=known.best.mask, membership=known.best.membership, score=0.1)
    with pytest.raises(InvalidMeshError, match="a placement has 0 points"):
        replace(known, best=region)
    with pytest.raises(InvalidMeshError, match="says what is matched, how surely"):
        replace(known, best=replace(known.best, confidence=None))


def test_it_says_what_it_is(known) -> None:
    assert repr(known).endswith("good, 100% matched, mean confidence 0.75)")
