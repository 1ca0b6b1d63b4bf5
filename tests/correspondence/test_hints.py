"""Landmarks pin labels, ignored vertices are left out, and hints follow repaired numbering."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sherd.correspondence.hints import (
    check_hints,
    landmark_pairs,
    pins_of,
    without_ignored,
    working_pins,
)
from sherd.correspondence.labels.anchors import find_anchors
from sherd.correspondence.labels.forbidden import PIN_SLACK, PIN_STRETCH
from sherd.correspondence.labels.labeling import Problem, labeling_problem
from sherd.correspondence.question import Pins
from sherd.errors import InfeasibleError, InputError, OptionError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.match_options import MatchOptions
from sherd.scan.intake import Intake, mesh_intake
from sherd.surface.described import DescribedSurface
from sherd.surface.template import Template
from sherd.surface.working import WorkingSurface, working_surface


def pinned_problem(planted, nodes: list[int], labels: list[int]) -> Problem:
    """Nothing is known but that these nodes belong to these labels."""
    question = planted.question
    pins = Pins(
        question.part.sparse.vertices[nodes],
        question.full.mesh.vertices[question.full.dense.vertices[labels]],
        np.zeros((len(nodes), 2), dtype=np.int64),
    )
    similarity = np.zeros((len(planted.labels), len(question.full.dense), 16), dtype=np.float32)
    pinned = replace(question, pins=pins)
    return labeling_problem(pinned, similarity, np.random.default_rng(0))


def test_without_pins_no_label_is_forbidden(planted) -> None:
    assert not pinned_problem(planted, [], []).forbidden.any()


def test_pins_forbid_labels_that_are_too_far_and_no_true_one(planted) -> None:
    nodes = [3, 40]
    problem = pinned_problem(planted, nodes, planted.labels[nodes].tolist())
    rows = np.arange(len(planted.labels))
    assert not problem.forbidden[rows, planted.labels].any()
    between = planted.question.full.dense.between
    for node in nodes:
        allowed = ~problem.forbidden[node]
        assert between[planted.labels[node], allowed].max() < 1.05 * PIN_SLACK
        assert 0 < allowed.sum() < 20
    on_part = problem.nodes.between[nodes]
    reach = between[planted.labels[nodes]][:, None, :] - PIN_STRETCH * on_part[:, :, None]
    far = (reach > PIN_SLACK).any(axis=0)
    assert (problem.forbidden == far).mean() > 0.995  # distances to labels differ by heat's percent
    assert far.mean() > 0.3


def test_pins_alone_lay_the_part_near_its_place(planted) -> None:
    """Eight landmarks, no similarity at all: lengths do the rest."""
    nodes = list(range(8))
    labeling = find_anchors(pinned_problem(planted, nodes, planted.labels[nodes].tolist()))
    between = planted.question.full.dense.between
    assert between[labeling.labels[nodes], planted.labels[nodes]].max() < PIN_SLACK
    assert np.median(between[labeling.labels, planted.labels]) < 0.1


def test_pins_that_contradict_each_other_rule_nothing_out(planted) -> None:
    """Two neighbors on the part, pinned to the two ends of the blob."""
    question = planted.question
    nodes = question.part.sparse.between
    node = 0
    neighbor = int(np.argsort(nodes[node])[1])
    ends = [0, int(question.full.dense.between[0].argmax())]
    problem = pinned_problem(planted, [node, neighbor], ends)
    assert not problem.forbidden[[node, neighbor]].any()
    assert not problem.forbidden.all(axis=1).any()
    # where the two need not contradict each other they still speak
    assert find_anchors(problem).labels.shape == planted.labels.shape


@pytest.fixture(scope="module")
def square() -> TriangleMesh:
    """Four squares around vertex 4; vertex 9 is alone, faces 0 and 8 are the same."""
    row, column = np.mgrid[:3, :3]
    corners = np.stack([column.ravel(), row.ravel(), 0 * row.ravel()], axis=1).astype(float)
    first = np.array([0, 1, 3, 4])
    faces = np.concatenate(
        [np.stack([first, first + 1, first + 4], 1), np.stack([first, first + 4, first + 3], 1)]
    )
    return TriangleMesh(
        np.concatenate([[[9.0, 9.0, 9.0]], corners]), 1 + np.concatenate([faces, faces[:1]])
    )


@pytest.fixture(scope="module")
def part(square: TriangleMesh) -> Intake:
    return mesh_intake(square)


def test_faces_at_ignored_vertices_are_left_out(part: Intake) -> None:
    mesh, kept = without_ignored(part, MatchOptions())
    assert mesh.face_count == part.mesh.face_count == 8
    assert kept.tolist() == list(range(9))
    # the corner 3 of the file has one face; the lonely vertex 0 is ignored anyway
    mesh, kept = without_ignored(part, MatchOptions(ignore=(0, 3)))
    np.testing.assert_array_equal(mesh.vertices, part.mesh.vertices[kept])
    assert [2.0, 0.0, 0.0] not in mesh.vertices.tolist()
    assert mesh.face_count == 7
    with pytest.raises(InfeasibleError, match="every face of the part touches an ignored vertex"):
        without_ignored(part, MatchOptions(ignore=tuple(range(10))))


def test_hints_that_name_what_is_not_there_are_refused(part: Intake) -> None:
    check_hints(part, part, MatchOptions(landmarks=((1, 9),), ignore=(2,)))
    with pytest.raises(OptionError, match=r"landmarks names vertex 10 of the part, which has 0..9"):
        check_hints(part, part, MatchOptions(landmarks=((10, 1),)))
    with pytest.raises(OptionError, match="landmarks names vertex 11 of the full shape"):
        check_hints(part, part, MatchOptions(landmarks=((1, 11),)))
    with pytest.raises(OptionError, match="ignore names vertex 12 of the part"):
        check_hints(part, part, MatchOptions(ignore=(1, 12)))
    with pytest.raises(InputError, match=r"landmarks: names vertex 0 .* belongs to no face"):
        pins_of(Template(part), part, np.arange(9), MatchOptions(landmarks=((0, 1),)))


def test_pins_name_the_same_places_in_repaired_numbering(part: Intake) -> None:
    """A landmark whose vertex loses its last face to an ignored neighbor is dropped."""
    template = Template(part)
    options = MatchOptions(landmarks=((9, 1), (3, 7)), ignore=(2,))
    assert landmark_pairs(options).tolist() == [[9, 1], [3, 7]]
    mesh, kept = without_ignored(part, options)
    pins = pins_of(template, part, kept, options)
    assert mesh.vertices[pins.vertices].tolist() == [[2.0, 2.0, 0.0]]
    on_full = part.report.new_vertices[[1]]
    np.testing.assert_array_equal(pins.positions, template.placed.vertices[on_full])
    alone = pins_of(template, part, np.arange(9), options)
    assert part.mesh.vertices[alone.vertices].tolist() == [[2.0, 2.0, 0.0], [2.0, 0.0, 0.0]]


def test_pins_on_one_working_vertex_are_one_pin(planted) -> None:
    blob = planted.question.full.mesh
    surface = DescribedSurface(WorkingSurface(blob, blob, None))
    pins = Pins(np.array([7, 3, 7]), np.eye(3), np.zeros((3, 2), dtype=np.int64))
    assert working_pins(surface, pins).vertices.tolist() == [3, 7]
    np.testing.assert_array_equal(working_pins(surface, pins).positions, np.eye(3)[[1, 0]])
    coarse = working_surface(blob.with_vertices(blob.vertices * 2))
    split = working_pins(DescribedSurface(coarse), pins)
    np.testing.assert_allclose(
        coarse.mesh.vertices[split.vertices], 2 * blob.vertices[[3, 7]], atol=1e-9
    )
