"""Two views of one camera each: what looks away from either viewer is not shared."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from sherd.correspondence.labels.labeling import SAME_SCALE
from sherd.correspondence.question import Question
from sherd.correspondence.shared.viewed import are_views, viewed_problems
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes import creature, cut_by_ball, whole
from sherd.shapes.camera_view import seen_by_camera
from sherd.surface.described import DescribedSurface
from sherd.surface.prepared import described_part

# The second camera stands half a right angle beside the first.
BESIDE = np.radians(45.0)


def _questions(first: TriangleMesh, second: TriangleMesh) -> tuple[Question, Question]:
    unit = max(first.length, second.length)
    one, other = described_part(first, unit), described_part(second, unit)
    return Question(one, other, SAME_SCALE), Question(other, one, SAME_SCALE)


def _in_place(surface: DescribedSurface) -> SimpleNamespace:
    """A shape that is not turned, all of it shared."""
    count = surface.mesh.vertex_count
    deformation = SimpleNamespace(rotations=np.tile(np.eye(3), (count, 1, 1)))
    return SimpleNamespace(deformation=deformation, shared=np.ones(count, dtype=bool))


@pytest.fixture(scope="module")
def body():
    return whole(creature(5000), creature(5000))


@pytest.fixture(scope="module")
def views(body) -> tuple[Question, Question]:
    frame = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    turn = np.array(
        [
            [np.cos(BESIDE), 0.0, np.sin(BESIDE)],
            [0.0, 1.0, 0.0],
            [-np.sin(BESIDE), 0.0, np.cos(BESIDE)],
        ]
    )
    return _questions(seen_by_camera(body, frame).mesh, seen_by_camera(body, frame @ turn).mesh)


def test_cut_pieces_are_no_views(body):
    halves = [cut_by_ball(body, center, 0.5).mesh for center in (0, 3000)]
    assert not are_views(_questions(*halves))


def test_what_looks_away_from_either_viewer_is_placed_nowhere(views):
    assert are_views(views)
    there, back = views
    places = (_in_place(there.part), _in_place(back.part))
    for question, problem in zip(views, viewed_problems(views, places, 0), strict=True):
        full, part = question.full, question.part
        label_away = full.normals[problem.labels.vertices] @ part.viewer < -0.15
        node_away = part.normals[part.sparse.vertices] @ full.viewer < -0.15
        assert label_away.any()  # the cameras see different sides of some limbs
        assert node_away.any()
        assert problem.forbidden[:, label_away].all()
        assert problem.forbidden[node_away].all()
        facing = full.normals[problem.labels.vertices] @ part.viewer > 0
        assert not problem.forbidden[:, facing].all()
