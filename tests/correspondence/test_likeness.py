"""How alike two shapes are where one was laid on the other, both seeing only what is shared."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from sherd.correspondence.labels.labeling import SAME_SCALE
from sherd.correspondence.question import Question
from sherd.correspondence.shared.likeness import (
    handed_by_relief,
    likeness_inside,
    recognized_by_relief,
)
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes import creature
from sherd.surface.described import DescribedSurface
from sherd.surface.working import working_surface


@pytest.fixture(scope="module")
def question() -> Question:
    """A standing animal, and the same one walking."""
    standing, walking = creature(5000), creature(5000, pose="walk")
    unit = standing.length
    surfaces = (
        DescribedSurface(working_surface(mesh.with_vertices(mesh.vertices / unit)))
        for mesh in (standing, walking)
    )
    return Question(*surfaces, SAME_SCALE)


@pytest.fixture(scope="module")
def front(question: Question) -> tuple[np.ndarray, np.ndarray]:
    """The front three fifths of both, by the place on the standing one."""
    along = np.argmax(np.ptp(question.full.mesh.vertices, axis=0))
    return tuple(
        mesh.vertices[:, along] > np.quantile(mesh.vertices[:, along], 0.4)
        for mesh in (question.full.mesh, question.part.mesh)
    )


def at_the_other_end(mesh: TriangleMesh) -> np.ndarray:
    """Of each vertex of an animal the place of one as far from the other end."""
    along = np.argmax(np.ptp(mesh.vertices, axis=0))
    turned = mesh.vertices.copy()
    turned[:, along] = turned[:, along].min() + turned[:, along].max() - turned[:, along]
    return mesh.vertices[cKDTree(mesh.vertices).query(turned)[1]]


def test_the_right_place_leads_though_both_are_cut(question, front) -> None:
    there = question.full.mesh.vertices  # both poses have the same vertices
    found = likeness_inside(question, there, front[1], front[0])
    assert found.leading > 0.8
    assert found.lack < 0.02


def test_a_place_at_the_other_end_does_not_lead(question, front) -> None:
    mesh = question.full.mesh
    there = at_the_other_end(mesh)
    right = likeness_inside(question, mesh.vertices, front[1], front[0])
    wrong = likeness_inside(question, there, front[1], front[0])
    assert wrong.leading < right.leading - 0.4
    assert wrong.lack > 3 * right.lack


def test_nothing_shared_says_nothing(question, front) -> None:
    there, nothing = question.full.mesh.vertices, np.zeros_like(front[1])
    assert likeness_inside(question, there, nothing, front[0]) is None
    assert likeness_inside(question, there, front[1], nothing) is None


def test_by_relief_places_are_more_alike_than_mirrored_but_not_those_of_the_other_side(
    question, front
) -> None:
    mesh = question.full.mesh
    turned = mesh.vertices * np.array([1.0, -1.0, 1.0])  # left is where y is positive
    there = mesh.vertices[cKDTree(mesh.vertices).query(turned)[1]]
    right = handed_by_relief(question, mesh.vertices, front[1])
    wrong = handed_by_relief(question, there, front[1])
    assert right is not None
    assert wrong is not None
    assert right > 0.75
    assert wrong < 0.4


def test_by_relief_too_little_says_nothing(question, front) -> None:
    there, nothing = question.full.mesh.vertices, np.zeros_like(front[1])
    assert handed_by_relief(question, there, nothing) is None


def test_skin_is_recognized_where_it_lies_and_not_elsewhere(question, front) -> None:
    mesh = question.full.mesh
    assert recognized_by_relief(question, mesh.vertices, front[1]) > 0.7
    there = at_the_other_end(mesh)
    assert recognized_by_relief(question, there, front[1]) < 0.2
    assert recognized_by_relief(question, there, np.zeros_like(front[1])) is None
