"""match and locate on parts with clutter, damaged scans, and balls spoiled at random.

A twentieth of SHERD_FUZZ_CASES is the number of random cases (3 if unset).
"""

from __future__ import annotations

import os

import numpy as np
import pytest
import trimesh

from sherd.errors import InfeasibleError, InvalidMeshError
from sherd.locate import locate
from sherd.match import match
from sherd.mesh.surface_points import SurfacePoints
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.repair.repair import repair
from sherd.results.status import Status
from sherd.scan.intake import scan_intake
from sherd.shapes.creature import creature
from sherd.shapes.fragment import (
    Fragment,
    cut_by_ball,
    cut_by_plane,
    cut_in_pieces,
    largest_piece,
    moved,
    remeshed,
    whole,
    with_clutter,
    with_flipped_faces,
)
from sherd.spectral.geodesics import Geodesics
from sherd.surface.template import Template
from sherd.surface.working import canonical, working_surface

CASES = max(1, int(os.environ.get("SHERD_FUZZ_CASES", "60")) // 20)


@pytest.fixture(scope="module")
def template() -> Template:
    return Template(creature(5000))


def errors(part: Fragment, answers: SurfacePoints) -> np.ndarray:
    gap = answers.positions(part.full) - part.truth.positions(part.full)
    return np.linalg.norm(gap, axis=1) / part.full.length


def test_a_shred_along_the_cut_is_not_folded_aside(template: Template) -> None:
    """The plane splits a leg lengthwise; its half, alone beyond the trunk's cut, can bend aside."""
    posed = whole(creature(5000, pose="walk"), template.full)
    normal = np.array([1.0, 0.3, 0.1])
    place = np.quantile(posed.mesh.vertices @ normal, 0.7) * normal / (normal @ normal)
    part = moved(largest_piece(cut_by_plane(posed, place, normal)), np.random.default_rng(0))
    error = errors(part, match(template, part.mesh).points)
    assert error.mean() < 0.01
    assert (error > 0.15).mean() < 0.01


def test_pieces_of_one_scan_find_their_own_limbs(template: Template) -> None:
    """Three slices of the front half: two of the four pieces are legs, which look alike."""
    posed = whole(creature(5000, pose="walk"), template.full)
    front = cut_by_plane(posed, np.median(posed.mesh.vertices, axis=0), [1.0, 0.3, 0.1])
    clean = remeshed(largest_piece(front), 1.1)
    part = moved(cut_in_pieces(clean, 3, width=0.03), np.random.default_rng(0))
    labels = part.mesh.component_labels
    assert labels.max() == 3
    error = errors(part, match(template, part.mesh).points)
    assert (np.bincount(labels, error) / np.bincount(labels)).max() < 0.03
    assert error.mean() < 0.01


def test_faces_turned_at_random_are_mended_and_both_sides_tried(template: Template) -> None:
    """Half of the faces: repair makes them agree, but cannot tell the outside of an open part."""
    posed = whole(creature(5000, pose="walk"), template.full)
    part = remeshed(cut_by_ball(posed, 100, 0.4), 1.1)
    spoiled = with_flipped_faces(part, 0.5, rng=np.random.default_rng(0)).mesh
    with pytest.raises(InvalidMeshError, match=r"at [45]\d % of the edges .*sherd.repair"):
        working_surface(canonical(spoiled, template.length))
    scan = scan_intake(spoiled)
    assert not scan.side_known
    assert any("turned" in notice for notice in scan.notices)
    for side in (scan, scan.turned_over()):
        result = match(template, side)
        assert result.part.faces.tolist() == part.mesh.faces.tolist()
        assert errors(part, result.points).mean() < 0.02


def test_clutter_is_unmatched_and_the_rest_is_not(template: Template) -> None:
    """A ball of 5 % of the area beside the part: it belongs nowhere."""
    full = template.full
    rng = np.random.default_rng(1)
    clean = remeshed(cut_by_ball(whole(creature(5000, pose="walk"), full), 100, 0.6), 1.1)
    part = moved(with_clutter(clean, 0.05, rng=rng), rng)
    result = match(template, part.mesh)
    matched = result.matched
    assert matched[part.present].mean() > 0.97
    assert matched[~part.present].mean() < 0.1
    assert result.confidence[~part.present].max() < 0.1
    assert errors(part, result.points)[part.present].mean() < 0.02


def sewn_across(mesh: TriangleMesh, count: int) -> TriangleMesh:
    """`count` pairs of faces joined by a strip, near in space but far along the surface."""
    some = np.random.default_rng(0).choice(np.unique(mesh.faces), 300, replace=False)
    along = Geodesics(mesh).distances_from(some)
    straight = np.linalg.norm(mesh.vertices[some][:, None] - mesh.vertices, axis=2)
    detour = np.where(along > 0.3 * mesh.length, along / np.maximum(straight, 1e-9), 0.0)
    strips = []
    for row in np.argsort(-detour.max(axis=1))[:count]:
        ends = some[row], detour[row].argmax()
        one, two = (mesh.faces[(mesh.faces == end).any(axis=1)][0] for end in ends)
        strips += [[one[0], one[1], two[0]], [two[0], two[1], one[0]]]
    return TriangleMesh(mesh.vertices, np.concatenate([mesh.faces, strips]))


def test_skin_joined_to_skin_does_not_mislead(template: Template) -> None:
    """Where limbs touch, scanners and surfaces through points join them: paths become shorter."""
    posed = whole(creature(5000, pose="gallop"), template.full)
    axis = np.linalg.svd(
        posed.mesh.vertices - posed.mesh.vertices.mean(axis=0), full_matrices=False
    )[2][0]
    half = largest_piece(cut_by_plane(posed, posed.mesh.vertices.mean(axis=0), axis))
    part = moved(half, np.random.default_rng(1))
    error = errors(part, match(template, sewn_across(part.mesh, 40)).points)
    assert error.mean() < 0.01


# Shapes with fewer vertices than a labeling has proposals, and far longer than wide.
BARE = {
    "triangle": ([[0, 0, 0], [2, 0, 0], [0, 2, 0.0]], [[0, 1, 2]]),
    "hair": ([[0, 0, 0], [1e4, 0, 0], [0, 4e-4, 0.0]], [[0, 1, 2]]),
}


@pytest.mark.parametrize("name", list(BARE))
def test_bare_faces_are_answered(name) -> None:
    ball = trimesh.creation.icosphere(1)
    full, part = TriangleMesh(*BARE[name]), TriangleMesh(0.1 * ball.vertices, ball.faces)
    assert np.isfinite(match(full, part).best.membership).all()


CHANGES = ("lost", "doubled", "turned", "torn off", "flattened", "shaken")


def damaged(
    mesh: TriangleMesh, change: str, share: float, rng: np.random.Generator, *, far: float = 0.1
) -> TriangleMesh:
    """The mesh after a change to a random share of its faces, or of its vertices if shaken."""
    vertices, faces = np.array(mesh.vertices), np.array(mesh.faces)
    some = rng.random(len(faces)) < share
    if change == "lost":
        faces = faces if some.all() else faces[~some]
    elif change == "doubled":
        faces = np.concatenate([faces, faces[some]])
    elif change == "turned":
        faces[some] = faces[some][:, ::-1]
    elif change == "torn off":
        faces[some] = rng.integers(len(vertices), size=(some.sum(), 3))
    elif change == "flattened":
        vertices[np.unique(faces[some])] *= [1.0, 1.0, 0.0]
    else:
        hit = rng.random(len(vertices)) < share
        vertices[hit] += rng.normal(size=(hit.sum(), 3)) * far
    return TriangleMesh(vertices, faces)


@pytest.fixture(scope="module")
def scan(template: Template) -> Fragment:
    """The rear of the walking animal, 2,000 vertices: matched with a mean error of 0.005."""
    posed = whole(creature(5000, pose="walk"), template.full)
    return moved(remeshed(cut_by_ball(posed, 100, 0.6), 1.1), np.random.default_rng(0))


@pytest.mark.parametrize(
    ("changes", "share", "bound"),
    [
        # triangles alone are spoiled: half an edge, as without damage
        (("lost", "doubled", "turned"), 0.02, 0.008),
        # every fiftieth vertex is seven edges off, and its neighborhood looks like no other
        (("shaken",), 0.02, 0.025),
    ],
)
def test_a_damaged_scan_finds_its_place(template: Template, scan, changes, share, bound) -> None:
    mesh, rng = scan.mesh, np.random.default_rng(1)
    for change in changes:
        mesh = damaged(mesh, change, share, rng)
    mended, report = repair(mesh)
    truth = scan.truth[report.original_vertices]
    known = Fragment(mended, truth, scan.full, scan.present[report.original_vertices])
    assert errors(known, match(template, mended).points).mean() < bound


def test_a_scan_in_shreds_finds_its_place_more_often_than_not(template: Template) -> None:
    """A hundred patches without a way from one to the next, the largest a third of the area.

    One damage in four puts a leg's patches on another leg: each patch is too small to know better.
    """
    posed = whole(creature(5000, pose="walk"), template.full)
    rear = cut_by_ball(posed, 100, 0.6)
    means = []
    for draw in range(3):
        scan = moved(remeshed(rear, 1.1 + 0.03 * draw), np.random.default_rng(draw))
        mended, report = repair(damaged(scan.mesh, "lost", 0.3, np.random.default_rng(draw)))
        truth = scan.truth[report.original_vertices]
        known = Fragment(mended, truth, scan.full, scan.present[report.original_vertices])
        result = match(template, mended)
        means.append(errors(known, result.points).mean())
        # what puts patches elsewhere is 0.05 off, and a good one up to 0.02
        assert result.status is not Status.GOOD or means[-1] < 0.03
    assert np.median(means) < 0.045  # three edges


def test_a_scan_beyond_help_is_doubtful_or_refused(template: Template, scan) -> None:
    rng = np.random.default_rng(1)
    flat = repair(damaged(scan.mesh, "flattened", 0.02, rng))[0]  # 6 % of the vertices in a plane
    result = match(template, flat)
    assert result.status is not Status.GOOD
    assert result.confidence.mean() < 0.2  # 0.1, more or less by machine
    torn = repair(damaged(scan.mesh, "torn off", 0.02, rng))[0]
    with pytest.raises(InfeasibleError, match="are the two swapped"):
        match(template, torn)


def spoiled_ball(rng: np.random.Generator) -> TriangleMesh:
    """A bumpy ball of 12 to 642 vertices in any unit after one to three random changes."""
    ball = trimesh.creation.icosphere(int(rng.integers(0, 4)))
    bumps = 1 + 0.2 * np.sin(ball.vertices @ rng.normal(size=(3, 1)) * 3)
    mesh = TriangleMesh(ball.vertices * bumps, ball.faces)
    for change in rng.choice(CHANGES, size=rng.integers(1, 4)):
        share = 0.02 if change == "shaken" else rng.choice([0.02, 0.3, 0.7])
        mesh = damaged(mesh, change, share, rng, far=rng.choice([1e-9, 0.1, 10.0]))
    return mesh.with_vertices(mesh.vertices * 10.0 ** rng.integers(-6, 7))


@pytest.mark.parametrize("case", range(CASES))
@pytest.mark.parametrize("method", [match, locate])
def test_spoiled_balls_are_answered(method, case) -> None:
    """All of them: faces with an area are left in each, and the part is never too large."""
    rng = np.random.default_rng(case)
    full, part = repair(spoiled_ball(rng))[0], repair(spoiled_ball(rng))[0]
    size = full.length / part.length * rng.choice([0.1, 0.5, 0.9])
    found = method(full, part.with_vertices(part.vertices * size))
    region = found.best
    assert region.mask.shape == region.membership.shape == (full.vertex_count,)
    assert ((region.membership >= 0) & (region.membership <= 1)).all()
    assert region.mask.any()
    if method is match:
        assert len(found.points) == part.vertex_count
        assert np.isfinite(found.points.positions(full)).all()
        assert ((found.confidence > 0) & (found.confidence < 1)).all()
    assert np.isfinite(region.score)
