"""assemble: puzzles of the generated animal, which have one right answer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import sherd
from sherd.arrays import Ints
from sherd.cli.assembling import assembly_summary
from sherd.errors import InputError, InvalidMeshError, OptionError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results import advice
from sherd.results.puzzle.assembly import Assembly
from sherd.results.status import Status
from sherd.shapes import creature, moved, puzzle_pieces, remeshed
from sherd.shapes.fragment import Fragment
from sherd.spectral.surface_distances import SurfaceDistances
from sherd.surface.template import Template


@pytest.fixture(scope="module")
def template() -> Template:
    return Template(creature(5000))


@pytest.fixture(scope="module")
def pieces(template: Template) -> list[Fragment]:
    """Four pieces, two of each pose, meshed anew and turned."""
    rng = np.random.default_rng(5)
    walking, full = creature(5000, pose="walk"), template.full
    cut = puzzle_pieces(full, [walking, full, walking, full])
    return [moved(remeshed(piece, 1.1), rng) for piece in cut]


@pytest.fixture(scope="module")
def foreign() -> TriangleMesh:
    """A torus: nothing on the animal is like it."""
    u, v = np.meshgrid(*2 * [np.arange(60) * 2 * np.pi / 60], indexing="ij")
    ring = 1.0 + 0.4 * np.cos(v)
    vertices = np.stack([ring * np.cos(u), ring * np.sin(u), 0.4 * np.sin(v)], axis=2)
    number = np.arange(3600).reshape(60, 60)
    right, up = np.roll(number, -1, axis=0), np.roll(number, -1, axis=1)
    both = np.roll(right, -1, axis=1)
    faces = np.concatenate(
        [
            np.stack(each, axis=2).reshape(-1, 3)
            for each in ((number, right, both), (number, both, up))
        ]
    )
    return TriangleMesh(vertices.reshape(-1, 3), faces, name="torus")


def true_labels(pieces: list[Fragment]) -> Ints:
    regions = np.array([piece.region for piece in pieces])
    return np.where(regions.any(axis=0), regions.argmax(axis=0), -1)


@pytest.fixture(scope="module")
def answer(template: Template, pieces: list[Fragment]) -> Assembly:
    return sherd.assemble(template, [piece.mesh for piece in pieces])


def test_each_piece_is_placed_and_each_vertex_given_to_its_piece(answer, pieces) -> None:
    assert answer.placed == (0, 1, 2, 3)
    right = answer.labels == true_labels(pieces)
    areas = answer.full.vertex_areas
    assert areas @ right / areas.sum() > 0.96
    distances = SurfaceDistances(answer.full)
    for piece, found in zip(pieces, answer.pieces, strict=True):
        error = distances.between(piece.truth, found.match.points).mean()
        assert error < 0.015  # two thirds of an edge


def test_memberships_are_at_least_0_and_sum_to_1(answer) -> None:
    check = answer.check()
    assert check.passed
    total = answer.memberships.sum(axis=0) + answer.gap_membership
    assert np.abs(total - 1.0).max() < 1e-9
    assert answer.memberships.min() >= 0


def test_touching_pieces_are_those_that_were_cut_apart(answer, pieces) -> None:
    labels = true_labels(pieces)
    ends = np.sort(labels[answer.full.edges], axis=1)
    apart = ends[(ends[:, 0] != ends[:, 1]) & (ends[:, 0] >= 0)]
    true = {
        (int(one), int(other)) for one, other in apart if (apart == (one, other)).all(1).sum() > 8
    }
    found = {
        (contact.first, contact.second) for contact in answer.contacts if contact.length > 0.05
    }
    assert true <= {(c.first, c.second) for c in answer.contacts}
    assert found <= {(int(one), int(other)) for one, other in apart}
    assert all(contact.apart < 0.02 * answer.full.length for contact in answer.contacts)


def test_what_is_missing_is_the_gap_and_what_is_foreign_is_refused(
    template, pieces, foreign
) -> None:
    present = [pieces[0], pieces[1], pieces[3]]
    size = np.sqrt(0.2 * template.full.area / foreign.area)
    other = foreign.with_vertices(foreign.vertices * size)
    answer = sherd.assemble(template, [*(piece.mesh for piece in present), other])
    assert answer.placed == (0, 1, 2)
    assert answer.pieces[3].reason
    areas, missing = answer.full.vertex_areas, pieces[2].region
    union = areas @ ((answer.labels < 0) | missing)
    assert areas @ ((answer.labels < 0) & missing) / union > 0.85
    assert abs(answer.gaps[0].area - areas @ missing) < 0.1 * answer.full.area
    assert missing[answer.gaps[0].vertex]


def test_of_two_equal_pieces_one_is_refused_and_says_for_which(template, pieces) -> None:
    meshes = [pieces[1].mesh, pieces[0].mesh, pieces[1].mesh]
    answer = sherd.assemble(template, meshes)
    assert 1 in answer.placed
    assert len(answer.placed) == 2
    (refused,) = answer.refused
    assert answer.pieces[refused].instead == 2 - refused
    assert f"piece {2 - refused}" in answer.pieces[refused].reason


def test_a_copy_is_not_laid_into_a_gap() -> None:
    full = creature(5000)
    first, second, _ = puzzle_pieces(full, [creature(5000, pose="walk"), full, full])
    answer = sherd.assemble(full, [first.mesh, second.mesh, second.mesh])
    assert len(answer.placed) == 2
    (refused,) = answer.refused
    assert answer.pieces[refused].instead == 3 - refused
    assert answer.gap_share > 0.2


def test_a_scan_that_lies_on_several_is_refused_with_the_remedy(template) -> None:
    """Each covers more than half of the others; two are enough to use most places up."""
    full, walking = template.full, creature(5000, pose="walk")
    scans = [each.mesh for each in puzzle_pieces(full, [walking, full, walking], overlap=0.5)]
    answer = sherd.assemble(template, scans)
    (refused,) = answer.refused
    assert "% of its place where piece" in answer.pieces[refused].reason
    assert "--may-overlap" in answer.pieces[refused].reason
    for contact in answer.contacts:  # borders lie inside others, so nothing is open
        assert not contact.gap > 0
    allowed = sherd.assemble(template, scans, may_overlap=True)
    assert allowed.placed == (0, 1, 2)


def test_chances_of_pieces_are_those_that_their_answers_speak_of(answer) -> None:
    for piece in answer.pieces:
        assert piece.match.chance == piece.chance
        assert piece.sure == (piece.match.status is Status.GOOD)


def test_a_doubtful_place_says_who_takes_landmarks(template, pieces, monkeypatch) -> None:
    monkeypatch.setattr(advice, "SURE", 1.0)
    (found,) = sherd.assemble(template, [pieces[0].mesh]).pieces
    assert found.placed
    assert not found.sure
    assert found.reason.startswith("doubtful: the chance that the placement is right is 0.")
    assert found.reason.endswith("can be given to sherd match, of this piece alone")


def test_scans_of_one_region_may_overlap_if_allowed(template, pieces) -> None:
    answer = sherd.assemble(template, [pieces[1].mesh, pieces[1].mesh], may_overlap=True)
    assert answer.placed == (0, 1)
    (shared,) = answer.shared
    assert shared.area > 0.8 * answer.full.vertex_areas @ pieces[1].region
    assert answer.check().passed


def test_rigid_pieces_come_home_to_rounding() -> None:
    """Cut from the standing animal, turned and shifted: the motion is known."""
    full = creature(5000)
    rng = np.random.default_rng(8)
    cut = puzzle_pieces(full, [full, full, full])
    there = [moved(piece, rng) for piece in cut]
    # whatever is worn, what fits exactly does
    answer = sherd.assemble(full, [piece.mesh for piece in there], rigid=True, tolerance=1e-4)
    assert answer.placed == (0, 1, 2)
    for before, after, found in zip(cut, there, answer.pieces, strict=True):
        turn, shift = found.transform[:3, :3], found.transform[:3, 3]
        assert np.abs(turn @ turn.T - np.eye(3)).max() < 1e-12
        assert np.linalg.det(turn) > 0
        home = after.mesh.vertices @ turn.T + shift
        assert np.abs(home - before.mesh.vertices).max() < 1e-9 * full.length
        assert np.abs(found.on_full.vertices - before.mesh.vertices).max() < 1e-9 * full.length
        assert found.match.matched.all()  # no mesh is asked to fit as closely as that
        off = found.match.positions - before.mesh.vertices
        assert np.abs(off).max() < 1e-8 * full.length


def test_a_piece_that_is_too_large_is_refused_with_the_reason(template, pieces) -> None:
    large = pieces[0].mesh.with_vertices(pieces[0].mesh.vertices * 100)
    answer = sherd.assemble(template, [pieces[1].mesh, large])
    assert answer.placed == (0,)
    assert "times the area" in answer.pieces[1].reason
    assert "--" not in answer.pieces[1].reason  # there is no option for units here
    assert answer.pieces[1].match is None


def test_the_same_question_has_the_same_answer(template, pieces, answer) -> None:
    again = sherd.assemble(template, [piece.mesh for piece in pieces])
    assert np.array_equal(again.labels, answer.labels)
    assert np.array_equal(again.memberships, answer.memberships)


def test_no_pieces_and_unknown_options_are_refused(template) -> None:
    with pytest.raises(InputError, match="no pieces"):
        sherd.assemble(template, [])
    with pytest.raises(OptionError, match="tolerance"):
        sherd.AssembleOptions(tolerance=0.5)
    with pytest.raises(OptionError, match="tolerance is x"):
        sherd.AssembleOptions(tolerance="x")
    with pytest.raises(OptionError, match="is for rigid pieces: give rigid=True"):
        sherd.AssembleOptions(tolerance=0.02)
    with pytest.raises(OptionError, match="overlap"):
        sherd.assemble(template, [], overlap=True)


def test_one_shape_instead_of_several_is_refused(template, pieces) -> None:
    mesh = pieces[0].mesh
    for one in (mesh, "piece.ply", (mesh.vertices, mesh.faces)):
        with pytest.raises(InputError, match=r"write \[piece\]"):
            sherd.assemble(template, one)


def test_errors_of_arrays_say_which_piece_is_meant(template, pieces) -> None:
    mesh = pieces[0].mesh
    with pytest.raises(InvalidMeshError, match="piece 1: vertices"):
        sherd.assemble(template, [mesh, (np.full_like(mesh.vertices, np.nan), mesh.faces)])


def test_a_choice_that_was_broken_off_is_doubtful_and_says_why(answer, tmp_path) -> None:
    assert answer.proven
    assert answer.status is Status.GOOD
    broken = replace(answer, proven=False)
    assert broken.status is Status.DOUBTFUL
    assert "a better choice of places" in assembly_summary(broken, tmp_path)
    assert "a better choice of places" not in assembly_summary(answer, tmp_path)
    sherd.write_report(broken, tmp_path / "broken")
    page = (tmp_path / "broken" / "report.html").read_text(encoding="utf-8")
    assert "may be a better choice of places for all pieces together" in page
