"""Three small shapes and a library of them."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest
import trimesh

from sherd.library.folder import Library
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.surface.template import Template


def _egg(name: str, *bumps: float) -> TriangleMesh:
    ball = trimesh.creation.icosphere(subdivisions=3)
    x, y, z = ball.vertices.T
    radius = 1 + bumps[0] * x * y + bumps[1] * y * z + bumps[2] * x
    return TriangleMesh(ball.vertices * radius[:, None] * [1.0, 1.3, 1.9], ball.faces, name=name)


@pytest.fixture(scope="session")
def eggs() -> tuple[TriangleMesh, TriangleMesh]:
    return _egg("smooth", 0.1, 0.1, 0.2), _egg("bent", 0.5, -0.4, 0.1)


@pytest.fixture(scope="session")
def templates(eggs) -> tuple[Template, ...]:
    return tuple(Template(egg) for egg in eggs)


@pytest.fixture(scope="session")
def made_once(templates, tmp_path_factory) -> Library:
    made = Library.open_or_new(tmp_path_factory.mktemp("made") / "library")
    for template in templates:
        made = made.with_shape(template)
    return made


@pytest.fixture
def library(made_once, tmp_path: Path) -> Library:
    """A copy that a test may break."""
    shutil.copytree(made_once.folder, tmp_path / "library")
    return replace(made_once, folder=tmp_path / "library")
