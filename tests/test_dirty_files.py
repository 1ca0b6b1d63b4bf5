"""One file, one answer: dirty scans through Python and the command line, and on either side."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from sherd.cli.main import main
from sherd.files.mesh_files import write_mesh
from sherd.locate import locate
from sherd.match import match
from sherd.mesh.sides import turned_over
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.locate_options import LocateOptions
from sherd.results.match_options import MatchOptions
from sherd.results.match_result import MatchResult
from sherd.results.status import Status
from sherd.shapes.creature import creature, landmarks
from sherd.shapes.fragment import Fragment, cut_by_ball, moved, remeshed, whole
from sherd.surface.template import Template


@pytest.fixture(scope="module")
def template() -> Template:
    return Template(creature(5000))


@pytest.fixture(scope="module")
def fragment(template: Template) -> Fragment:
    """The head and the front legs, walking, meshed anew."""
    full = template.full
    piece = cut_by_ball(whole(creature(5000, pose="walk"), full), landmarks(full)["nose"], 0.6)
    return moved(remeshed(piece, 1.1), np.random.default_rng(3))


def soup(mesh: TriangleMesh) -> TriangleMesh:
    """Three vertices a face as in STL, one face in twelve turned, and a vertex on no face.

    STL has no such vertex but those of a facet without area, which comes first.
    """
    corners = np.concatenate([np.zeros((1, 3), dtype=int), mesh.faces])
    corners[5::12] = corners[5::12, ::-1]
    faces = np.arange(3 * len(corners)).reshape(-1, 3)
    return TriangleMesh(mesh.vertices[corners].reshape(-1, 3), faces)


@pytest.fixture(scope="module")
def files(fragment: Fragment, tmp_path_factory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("dirty")
    write_mesh(soup(fragment.full), folder / "full.stl")
    write_mesh(soup(fragment.mesh), folder / "part.stl")
    return folder / "full.stl", folder / "part.stl"


@pytest.fixture(scope="module")
def in_python(files: tuple[Path, Path]) -> MatchResult:
    return match(*files)


def errors(found: MatchResult, truth: np.ndarray) -> np.ndarray:
    return np.linalg.norm(found.positions - truth, axis=1) / found.full.length


def test_a_dirty_file_is_matched_in_its_own_numbering(
    in_python: MatchResult, fragment: Fragment
) -> None:
    part = fragment.mesh
    assert in_python.part.vertex_count == 3 * (part.face_count + 1)
    assert in_python.full.vertex_count == 3 * (fragment.full.face_count + 1)
    assert in_python.status is Status.GOOD
    truth = fragment.truth.positions(fragment.full)[part.faces].reshape(-1, 3)
    assert errors(in_python, np.concatenate([truth[:3], truth]))[3:].mean() < 0.015
    # the vertices of the facet without area
    assert not in_python.matched[:3].any()
    assert (in_python.confidence[:3] == 0).all()
    assert in_python.matched[3:].mean() > 0.99
    assert not in_python.best.mask[:3].any()
    for which in ("full", "part"):
        said = "; ".join(in_python.notices[which])
        for word in ("joined", "turned", "without area", "on no face"):
            assert word in said, said


def test_the_command_line_gives_the_same_bytes(
    files: tuple[Path, Path], in_python: MatchResult, tmp_path: Path
) -> None:
    words = ["match", *map(str, files), "-o", str(tmp_path / "out"), "--export", "npz", "-q"]
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 0, done.output
    with np.load(tmp_path / "out" / "result.npz") as stored:
        written = {name: stored[name] for name in stored.files}
    expected = {
        "full_face": in_python.points.faces,
        "barycentric": in_python.points.barycentric,
        "confidence": in_python.confidence,
        "matched": in_python.matched,
        "membership": in_python.best.membership,
        "region": in_python.best.mask,
    }
    for name, values in expected.items():
        np.testing.assert_array_equal(written[name], values, err_msg=name)


@pytest.mark.parametrize("side", ["either", "given"])
def test_a_part_inside_out_is_matched_if_either_side_may_be_meant(
    template: Template, fragment: Fragment, side
) -> None:
    inside_out = turned_over(fragment.mesh)
    found = match(template, inside_out, MatchOptions(side=side))
    error = errors(found, fragment.truth.positions(fragment.full))
    if side == "either":
        np.testing.assert_array_equal(found.part.faces, fragment.mesh.faces)
        assert error.mean() < 0.015
        assert found.status is Status.GOOD
    else:
        np.testing.assert_array_equal(found.part.faces, inside_out.faces)
        assert error.mean() > 0.05
        assert found.status is not Status.GOOD


def test_a_part_inside_out_is_located_if_either_side_may_be_meant(
    template: Template, fragment: Fragment
) -> None:
    areas = template.full.vertex_areas
    right = locate(template, fragment.mesh)
    inside_out = turned_over(fragment.mesh)
    either = locate(template, inside_out)
    given = locate(template, inside_out, LocateOptions(side="given"))
    shared = areas[right.mask & either.mask].sum() / areas[right.mask | either.mask].sum()
    assert shared > 0.9
    np.testing.assert_array_equal(either.part.faces, fragment.mesh.faces)
    np.testing.assert_array_equal(given.part.faces, inside_out.faces)
    assert given.score < either.score - 0.1
    assert either.score == right.score
