"""sherd.fit on shapes whose whole truth is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sherd.errors import InfeasibleError, InputError, OptionError
from sherd.fitting.fit import fit
from sherd.mesh.surface_points import SurfacePoints, points_at_vertices
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.fitted.fit_result import Fit
from sherd.results.match_result import MatchResult
from sherd.results.placement import Placement
from sherd.results.status import Status

# That of the half in tests/conftest.py.
TURN = np.array([0.4, 1.1, -0.7])


def turned(vertices):
    return vertices @ Rotation.from_rotvec(TURN).as_matrix().T


def with_part(match: MatchResult, part: TriangleMesh, **changes) -> MatchResult:
    """The same match of another part; its points, matched and confidence may be replaced too."""
    return replace(match, part=part, alternatives=(), best=replace(match.best, **changes))


@pytest.fixture(scope="module")
def match(match_result_of, exhibit) -> MatchResult:
    """The exact match of half of a bumpy sphere, turned."""
    return match_result_of(exhibit)


@pytest.fixture(scope="module")
def fitted(match) -> Fit:
    return fit(match)


def off(fitted: Fit, truth) -> np.ndarray:
    return np.linalg.norm(fitted.positions - truth, axis=1) / fitted.full.length


def test_what_only_moved_comes_back_everywhere(fitted, match) -> None:
    """A half that was turned says where the other half is: nothing asks for a bend."""
    wrong = off(fitted, turned(match.full.vertices))
    assert wrong[fitted.seen].max() < 0.005
    assert wrong.max() < 0.03
    assert (fitted.sizes == 1).all()
    assert fitted.status is Status.GOOD
    assert fitted.check.turned_faces == 0
    assert fitted.check.new_intersections == 0
    assert fitted.check.hidden_area_kept == pytest.approx(1, abs=0.01)


def test_vertices_faces_and_fields_are_those_of_the_full_shape(fitted, match) -> None:
    assert np.array_equal(fitted.mesh.faces, match.full.faces)
    assert fitted.mesh.vertex_count == match.full.vertex_count
    assert set(fitted.mesh.fields) == set(match.full.fields)


def test_numbers_say_what_was_seen(fitted, match) -> None:
    assert 0.4 < fitted.seen_share < 0.65
    assert len(fitted.hidden) == 1
    assert fitted.hidden[0].area == pytest.approx(1 - fitted.seen_share, abs=0.01)
    deepest = fitted.hidden[0].vertex
    assert not fitted.seen[deepest]
    assert fitted.chance[deepest] < 0.3 < fitted.chance[fitted.seen].mean()
    assert np.isnan(fitted.distances[~fitted.seen]).all()
    assert np.isfinite(fitted.distances[fitted.seen]).all()
    assert fitted.scan_summary.mean < 0.01 * match.part.mean_edge_length
    inside = fitted.vertices_of_region(0)
    assert deepest in inside
    assert not fitted.seen[inside].any()


def test_hidden_landmarks_are_there_and_marked(fitted) -> None:
    deepest, known = fitted.hidden[0].vertex, int(np.flatnonzero(fitted.seen)[0])
    positions, extrapolated, chance = fitted.landmarks([deepest, known])
    assert extrapolated.tolist() == [True, False]
    assert np.array_equal(positions, fitted.positions[[deepest, known]])
    assert chance[0] < chance[1]


def test_a_larger_individual_is_met_by_size_and_beyond_the_cut_too(match) -> None:
    larger = with_part(match, match.part.with_vertices(1.3 * match.part.vertices))
    answer = fit(larger)
    assert answer.sizes == pytest.approx(1.3, rel=0.06)
    assert off(answer, 1.3 * turned(match.full.vertices)).max() < 0.08
    assert answer.check.hidden_area_kept == pytest.approx(1, abs=0.05)
    same = fit(larger, sizing="none")
    assert (same.sizes == 1).all()


def test_units_of_the_part_are_kept(match) -> None:
    """A part in millimeters of a full shape in meters, matched with its scale."""
    small = replace(match, part=match.part.with_vertices(1000 * match.part.vertices), scale=0.001)
    answer = fit(small)
    wrong = np.linalg.norm(answer.positions / 1000 - turned(match.full.vertices), axis=1)
    assert wrong.max() < 0.1
    assert answer.unit == pytest.approx(1000 * match.full.length)


def test_clutter_draws_nothing(fitted, match) -> None:
    """A wall through the hidden half, unmatched, leaves the fit as it is."""
    wall = turned(np.array([[-1.0, -2, -2], [-1, 2, -2], [-1, 2, 2], [-1, -2, 2]]))
    count = match.part.vertex_count
    part = TriangleMesh(
        np.concatenate([match.part.vertices, wall]),
        np.concatenate([match.part.faces, np.array([[0, 1, 2], [0, 2, 3]]) + count]),
    )
    points = SurfacePoints(
        np.concatenate([match.points.faces, np.zeros(4, dtype=np.int64)]),
        np.concatenate([match.points.barycentric, np.tile([1.0, 0.0, 0.0], (4, 1))]),
    )
    cluttered = with_part(
        match,
        part,
        points=points,
        matched=np.concatenate([match.matched, np.zeros(4, dtype=bool)]),
        confidence=np.concatenate([match.confidence, np.zeros(4)]),
    )
    answer = fit(cluttered)
    assert np.abs(answer.positions - fitted.positions).max() < 1e-6
    assert (answer.pieces[0].distances[-4:] > 0.1).all()


def test_wrong_places_are_outvoted(fitted, match) -> None:
    """One patch of the map leads elsewhere with full confidence."""
    place = match.part.vertices[100]
    patch = np.linalg.norm(match.part.vertices - place, axis=1) < 0.15
    shuffled = match.points.faces.copy()
    shuffled[patch] = match.points.faces[200]
    wrong = with_part(match, match.part, points=SurfacePoints(shuffled, match.points.barycentric))
    answer = fit(wrong)
    far = np.linalg.norm(answer.positions - fitted.positions, axis=1)
    assert np.quantile(far, 0.9) < 0.05 * match.full.length


def test_seams_of_the_file_stay_closed(match) -> None:
    """Vertices that are double, as OBJ files with textures have them, move together."""
    full = match.full
    cut = full.face_normals[:, 2] > 0
    double = full.faces.copy()
    double[cut] += full.vertex_count
    twice = TriangleMesh(np.concatenate([full.vertices, full.vertices]), double)
    both = np.concatenate([match.best.mask, match.best.mask])
    seamed = replace(
        match,
        full=twice,
        alternatives=(),
        best=replace(match.best, mask=both, membership=both.astype(float)),
    )
    answer = fit(seamed)
    half = full.vertex_count
    used = np.intersect1d(double[cut] - half, double[~cut])
    assert np.allclose(answer.positions[used], answer.positions[used + half])


def test_two_pieces_of_one_pose_are_fitted_at_once(match) -> None:
    """The other half too, in the same place: now all is known."""
    full = match.full
    other, old = full.submesh(full.vertices[full.faces].mean(axis=1)[:, 0] <= 0)
    second = replace(
        match,
        part=TriangleMesh(turned(other.vertices), other.faces, name="other.ply"),
        alternatives=(),
        best=Placement(
            mask=~match.best.mask,
            membership=(~match.best.mask).astype(float),
            score=0.9,
            points=points_at_vertices(full, old),
            matched=np.ones(len(old), dtype=bool),
            confidence=np.ones(len(old)),
        ),
    )
    answer = fit([match, second])
    assert answer.seen_share > 0.9
    assert off(answer, turned(full.vertices)).max() < 0.03
    with pytest.raises(InputError, match=r"scale 2, piece\.ply with 1"):
        fit([match, replace(second, scale=2.0)])


def test_pieces_in_different_places_are_doubted(match) -> None:
    """A second scan of the same half in a coordinate system of its own."""
    apart = with_part(match, match.part.with_vertices(match.part.vertices[:, ::-1] * [1, 1, -1.0]))
    answer = fit([match, apart])
    assert answer.status is Status.DOUBTFUL
    assert "one coordinate system" in answer.advice


def test_doubt_of_the_match_is_doubt_of_the_fit(match) -> None:
    doubted = fit(replace(match, status=Status.DOUBTFUL, advice="doubtful: no"))
    assert doubted.status is Status.DOUBTFUL
    assert "piece.ply" in doubted.advice


def test_the_same_question_has_the_same_bits(fitted, match) -> None:
    assert np.array_equal(fit(match).positions, fitted.positions)


def test_what_cannot_be_fitted_is_refused(match) -> None:
    nobody = with_part(match, match.part, matched=np.zeros(match.part.vertex_count, dtype=bool))
    with pytest.raises(InfeasibleError, match=r"0 of its 642 vertices lie on matched"):
        fit(nobody)
    with pytest.raises(InputError, match="a str cannot be fitted to"):
        fit("scan.ply")
    with pytest.raises(OptionError, match="sizing is 'global'"):
        fit(match, sizing="global")
    with pytest.raises(OptionError, match="near is 0"):
        fit(match, near=0)
