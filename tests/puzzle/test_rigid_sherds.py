"""Sherds of a vase, solid and with faces of fracture, on the whole one: all is known."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

import sherd
from sherd.correspondence.labels.labeling import Problem
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.puzzle.rigid import rigid_trials
from sherd.puzzle.rigid.motion import RigidMotion
from sherd.puzzle.rigid.rigid_answer import rigid_answer
from sherd.puzzle.rigid.rigid_trials import rigid_chance
from sherd.puzzle.rigid.surface_fit import roughness
from sherd.puzzle.rigid.voting import voted_motions
from sherd.results.puzzle.assemble_options import TOLERANCE
from sherd.results.puzzle.assembly import PieceAnswer
from sherd.results.status import Status
from sherd.shapes import Sherd, vase, vase_sherds


@pytest.fixture(scope="module")
def answer() -> tuple[sherd.Assembly, tuple[Sherd, ...]]:
    """Two own sherds and one of another vase, whose place is free.

    Every second face of the whole looks inward: repaired on the way in, and the answer is about
    what was given.
    """
    own = vase_sherds(5, vertex_count=8000, seed=1)[:2]
    other = vase_sherds(5, vertex_count=8000, seed=5)[2]
    full = vase(8000, seed=1)
    outward = np.arange(full.face_count)[:, None] % 2 == 0
    turned = np.where(outward, full.faces, full.faces[:, ::-1])
    return sherd.assemble(
        (full.vertices, turned), [*(each.mesh for each in own), other.mesh], rigid=True
    ), own


def share_of_walls(piece: Sherd, matched: np.ndarray) -> float:
    areas = piece.mesh.vertex_areas * piece.on_wall
    return float(areas @ matched / areas.sum())


def test_sherds_come_home_though_fractures_fit_nowhere(answer) -> None:
    found, own = answer
    assert found.placed == (0, 1)
    for piece, sherd_ in zip(found.pieces[:2], own, strict=True):
        assert np.abs(piece.transform - sherd_.transform).max() < 0.02
        assert piece.match.status is Status.GOOD
        assert "of the piece lie on the full shape" in piece.reason
    assert found.check().passed


def test_what_lies_nowhere_for_the_most_part_is_doubtful(answer) -> None:
    """As closely as nothing lies, nothing does, though the place is the right one."""
    piece = answer[0].pieces[0]
    motion = RigidMotion(piece.transform[:3, :3], piece.transform[:3, 3])
    assert rigid_answer(piece.match, motion, piece.chance, TOLERANCE).status is Status.GOOD
    judged = rigid_answer(piece.match, motion, piece.chance, 1e-6)
    assert judged.status is Status.DOUBTFUL
    assert "give each by itself" in judged.advice


def test_fractures_have_no_point_on_the_whole(answer) -> None:
    found, own = answer
    for piece, sherd_ in zip(found.pieces[:2], own, strict=True):
        matched = piece.match.matched
        assert share_of_walls(sherd_, matched) > 0.9
        assert matched[~sherd_.on_wall].mean() < 0.5
        assert piece.match.confidence[~matched].max() < 0.1


def test_a_sherd_of_another_vase_is_refused(answer) -> None:
    found, _ = answer
    assert not found.pieces[2].placed
    assert found.pieces[2].match.status is Status.FOREIGN


def test_a_place_that_no_vote_is_for_is_searched_for(monkeypatch) -> None:
    """As of a small sherd, all of whose neighborhoods have a face of fracture in them."""
    full = vase(8000, seed=1)
    piece = vase_sherds(16, vertex_count=8000, seed=1)[3]

    def answer() -> PieceAnswer:
        return sherd.assemble(full, [piece.mesh], rigid=True).pieces[0]

    def voted(problem: Problem, count: int) -> list[RigidMotion]:
        nodes = problem.question.part.mesh.vertices[problem.nodes.vertices]
        first, *others = voted_motions(problem, count)  # the first is right
        return [
            other
            for other in others
            if np.linalg.norm(other(nodes) - first(nodes), axis=1).mean() > 0.3
        ]

    monkeypatch.setattr(rigid_trials, "voted_motions", voted)
    found = answer()
    monkeypatch.setattr(rigid_trials, "HOPS", 0)
    assert not answer().placed
    assert found.sure
    assert np.abs(found.transform - piece.transform).max() < 0.02


def test_what_fits_all_around_is_refused_with_the_reason() -> None:
    """A piece of a plain tube belongs, but nothing says where."""
    tube = trimesh.creation.cylinder(radius=1.0, height=3.0, sections=60)
    tube = trimesh.Trimesh(*trimesh.remesh.subdivide_to_size(tube.vertices, tube.faces, 0.25))
    middles = tube.vertices[tube.faces].mean(axis=1)
    full = TriangleMesh(tube.vertices, tube.faces)
    piece, _ = full.submesh((middles[:, 0] > 0.2) & (np.abs(middles[:, 2]) < 0.9))
    (answer,) = sherd.assemble(full, [piece], rigid=True).pieces
    assert not answer.placed
    assert "in several places" in answer.reason


def test_a_place_is_sure_if_nothing_else_fits_as_closely() -> None:
    near, far, exact = 0.0002, 0.0015, 0.0003

    def chance(distance: float, *elsewhere: float) -> float:
        return rigid_chance(distance, elsewhere, exact, TOLERANCE)

    assert chance(near, far, far) > 0.95
    assert chance(near, near, far) > 0.85  # its twin: the joint choice decides
    assert chance(near, near, near, far) < 0.05  # a plain vase, all around
    assert chance(far, 1.1 * far, 1.2 * far) < 0.05
    assert chance(0.0008, 0.001, 0.008) < 0.05  # the foot of another vase fits on the foot only
    assert chance(0.00004, 0.00008, 0.00012) < 0.05  # a flat chip
    assert chance(0.5 * TOLERANCE) < 0.05


def test_what_a_mesh_may_be_off_by_is_its_noise_and_its_curvature() -> None:
    ball = trimesh.creation.icosphere(subdivisions=4)
    smooth = TriangleMesh(ball.vertices, ball.faces)
    assert roughness(smooth) == pytest.approx(0.5 * smooth.mean_edge_length**2, rel=0.1)
    rng = np.random.default_rng(0)
    noisy = smooth.with_vertices(
        ball.vertices * (1 + 0.01 * rng.normal(size=(len(ball.vertices), 1)))
    )
    assert 0.003 < roughness(noisy) < 0.02


def test_what_can_be_turned_in_its_place_is_not_sure() -> None:
    """A whole that is its own image after half a turn, and its foot, which is round about it."""
    ball = trimesh.creation.icosphere(subdivisions=5)
    x, y, z = ball.vertices.T
    bumps = 1 + 0.08 * np.cos(4 * x * y) + 0.05 * np.sin(5 * z) + 0.05 * x * y * z
    full = TriangleMesh(ball.vertices * bumps[:, None], ball.faces)
    middles = ball.vertices[ball.faces].mean(axis=1)
    foot, _ = full.submesh(middles[:, 2] < -0.5)
    (piece,) = sherd.assemble(full, [foot], rigid=True).pieces
    assert piece.chance < 0.6
    assert not piece.sure
