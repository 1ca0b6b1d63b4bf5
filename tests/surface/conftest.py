"""A small shape without symmetry, and its template."""

from __future__ import annotations

import pytest
import trimesh

from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.surface.template import Template


@pytest.fixture(scope="session")
def egg() -> TriangleMesh:
    """642 vertices; at unit scale its edges are too long, so the working mesh splits them."""
    ball = trimesh.creation.icosphere(subdivisions=3)
    x, y, z = ball.vertices.T
    stretched = ball.vertices * [1.0, 1.3, 1.9]
    return TriangleMesh(
        stretched * (1 + 0.2 * x + 0.1 * y + 0.15 * z + 0.1 * y * z)[:, None],
        ball.faces,
        name="egg",
    )


@pytest.fixture(scope="session")
def template(egg: TriangleMesh) -> Template:
    made = Template(egg)
    made.prepare()
    return made
