"""Every code block of the README and of docs/ runs."""

from __future__ import annotations

import pydoc
import re
import runpy
from pathlib import Path

import pytest
from click.testing import CliRunner
from latex2mathml.converter import convert

import sherd
from sherd.cli.main import COMMANDS, main

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
PAGES = [page for page in PAGES if "_build" not in page.parts]
BLOCK = re.compile(r"^ *```([^\n`]*)\n(.*?)^ *```$", re.MULTILINE | re.DOTALL)


def blocks(language: str) -> list[tuple[str, str]]:
    found = []
    for page in PAGES:
        for kind, text in BLOCK.findall(page.read_text(encoding="utf-8")):
            if kind == language:
                found.append((page.name, text))
    return found


def test_blocks_are_found() -> None:
    """Without any, the tests below would have no cases and be skipped."""
    assert len(blocks("python")) >= 8
    assert sum("sherd " in text for _, text in blocks("")) >= 8


@pytest.mark.parametrize(("page", "code"), blocks("python"))
def test_python_blocks_run(page: str, code: str, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    exec(compile(code, page, "exec"), {"__name__": "__main__"})  # noqa: S102


@pytest.mark.parametrize(("page", "text"), blocks(""))
def test_command_blocks_name_real_commands_and_options(page: str, text: str) -> None:
    lines = [part for line in text.splitlines() for part in line.split("&&")]
    for line in lines:
        words = line.split("#")[0].split()
        if words[:1] != ["sherd"] or len(words) < 2 or words[1].startswith("-"):
            continue
        path = [word for word in words[1:3] if word.islower() and "." not in word]
        path = path if path[0] == "bench" else path[:1]
        assert path[0] in COMMANDS, f"{page}: {line}"
        described = CliRunner().invoke(main, [*path, "--help"], standalone_mode=False).output
        for word in words:
            if word.startswith("--"):
                assert word in described, f"{page}: {line}"


def test_a_folder_on_a_page_holds_the_answers_to_one_question() -> None:
    """Whoever types a page from top to bottom is not refused for what the page wrote before."""
    command = re.compile(r"^sherd (match|locate) (\S+) (\S+) .*-o (\S+?)/?(?: |$)", re.MULTILINE)
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        found = [(where, question) for *question, where in command.findall(text)]
        found += [(where, ["python"]) for where in re.findall(r'report\(.*"(\w+)/?"', text)]
        questions: dict[str, list[str]] = {}
        for where, question in found:
            assert questions.setdefault(where, question) == question, f"{page.name}: {where}"


def test_equations_become_mathml() -> None:
    """The converter passes on what it does not know, and the build of the pages refuses that."""
    equations = [text for _, text in blocks("math")]
    for page in PAGES:
        prose = re.sub("`[^`\n]*`", "", BLOCK.sub("", page.read_text(encoding="utf-8")))
        equations += prose.split("$")[1::2]
    assert len(equations) > 20
    for equation in equations:
        converted = convert(equation)
        assert "<mi>\\" not in converted, equation
        assert "<mi>&</mi>" not in converted, equation


def test_equations_survive_every_reader_of_markdown() -> None:
    """Forges read ```math and $...$, but within lines take a backslash before a sign for an escape.

    And whoever writes formulas as plain text again leaves readers to guess what is a symbol.
    """
    assert sum(len(re.findall("^ *```math$", page.read_text("utf-8"), re.M)) for page in PAGES) >= 4
    for page in PAGES:
        prose = re.sub("`[^`\n]*`", "", BLOCK.sub("", page.read_text(encoding="utf-8")))
        assert prose.count("$") % 2 == 0, page.name
        for equation in prose.split("$")[1::2]:
            assert "\n" not in equation, f"{page.name}: ${equation}$"
            assert equation.strip() == equation, f"{page.name}: ${equation}$"
            assert not re.search(r"\\[^A-Za-z]", equation), f"{page.name}: ${equation}$"
        words = " ".join(prose.split("$")[::2])
        assert not re.search(r"lambda_\w|epsilon\b|\brho\b", words), page.name


def test_make_targets_exist() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for page in PAGES:
        for target in re.findall(r"^make (\w+)", page.read_text(encoding="utf-8"), re.MULTILINE):
            assert re.search(rf"^{target}:", makefile, re.MULTILINE), f"{page.name}: make {target}"


def test_links_lead_somewhere() -> None:
    for page in PAGES:
        for link in re.findall(r"\]\((?!http)([^)#]+)", page.read_text(encoding="utf-8")):
            assert (page.parent / link).exists(), f"{page.name}: {link}"


def test_every_page_is_in_the_table_of_contents() -> None:
    docs = ROOT / "docs"
    index = (docs / "index.md").read_text(encoding="utf-8")
    listed = set(re.findall(r"^([\w/-]+)$", index, re.MULTILINE))
    written = {
        str(page.relative_to(docs).with_suffix(""))
        for page in PAGES
        if docs in page.parents and page.parent.name != "tables"
    }
    assert written - {"index"} == listed


def test_every_public_name_has_a_place_in_the_reference() -> None:
    page = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    described = re.findall(r"auto(?:function|class|exception):: ([\w.]+)", page)
    # what is part of a result is described where it is defined
    assert {each for each in described if "." not in each} == set(sherd.__all__) - {"__version__"}
    assert all(pydoc.locate(each) for each in described if "." in each)


def test_pictures_are_small_and_used() -> None:
    words = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    for picture in (ROOT / "docs" / "images").iterdir():
        assert picture.stat().st_size < 300_000, picture.name
        assert f"images/{picture.name}" in words, picture.name


def test_tables_are_made_from_what_benchmarks_write() -> None:
    program = runpy.run_path(str(ROOT / "docs" / "tables.py"))
    names = (
        "mean", "median", "flips", "coverage", "iou", "iou_vertices", "calibration_error",
        "seconds", "seconds_median", "near", "large", "present",
    )  # fmt: skip
    total = dict.fromkeys(names, 0.5) | {"pairs": 3, "bad_pairs": 1, "refused": 2}
    lines = program["table"]("shrec16", {"remeshed": {"totals": {"cuts": total}}}).splitlines()
    assert lines[2].startswith("| remeshed | cuts | 3 | 50.00 | 50.00 | 1 | 50.0% |")
    assert len({line.count("|") for line in lines}) == 1
    total |= dict.fromkeys(("mirror_forgiven", "recognized", "ranking"))  # not known
    document = {"totals": {"balls": total}, "together": total}
    lines = program["table"]("individuals", {"people": document}).splitlines()
    assert lines[2].startswith(
        "| people | balls | 3 (2) | 50.00 | 50.00 | 50.0% | 50.0% | 50.0% | -"
    )
    assert lines[3].startswith("| people | together |")
    assert len({line.count("|") for line in lines}) == 1
    row = dict.fromkeys(("iou", "iou_mirror_forgiven", "iou_with_alternatives", "seconds"), 0.25)
    lines = program["table"]("region", {"stored": {"rows": [row, row]}}).splitlines()
    assert lines[2].startswith("| stored | 2 | 0.250 |")
    assert len({line.count("|") for line in lines}) == 1
    total = dict.fromkeys(("puzzles", "bad", "own", "own_refused", "foreign", "foreign_refused"), 2)
    total |= dict.fromkeys(("labels", "error", "seconds"), 0.5) | dict.fromkeys(
        ("refusal_f1", "gap_iou")
    )
    document = {"totals": {"together": total, "single": total}}
    lines = program["table"]("puzzles", {"wolves": document}).splitlines()
    assert lines[2].startswith("| wolves | together | 2 | 0.500 | 50.00 | 2 of 2 |")
    assert len({line.count("|") for line in lines}) == 1
    row = dict.fromkeys(("own", "together", "joined", "joined_right"), 6)
    row |= {"puzzle": "wolf", "foreign_alone": True, "error": None, "known": 0.9, "seconds": 3.2}
    lines = program["table"]("joins", {"tosca": {"rows": [row]}}).splitlines()
    assert lines[2] == "| wolf (tosca) | 6 of 6 | 6 of 6 | yes | - | 0.90 | 3 |"
    assert len({line.count("|") for line in lines}) == 1
