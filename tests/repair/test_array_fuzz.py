"""Damaged arrays: every case ends in a mesh that repair makes sound, or in an error of sherd.

SHERD_FUZZ_CASES sets the number of cases (300 if unset).
"""

from __future__ import annotations

import json
import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sherd.errors import InputError
from sherd.files.encode import encoded
from sherd.mesh import topology
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.repair.changes import degenerate_faces
from sherd.repair.inspection import inspect
from sherd.repair.repair import repair

CASES = int(os.environ.get("SHERD_FUZZ_CASES", "300"))

SEED = st.integers(0, 2**32 - 1)
EXPONENT = st.sampled_from([-320, -200, -160, -81, -61, -59, -30, -6, 0, 6, 30, 60, 69, 71, 160])
SHARE = st.sampled_from([0.02, 0.3, 0.7, 1.0])


def ball(rows=6, columns=9):
    """A bumpy closed surface without symmetry."""
    u, v = np.meshgrid(np.linspace(0.3, 2.9, rows), np.arange(columns) * 2 * np.pi / columns)
    radius = 1 + 0.2 * np.sin(3 * u + 2 * v)
    points = radius * np.stack([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)])
    at = np.arange(rows * columns).reshape(columns, rows)
    a, b = at[:, :-1].ravel(), at[:, 1:].ravel()
    c, d = np.roll(at, -1, axis=0)[:, :-1].ravel(), np.roll(at, -1, axis=0)[:, 1:].ravel()
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)])
    return points.reshape(3, -1).T.copy(), faces


def flattened(vertices, hit, rng):
    vertices[hit] *= rng.permutation([1.0, rng.choice([0.0, 1e-17, 1e-9]), 1.0])


def on_a_line(vertices, hit, rng):
    vertices[hit] = vertices[hit, :1] * rng.normal(size=3)


def in_one_place(vertices, hit, rng):
    vertices[hit] = vertices[rng.integers(len(vertices))] + rng.choice([0.0, 5e-324, 1e-12])


def far_away(vertices, hit, rng):
    vertices[hit] += rng.choice([1e3, 1e9, 1e16, 1e60])


def shaken(vertices, hit, rng):
    vertices[hit] += rng.normal(size=(hit.sum(), 3)) * rng.choice([1e-16, 1e-7, 1e-3, 1.0, 1e5])


def not_finite(vertices, hit, rng):
    vertices[hit] = rng.choice([np.nan, np.inf, -np.inf])


def on_a_grid(vertices, hit, rng):
    vertices[hit] = np.round(vertices[hit] * rng.choice([1.0, 3.0]))


def doubled(faces, hit, rng):
    return np.concatenate([faces, rng.permuted(faces[hit], axis=1)])


def turned(faces, hit, rng):
    return np.where(hit[:, None], faces[:, ::-1], faces)


def lost(faces, hit, rng):
    return faces[~hit]


def at_random(faces, hit, rng):
    return np.where(hit[:, None], rng.integers(faces.max() + 1, size=faces.shape), faces)


def around_one_edge(faces, hit, rng):
    pages = faces.copy()
    pages[hit, :2] = rng.integers(faces.max() + 1, size=2)
    return pages


def out_of_range(faces, hit, rng):
    wrong = faces.copy()
    wrong[hit, rng.integers(3)] = rng.choice([-1, 10**6, 2**62])
    return wrong


OF_VERTICES = (flattened, on_a_line, in_one_place, far_away, shaken, not_finite, on_a_grid)
OF_FACES = (doubled, turned, lost, at_random, around_one_edge, out_of_range)
CHANGE = st.tuples(st.sampled_from(OF_VERTICES + OF_FACES), SHARE, SEED)


def checked(vertices, faces):
    try:
        mesh = TriangleMesh(vertices, faces, fields={"weight": np.arange(len(vertices))})
        report = inspect(mesh)
        json.dumps(report.as_dict(), allow_nan=False)
        assert str(report).endswith(("usable as it is", "usable after repair", "unusable"))
        repaired, done = repair(mesh)
    except InputError as refusal:
        message = str(refusal)
    else:
        message = "one line"
        check_repaired(mesh, repaired, done, report.usable)
    assert "\n" not in message


def check_repaired(mesh, repaired, done, usable):
    assert (usable == "usable") == (not done.changed)
    assert not degenerate_faces(repaired.vertices, repaired.faces).any()
    assert topology.unique_edges(repaired.faces)[1].max() <= 2
    assert np.array_equal(repaired.vertices, mesh.vertices[done.original_vertices])
    assert len(done.to_original(repaired.fields["weight"])) == mesh.vertex_count
    assert np.isfinite(repaired.vertex_normals).all()
    assert len(encoded(repaired, ".ply")) > 0


@settings(max_examples=CASES, deadline=None)
@given(changes=st.lists(CHANGE, min_size=1, max_size=4), exponent=EXPONENT)
def test_damaged_arrays(changes, exponent):
    vertices, faces = ball()
    with np.errstate(all="ignore"):
        for change, share, seed in changes:
            rng = np.random.default_rng(seed)
            if change in OF_VERTICES:
                change(vertices, rng.random(len(vertices)) < share, rng)
            elif len(faces):
                faces = change(faces, rng.random(len(faces)) < share, rng)
        vertices = vertices * 10.0**exponent
    checked(vertices, faces)


@pytest.mark.parametrize("count", [1, 2, 3, 50])
@pytest.mark.parametrize("change", [in_one_place, on_a_line, flattened, on_a_grid])
def test_few_faces_without_form(count, change):
    vertices, faces = ball()
    change(vertices, np.ones(len(vertices), dtype=bool), np.random.default_rng(count))
    checked(vertices, faces[:count])
