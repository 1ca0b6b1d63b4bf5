"""Every code block of the README and of docs/ runs."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from sherd.cli.main import COMMANDS, main

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def blocks(language: str) -> list[tuple[str, str]]:
    found = []
    for page in PAGES:
        for kind, text in BLOCK.findall(page.read_text(encoding="utf-8")):
            if kind == language:
                found.append((page.name, text))
    return found


@pytest.mark.parametrize(("page", "code"), blocks("python"))
def test_python_blocks_run(page: str, code: str, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    exec(compile(code, page, "exec"), {"__name__": "__main__"})  # noqa: S102


@pytest.mark.parametrize(("page", "text"), blocks(""))
def test_command_blocks_name_real_commands_and_options(page: str, text: str) -> None:
    for line in text.splitlines():
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


def test_make_targets_exist() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for page in PAGES:
        for target in re.findall(r"^make (\w+)", page.read_text(encoding="utf-8"), re.MULTILINE):
            assert re.search(rf"^{target}:", makefile, re.MULTILINE), f"{page.name}: make {target}"


def test_links_lead_somewhere() -> None:
    for page in PAGES:
        for link in re.findall(r"\]\((?!http)([^)#]+)", page.read_text(encoding="utf-8")):
            assert (page.parent / link).exists(), f"{page.name}: {link}"
