"""identify: the right one of several full shapes, or none, with the reasons."""

from __future__ import annotations

import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import trimesh
from click.testing import CliRunner

from sherd.batching.batch import batch
from sherd.batching.options import BatchOptions
from sherd.cli.many.identifying import identify_command
from sherd.cli.many.templates import template_command
from sherd.errors import InfeasibleError, InputError, OptionError
from sherd.files.mesh_files import write_mesh
from sherd.library.candidate import candidates_of
from sherd.library.evidence import gathered_evidence
from sherd.library.folder import Library
from sherd.library.identify import identify
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.stored.stored_match import read_match
from sherd.report.write import write_report
from sherd.results.many.identification import CandidateAnswer, identification_of
from sherd.results.many.identify_options import IdentifyOptions
from sherd.results.match_options import MatchOptions
from sherd.results.status import Status
from sherd.scan.intake import scan_intake
from sherd.shapes.creature import creature
from sherd.shapes.fragment import cut_by_ball, whole
from sherd.surface.template import Template

SCHEMA = Path(__file__).parents[2] / "docs" / "schema" / "identification.json"


def _lump(name: str, area: float) -> TriangleMesh:
    ball = trimesh.creation.icosphere(subdivisions=3)
    x, y, z = ball.vertices.T
    radius = 1 + 0.3 * x * y - 0.3 * y * z + 0.2 * x
    lump = TriangleMesh(ball.vertices * radius[:, None] * [1, 1.3, 2], ball.faces)
    return TriangleMesh(lump.vertices * np.sqrt(area / lump.area), lump.faces, name=name)


@pytest.fixture(scope="module")
def animal() -> TriangleMesh:
    made = creature(5000)
    return TriangleMesh(made.vertices, made.faces, name="animal.ply")


@pytest.fixture(scope="module")
def part(animal) -> TriangleMesh:
    cut = cut_by_ball(whole(creature(5000, pose="walk"), animal), 0, 0.6).mesh
    return TriangleMesh(cut.vertices, cut.faces, name="part.ply")


@pytest.fixture(scope="module")
def shapes(animal) -> list[Template]:
    lump, grain = _lump("lump.ply", animal.area), _lump("grain.ply", 1e-3 * animal.area)
    return [Template(lump), Template(animal), Template(grain)]


@pytest.fixture(scope="module")
def found(shapes, part):
    return identify(shapes, part)


def test_the_right_shape_is_first_and_matched(found, animal) -> None:
    assert found.status is Status.GOOD
    assert found.advice == "good: belongs to animal.ply"
    assert found.best.name == "animal.ply"
    assert found.match.full is animal
    assert [each.name for each in found.candidates] == ["animal.ply", "lump.ply", "grain.ply"]
    assert found.candidates[1].match is None  # far behind, so it cost no match
    assert found.candidates[0].evidence > 0.8
    assert found.candidates[1].evidence < 0.5
    assert found.candidates[2].said == "impossible by its size"
    assert found.also == ()
    assert "animal.ply" in repr(found)
    assert "lump.ply" in found._repr_html_()


def test_the_part_is_described_once_whatever_the_unit_of_a_shape(shapes, part, found) -> None:
    """Evidence against a shape does not depend on which others are asked."""
    alone = gathered_evidence(candidates_of([shapes[1]]), scan_intake(part), MatchOptions())
    assert alone[0].ratio == pytest.approx(found.candidates[0].ratio, abs=0.03)


def test_evidence_finds_the_scale(shapes, part, found) -> None:
    larger = part.with_vertices(part.vertices * 7.3)
    known = candidates_of(shapes[:2])
    lump, animal = gathered_evidence(known, scan_intake(larger), MatchOptions(scale="unknown"))
    assert animal.ratio < lump.ratio - 0.1


def test_a_foreign_part_belongs_to_none(shapes, part) -> None:
    answer = identify(shapes[:1], part)
    assert answer.status is not Status.GOOD
    if answer.status is Status.FOREIGN:
        assert answer.best is None
        assert answer.match is None
        assert "does not belong to any" in answer.advice


