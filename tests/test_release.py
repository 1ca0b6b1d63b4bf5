"""What a release must agree on."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest
from hatchling.build import build_sdist, build_wheel

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


@pytest.fixture(scope="module")
def packages(tmp_path_factory) -> tuple[Path, Path]:
    """Wheel and source archive."""
    dist = tmp_path_factory.mktemp("dist")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(ROOT)
        return dist / build_wheel(str(dist)), dist / build_sdist(str(dist))


def test_the_wheel_holds_the_library_and_nothing_else(packages) -> None:
    wheel, _ = packages
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
        metadata = archive.read(f"sherd-{sherd.__version__}.dist-info/METADATA").decode()
    source = ROOT / "src"
    expected = {
        path.relative_to(source).as_posix()
        for path in (source / "sherd").rglob("*")
        if path.is_file() and "__pycache__" not in path.parts  # compiled loops lie there too
    }
    assert {name for name in names if ".dist-info/" not in name} == expected
    assert {"sherd/py.typed", "sherd/report/assets/page.html"} <= names
    assert f"\nVersion: {sherd.__version__}\n" in metadata
    for version in ("3.11", "3.12", "3.13"):
        assert f"Classifier: Programming Language :: Python :: {version}" in metadata
    assert "Requires-Python: >=3.11" in metadata
    assert wheel.stat().st_size < 3_000_000


def test_the_archive_holds_what_its_own_gate_needs(packages) -> None:
    _, archive = packages
    with tarfile.open(archive) as content:
        names = {name.partition("/")[2] for name in content.getnames()}
    for needed in (
        "Makefile",
        "constraints.txt",
        "tests/test_release.py",
        "docs/index.md",
        "LICENSE",
    ):
        assert needed in names
    assert not [name for name in names if name.startswith((".venv", "dist", "build", "out/"))]


def test_the_installed_wheel_runs_without_the_repository_and_extras(packages, tmp_path) -> None:
    """Beside the libraries of this environment, as no index is asked; `make package` asks one."""
    wheel, _ = packages
    site = tmp_path / "site"
    words = [
        "-m",
        "pip",
        "install",
        "-q",
        "--no-index",
        "--no-deps",
        "--no-compile",
        "--target",
        site,
    ]
    subprocess.run([sys.executable, *map(str, words), str(wheel)], check=True)
    program = """
import sys
extras = {"matplotlib", "piqp", "clarabel", "hypothesis", "jsonschema", "playwright", "pytest"}
class Refused:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in extras:
            raise ImportError(f"{name} is an extra")
sys.meta_path.insert(0, Refused())
import sherd, numpy
from sherd.surface.coarse import coarse_surface
for name in sherd.__all__:
    getattr(sherd, name)
import importlib
for module, function, _ in importlib.import_module("sherd.cli.main").COMMANDS.values():
    if function != "bench_group":
        getattr(importlib.import_module(module), function)
print(sherd.__file__)
"""
    environment = {**os.environ, "PYTHONPATH": str(site)}
    done = subprocess.run(
        [sys.executable, "-c", program],
        check=False,
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=environment,
    )
    assert done.returncode == 0, done.stderr
    assert Path(done.stdout.strip()).is_relative_to(tmp_path)
