"""match on generated animals: accuracy, invariance, honesty, hints, determinism."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from sherd.template import Template

from sherd.errors import InfeasibleError, OptionError
from sherd.match import MatchOptions, MatchResult, MatchStatus, match
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes.creature import creature
from sherd.shapes.fragment import Fragment, cut_by_ball, moved, remeshed, reordered, scaled, whole

VERTICES = 5_000  # the smallest animal
CENTER = 100


@pytest.fixture(scope="module")
def template() -> Template:
    return Template(creature(VERTICES))


@pytest.fixture(scope="module")
def piece(template: Template) -> Fragment:
    """Half an animal in another pose, meshed anew and turned."""
    posed = whole(creature(VERTICES, pose="walk"), template.full)
    cut = cut_by_ball(posed, CENTER, 0.4 * template.full.length)
    return moved(remeshed(cut, 0.9), np.random.default_rng(1))


@pytest.fixture(scope="module")
def result(template: Template, piece: Fragment) -> MatchResult:
    return match(template, piece.mesh)


def errors(fragment: Fragment, found: MatchResult) -> np.ndarray:
    full = fragment.full
    gap = found.point_map.points.positions(full) - fragment.truth.positions(full)
    return np.linalg.norm(gap, axis=1) / full.length


def test_answers_are_near_the_truth_and_know_it(piece: Fragment, result: MatchResult) -> None:
    error = errors(piece, result)
    assert error.mean() < 0.015
    confidence = result.point_map.confidence
    assert abs(confidence.mean() - (error < 0.05).mean()) < 0.15
    assert result.status is MatchStatus.GOOD
    assert result.point_map.matched.mean() > 0.95


def test_the_region_is_the_true_one_and_agrees_with_the_map(
    piece: Fragment, result: MatchResult
) -> None:
    areas, truth, mask = piece.full.vertex_areas, piece.region, result.region.mask
    assert areas[mask & truth].sum() / areas[mask | truth].sum() > 0.9
    hit = result.point_map.points.nearest_vertices(piece.full)
    assert mask[hit].mean() > 0.9  # along the cut a vertex may be hit and less than half covered
    assert result.check().passed


def test_order_of_vertices_motion_and_unit_do_not_matter(
    template: Template, piece: Fragment, result: MatchResult
) -> None:
    rng = np.random.default_rng(7)
    other = moved(reordered(piece, rng), rng)
    unit = 1000.0
    big = Template(template.full.with_vertices(unit * template.full.vertices))
    found = match(big, scaled(other, unit).mesh)
    error = errors(Fragment(other.mesh, other.truth, template.full, other.present), found)
    assert abs(error.mean() - errors(piece, result).mean()) < 0.005
    assert found.scale == 1.0


def test_the_same_question_has_the_same_answer_bit_for_bit(
    template: Template, piece: Fragment, result: MatchResult
) -> None:
    again = match(template, piece.mesh)
    assert np.array_equal(again.point_map.faces, result.point_map.faces)
    assert np.array_equal(again.point_map.barycentric, result.point_map.barycentric)
    assert np.array_equal(again.point_map.confidence, result.point_map.confidence)
    assert again.scores == result.scores


def test_the_full_shape_itself_maps_to_itself(template: Template) -> None:
    full = template.full
    found = match(template, full)
    gap = found.point_map.points.positions(full) - full.vertices
    assert np.linalg.norm(gap, axis=1).mean() / full.length < 0.002
    assert found.region.mask.mean() > 0.995  # at the tips a vertex may be half covered
    assert found.scores["best"] > 0.9


def test_parts_of_something_else_score_low(template: Template, result: MatchResult) -> None:
    found = []
    for tube in (0.1, 0.2, 0.3):
        torus = trimesh.creation.torus(0.5, tube, major_sections=50, minor_sections=26)
        foreign = TriangleMesh(torus.vertices, torus.faces)
        size = 0.6 * template.full.length / foreign.length
        found.append(match(template, foreign.with_vertices(size * foreign.vertices)))
    assert max(other.scores["best"] for other in found) < result.scores["best"] - 0.2
    # two placements of a torus may agree by chance
    assert sum(other.status is MatchStatus.DOUBTFUL for other in found) >= 2
    sure = np.mean([other.point_map.confidence.mean() for other in found])
    assert sure < 0.5 * result.point_map.confidence.mean()


def test_unknown_scale_is_estimated(template: Template, piece: Fragment) -> None:
    small = scaled(piece, 0.6)
    found = match(template, small.mesh, MatchOptions(scale="unknown"))
    assert abs(np.log(found.scale * 0.6)) < 0.05
    assert errors(small, found).mean() < 0.025


def test_landmarks_and_ignored_vertices_are_honored(template: Template, piece: Fragment) -> None:
    near = piece.truth.nearest_vertices(template.full)
    pinned = int(np.argmax(piece.mesh.vertices[:, 0]))
    ignored = np.flatnonzero(
        piece.mesh.vertices[:, 1] > np.quantile(piece.mesh.vertices[:, 1], 0.95)
    )
    ignored = np.setdiff1d(ignored, [pinned])
    options = MatchOptions(landmarks=((pinned, int(near[pinned])),), ignore=tuple(ignored))
    found = match(template, piece.mesh, options)
    assert errors(piece, found)[pinned] < 0.02
    assert not found.point_map.matched[ignored].any()
    assert (found.point_map.confidence[ignored] == 0).all()
    kept = np.setdiff1d(np.arange(piece.mesh.vertex_count), ignored)
    assert errors(piece, found)[kept].mean() < 0.015


def test_the_mirrored_twin_of_a_symmetric_animal_is_an_alternative(result: MatchResult) -> None:
    twins = [other for other in result.alternatives if other.mirrored]
    assert len(twins) == 1
    assert twins[0].score <= result.scores["best"] + 0.1
    assert twins[0].mask.shape == result.region.mask.shape


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"scale": "metric"}, "scale is 'metric'"),
        ({"landmarks": ((1, 2), (1, 3))}, "twice"),
        ({"ignore": (-1,)}, "from 0"),
        ({"landmarks": ((1, 2),), "ignore": (1,)}, "vertex 1 of the part is a landmark"),
        ({"seed": -3}, "seed is -3"),
    ],
)
def test_options_are_checked_when_made(settings: dict[str, object], message: str) -> None:
    with pytest.raises(OptionError, match=message):
        MatchOptions(**settings)  # type: ignore[arg-type]


def test_hints_that_do_not_exist_and_parts_that_do_not_fit(template: Template) -> None:
    full = template.full
    with pytest.raises(OptionError, match="landmarks names vertex 99999 of the part"):
        match(template, full, MatchOptions(landmarks=((99_999, 0),)))
    with pytest.raises(InfeasibleError, match="swap them"):
        match(template, full.with_vertices(2 * full.vertices))
    with pytest.raises(InfeasibleError, match="1e-12 times the area"):
        match(template, full.with_vertices(1e-6 * full.vertices))
    with pytest.raises(InfeasibleError, match="ignored"):
        match(template, full, MatchOptions(ignore=tuple(range(full.vertex_count))))
