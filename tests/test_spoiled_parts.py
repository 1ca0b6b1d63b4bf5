"""match and locate on parts with clutter, and on meshes at random damaged at array level.

A twentieth of SHERD_FUZZ_CASES is the number of random cases (3 if unset).
"""

from __future__ import annotations

import os

import numpy as np
import pytest
import trimesh

from sherd.errors import InputError
from sherd.match import match
from sherd.mesh.repair import repair
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.region.locate import locate
from sherd.shapes.creature import creature
from sherd.shapes.fragment import cut_by_ball, moved, remeshed, whole, with_clutter

CASES = max(1, int(os.environ.get("SHERD_FUZZ_CASES", "60")) // 20)


def test_clutter_is_unmatched_and_the_rest_is_not() -> None:
    """A ball of 5 % of the area beside the part: it belongs nowhere."""
    full = creature(5000)
    rng = np.random.default_rng(1)
    clean = remeshed(cut_by_ball(whole(creature(5000, pose="walk"), full), 100, 0.6), 1.1)
    part = moved(with_clutter(clean, 0.05, rng=rng), rng)
    result = match(full, part.mesh)
    matched = result.point_map.matched
    assert matched[part.present].mean() > 0.97
    assert matched[~part.present].mean() < 0.1
    assert result.point_map.confidence[~part.present].max() < 0.1
    gap = result.point_map.points.positions(full) - part.truth.positions(full)
    error = np.linalg.norm(gap, axis=1)[part.present] / full.length
    assert error.mean() < 0.02


def damaged(rng: np.random.Generator) -> TriangleMesh:
    """A bumpy ball of which at random faces are lost, doubled, turned, torn off or made flat."""
    ball = trimesh.creation.icosphere(int(rng.integers(0, 4)))
    vertices = ball.vertices * (1 + 0.2 * np.sin(ball.vertices @ rng.normal(size=(3, 1)) * 3))
    faces = np.array(ball.faces)
    for change in rng.choice(6, size=rng.integers(1, 4)):
        some = rng.random(len(faces)) < rng.choice([0.02, 0.3, 0.7])
        if change == 0 and not some.all():
            faces = faces[~some]
        elif change == 1:
            faces = np.concatenate([faces, faces[some]])
        elif change == 2:
            faces[some] = faces[some][:, ::-1]
        elif change == 3:
            faces[some] = rng.integers(len(vertices), size=(some.sum(), 3))
        elif change == 4:
            vertices[np.unique(faces[some])] *= [1.0, 1.0, 0.0]
        else:
            hit = rng.random(len(vertices)) < 0.02
            vertices[hit] += rng.normal(size=(hit.sum(), 3)) * rng.choice([1e-9, 0.1, 10.0])
    return TriangleMesh(vertices * 10.0 ** rng.integers(-6, 7), faces)


@pytest.mark.parametrize("case", range(CASES))
@pytest.mark.parametrize("method", [match, locate])
def test_damaged_meshes_are_answered_or_refused(method, case) -> None:
    rng = np.random.default_rng(case)
    try:
        full, part = repair(damaged(rng))[0], repair(damaged(rng))[0]
        size = full.length / part.length * rng.choice([0.1, 0.5, 0.9])
        found = method(full, part.with_vertices(part.vertices * size))
    except InputError:
        return
    if method is locate:
        values = [found.membership, [found.score]]
    else:
        assert len(found.point_map) == part.vertex_count
        values = [found.point_map.barycentric, found.point_map.confidence]
        values += [found.region.membership, list(found.scores.values())]
    for value in values:
        assert np.isfinite(value).all()
    assert found.check() is not None
