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