def test_none_is_possible_by_size(shapes, part, tmp_path) -> None:
    answer = identify(shapes[2:], part)
    assert answer.status is Status.FOREIGN
    assert "out of the question by size" in answer.advice
    with pytest.raises(InfeasibleError, match=r"part\.ply"):
        write_report(answer, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_two_that_fit_are_both_named(found) -> None:
    first = found.candidates[0]
    twin = CandidateAnswer("twin.ply", first.evidence, first.ratio, match=first.match)
    unasked = CandidateAnswer("third.ply", 0.9, first.ratio + 0.05)
    behind = CandidateAnswer("behind.ply", 0.8, first.ratio + 0.2)
    options = IdentifyOptions()
    both = identification_of(found.part, [first, twin, unasked], options, {})
    assert both.status is Status.DOUBTFUL
    assert "fits animal.ply and twin.ply about equally well" in both.advice
    also = identification_of(found.part, [behind, unasked, first], options, {})
    assert also.advice == "good: belongs to animal.ply; it also fits third.ply"
    assert [each.name for each in also.also] == ["third.ply"]


def test_options_and_inputs_are_checked(part) -> None:
    with pytest.raises(OptionError, match="matches is 0"):
        IdentifyOptions(matches=0)
    with pytest.raises(OptionError, match="scale is -1"):
        IdentifyOptions(scale=-1)
    with pytest.raises(InputError, match="no full shape"):
        identify([], part)
    with pytest.raises(OptionError, match="'landmarks' is no option"):
        identify([], part, landmarks=((0, 0),))


def test_the_folder_reads_as_that_of_a_match(found, tmp_path) -> None:
    document = write_report(found, tmp_path / "out")
    jsonschema.validate(document["identification"], json.loads(SCHEMA.read_text()))
    assert set(document["identification"]) == set(json.loads(SCHEMA.read_text())["properties"])
    stored = read_match(tmp_path / "out")
    np.testing.assert_array_equal(stored.points.faces, found.match.points.faces)
    rows = (tmp_path / "out" / "candidates.csv").read_text().splitlines()
    assert rows[0] == "name,evidence,ratio,refused,status,chance,score"
    assert rows[1].startswith("animal.ply,")
    page = (tmp_path / "out" / "report.html").read_text()
    assert "belongs to animal.ply" in page.lower()
    assert "lump.ply" in page


@pytest.fixture(scope="module")
def files(shapes, part, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("identify")
    library = Library.open_or_new(folder / "library")
    for template in shapes[:2]:
        library = library.with_shape(template)
        write_mesh(template.full, folder / template.full.name)
    write_mesh(shapes[2].full, folder / "grain.ply")
    write_mesh(part, folder / "part.ply")
    return folder


def test_the_command_asks_a_library(files, tmp_path, found) -> None:
    words = [files / "library", files / "part.ply", "-o", tmp_path / "out"]
    done = CliRunner().invoke(identify_command, [str(word) for word in words])
    assert done.exception is None or isinstance(done.exception, SystemExit), done.output
    assert "belongs to animal.ply" in done.output
    stored = read_match(tmp_path / "out")
    np.testing.assert_array_equal(stored.points.faces, found.match.points.faces)


def test_a_batch_asks_a_library(files, tmp_path, found) -> None:
    with ThreadPoolExecutor(1) as here:
        done = batch(files / "library", [files / "part.ply"], tmp_path / "out", executor=here)
    (row,) = done.rows
    assert (row.full, row.status) == ("animal.ply", "good")
    stored = read_match(tmp_path / "out" / "parts" / "part")
    np.testing.assert_array_equal(stored.points.faces, found.match.points.faces)
    document = json.loads((tmp_path / "out" / "parts" / "part" / "result.json").read_text())
    assert "--template" in document["command"]
    assert not (tmp_path / "out" / "templates").exists()
    wrong = BatchOptions(template=files / "t.npz")
    with pytest.raises(InputError, match="a library has them"):
        batch(files / "library", [files / "part.ply"], tmp_path / "no", batch_options=wrong)


def test_the_commands_refuse_what_they_cannot_do(files, tmp_path) -> None:
    def said(command, *words: object) -> str:
        done = CliRunner().invoke(command, [str(word) for word in words])
        return f"{done.output} {done.exception}"

    out, part = tmp_path / "out", files / "part.ply"
    mixed = said(identify_command, files / "library", files / "lump.ply", part, "-o", out)
    assert "a library is named alone" in mixed
    assert "by size" in said(identify_command, files / "grain.ply", part, "-o", out)
    assert not out.exists()
    assert "is no library" in said(identify_command, tmp_path, part, "-o", out)
    lump = files / "lump.ply"
    assert "a library is a folder" in said(template_command, lump, "-o", tmp_path / "lump.npz")
    assert "is named twice" in said(template_command, lump, lump, "-o", out)
    twice = said(template_command, files / "lump.ply", "-o", files / "library")
    assert "in the library already" in twice
    (out / "mine").mkdir(parents=True)
    (out / "notes.txt").write_text("mine")
    assert "holds notes.txt" in said(identify_command, lump, part, "-o", out)
