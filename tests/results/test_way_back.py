"""The way back: answers about what was asked, in the numbering of what was given."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from sherd.arrays import Ints
from sherd.correspondence.hints import without_ignored
from sherd.mesh.surface_points import points_at_vertices
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.match_options import MatchOptions
from sherd.results.placement import Placement
from sherd.results.way_back import WayBack
from sherd.scan.intake import Intake, mesh_intake, scan_intake


def ball() -> TriangleMesh:
    made = trimesh.creation.icosphere(subdivisions=2)
    return TriangleMesh(made.vertices * [1.0, 1.2, 1.5], made.faces, name="ball")


def dirty(mesh: TriangleMesh) -> TriangleMesh:
    """As an STL has it, three vertices a face; a lonely vertex, a doubled and a turned face."""
    soup = mesh.vertices[mesh.faces].reshape(-1, 3)
    faces = 1 + np.arange(len(soup)).reshape(-1, 3)
    faces[7] = faces[7, ::-1]
    lonely = 1.3 * mesh.vertices[5]
    return TriangleMesh(np.concatenate([[lonely], soup]), np.concatenate([faces, faces[3:4]]))


@pytest.fixture(scope="module")
def full() -> Intake:
    return mesh_intake(dirty(ball()))


@pytest.fixture(scope="module")
def part() -> Intake:
    """The upper part of the same ball, as dirty."""
    mesh = ball()
    upper, _ = mesh.submesh(mesh.vertices[mesh.faces, 2].mean(axis=1) > 0.2)
    return scan_intake(dirty(upper))


def ignored_vertices(part: Intake) -> Ints:
    """Some of the soup's copies of one corner, and of its neighbor."""
    place = part.original.vertices[40]
    return np.flatnonzero((part.original.vertices == place).all(axis=1))[:2]


@pytest.fixture(scope="module")
def kept(part: Intake) -> Ints:
    options = MatchOptions(ignore=tuple(ignored_vertices(part).tolist()))
    return without_ignored(part, options)[1]


@pytest.fixture(scope="module")
def placement(full: Intake, part: Intake, kept: Ints) -> Placement:
    """Every kept vertex of the part lies on itself; confidence is its height."""
    places = part.mesh.vertices[kept]
    near = np.linalg.norm(full.mesh.vertices - places[:, None], axis=2).argmin(axis=1)
    height = full.mesh.vertices[:, 2]
    return WayBack(full, part, kept).placement(
        points_at_vertices(full.mesh, near),
        height > 0.2,
        np.clip(height, 0.0, 1.0),
        score=0.7,
        matched=np.arange(len(kept)) % 5 > 0,
        confidence=np.clip(places[:, 2] / 2, 0.0, 1.0),
    )


def test_both_shapes_were_repaired(full: Intake, part: Intake, kept: Ints) -> None:
    for intake in (full, part):
        counts = {step.name: step.count for step in intake.report.steps if step.count}
        assert len(counts) >= 4, counts
        assert (intake.report.new_vertices < 0).sum() == 1
    assert len(kept) < part.mesh.vertex_count


def test_there_is_an_answer_for_each_given_vertex(
    full: Intake, part: Intake, placement: Placement
) -> None:
    count = part.original.vertex_count
    assert len(placement.points) == len(placement.matched) == len(placement.confidence) == count
    assert len(placement.mask) == len(placement.membership) == full.original.vertex_count
    assert (placement.score, placement.mirrored) == (0.7, False)


def test_asked_vertices_lie_on_themselves_by_the_faces_that_were_given(
    full: Intake, part: Intake, kept: Ints, placement: Placement
) -> None:
    """Faces of the original full shape, one of them turned over and one a copy."""
    places = placement.points.positions(full.original)
    asked = np.isin(part.report.new_vertices, kept)
    np.testing.assert_allclose(places[asked], part.original.vertices[asked], atol=1e-12)
    assert asked.mean() > 0.8


def test_copies_of_a_welded_vertex_have_one_answer(
    full: Intake, part: Intake, placement: Placement
) -> None:
    new = part.report.new_vertices
    places = placement.points.positions(full.original)
    for vertex in range(0, part.mesh.vertex_count, 7):
        copies = np.flatnonzero(new == vertex)
        assert len(copies) >= 1
        assert np.ptp(places[copies], axis=0).max() < 1e-12
        assert len(np.unique(placement.confidence[copies])) == 1
        assert len(np.unique(placement.matched[copies])) == 1


def test_matched_and_confidence_are_those_of_the_asked_vertices(
    part: Intake, kept: Ints, placement: Placement
) -> None:
    new = part.report.new_vertices
    row = np.full(part.mesh.vertex_count, -1)
    row[kept] = np.arange(len(kept))
    asked = (new >= 0) & (row[new] >= 0)
    rows = row[new[asked]]
    np.testing.assert_array_equal(placement.matched[asked], rows % 5 > 0)
    expected = np.clip(part.mesh.vertices[kept][rows, 2] / 2, 0.0, 1.0)
    np.testing.assert_array_equal(placement.confidence[asked], expected)


def test_ignored_and_lonely_vertices_are_unmatched_and_guessed_by_the_nearest(
    full: Intake, part: Intake, kept: Ints, placement: Placement
) -> None:
    places = placement.points.positions(full.original)
    asked = np.isin(part.report.new_vertices, kept)
    assert not asked[0]
    assert not asked[ignored_vertices(part)].any()
    assert not placement.matched[~asked].any()
    assert (placement.confidence[~asked] == 0).all()
    nearest = part.mesh.vertices[kept]
    given = part.original.vertices[~asked]
    # the lonely vertex asks the nearest repaired one, which may have been ignored itself
    gap = np.linalg.norm(nearest - given[:, None], axis=2)
    off = np.linalg.norm(places[~asked] - given, axis=1)
    np.testing.assert_allclose(off[1:], gap.min(axis=1)[1:], atol=1e-12)
    assert off[0] <= gap[0].min() + 0.4


def test_the_region_is_counted_by_the_given_vertices(full: Intake, placement: Placement) -> None:
    height = full.original.vertices[:, 2]
    faced = full.report.new_vertices >= 0
    np.testing.assert_array_equal(placement.mask[faced], height[faced] > 0.2)
    np.testing.assert_allclose(placement.membership[faced], np.clip(height[faced], 0, 1))
    assert not placement.mask[~faced].any()
    assert (placement.membership[~faced] == 0).all()


def test_what_is_not_known_stays_unknown(full: Intake, part: Intake, kept: Ints) -> None:
    count = full.mesh.vertex_count
    points = points_at_vertices(full.mesh, np.zeros(len(kept), dtype=int))
    found = WayBack(full, part, kept).placement(
        points, np.zeros(count, dtype=bool), np.zeros(count), score=0.1, mirrored=True
    )
    assert found.matched is None
    assert found.confidence is None
    assert found.mirrored
