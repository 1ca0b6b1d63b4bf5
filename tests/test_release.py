"""What a release must agree on."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import sherd

ROOT = Path(__file__).parents[1]


def test_the_version_is_the_same_everywhere() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert project["version"] == sherd.__version__
    assert re.findall(r"^version: (.+)$", citation, re.MULTILINE) == [sherd.__version__]


def test_the_conda_recipe_agrees_with_the_project() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    recipe = (ROOT / "packaging" / "conda" / "recipe.yaml").read_text(encoding="utf-8")
    assert re.findall(r'^  version: "(.+)"$', recipe, re.MULTILINE) == [sherd.__version__]
    run = recipe.split("  run:\n")[1].split("\n\n")[0]
    needed = [line.strip().removeprefix("- ").replace(" ", "") for line in run.splitlines()]
    assert needed[1:] == project["dependencies"]
    least = re.findall(r'^  python_min: "(.+)"$', recipe, re.MULTILINE)
    assert [f">={version}" for version in least] == [project["requires-python"]]
