"""A bumpy sphere and a turned half of it: everything about the pair is known exactly."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from sherd.drawing.colors import correspondence_layer
from sherd.drawing.exhibit import Alternative, Exhibit, Layer, Partner
from sherd.mesh.surface_points import points_at_vertices
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.match_options import MatchOptions
from sherd.results.match_result import MatchResult
from sherd.results.placement import Placement
from sherd.results.status import Status


def bumpy_sphere(subdivisions: int) -> TriangleMesh:
    """Asymmetric and smooth, longest along x."""
    sphere = trimesh.creation.icosphere(subdivisions=subdivisions)
    x, y, z = sphere.vertices.T
    radius = 1 + 0.25 * np.sin(3 * x + y) * np.cos(2 * z) + 0.1 * y
    return TriangleMesh(
        sphere.vertices * radius[:, None] * [1.6, 1.0, 0.8], sphere.faces, name="whole.ply"
    )


def make_exhibit(subdivisions: int = 3, **changes: object) -> Exhibit:
    """The half with x > 0, rotated, with an exact map; its twin is the other half."""
    full = bumpy_sphere(subdivisions)
    inside = full.vertices[full.faces].mean(axis=1)[:, 0] > 0
    piece, old = full.submesh(inside)
    turn = Rotation.from_rotvec([0.4, 1.1, -0.7]).as_matrix()
    part = TriangleMesh(piece.vertices @ turn.T, piece.faces, name="piece.ply")
    mask = np.zeros(full.vertex_count, dtype=bool)
    mask[old] = True
    membership = 1 / (1 + np.exp(-4 * full.vertices[:, 0]))
    matched = np.ones(len(old), dtype=bool)
    matched[[0, 5]] = False
    confidence = np.linspace(0.2, 1.0, len(old))
    twin = points_at_vertices(full, np.roll(old, 7))
    given = {
        "title": "piece.ply on whole.ply",
        "full": full,
        "part": part,
        "full_layers": (
            Layer("membership", membership, range=(0, 1), color_map="ember", description="Soft."),
            correspondence_layer(full),
            Layer("mask", mask, "mask"),
            Layer("octant", (full.vertices > 0) @ [1, 2, 4], "category", carried=True),
        ),
        "part_layers": (Layer("confidence", confidence, range=(0, 1)),),
        "partner": Partner(points_at_vertices(full, old), matched, confidence),
        "anchors": np.stack([np.arange(10, 20), old[10:20]], axis=1),
        "score": 0.95,
        "alternatives": (
            Alternative(
                "other half",
                0.71,
                "The opposite side.",
                full_layers=(
                    Layer("membership", 1 - membership, range=(0, 1), color_map="ember"),
                    Layer("mask", ~mask, "mask"),
                ),
                partner=Partner(twin, matched, confidence / 2),
            ),
        ),
        "summary": ("The part is half of the full shape.", "2 vertices have no partner."),
        "facts": {
            "Time": {"solve": 0.25, "steps": {"first": 1, "second": float("nan")}},
            "Part": {"area": 19567.8},
        },
        "command": "sherd match whole.ply piece.ply -o out/",
        "takes_hints": True,
    }
    return Exhibit(**(given | changes))


@pytest.fixture(scope="session")
def exhibit() -> Exhibit:
    return make_exhibit()


@pytest.fixture(scope="session")
def exhibit_of_size():
    """The same shapes in other resolutions and with other words."""
    return make_exhibit


def make_match(exhibit: Exhibit) -> MatchResult:
    """The exact match of the half with a field on the full shape, and its twin."""
    points, known = exhibit.partner.points, exhibit.partner.known
    thickness = np.linspace(1, 2, exhibit.full.vertex_count)
    full = TriangleMesh(
        exhibit.full.vertices, exhibit.full.faces, fields={"thickness": thickness}, name="w.ply"
    )
    mask = np.asarray(exhibit.region)
    twin = Placement(
        mask=~mask,
        membership=(~mask).astype(float),
        score=0.8,
        mirrored=True,
        points=exhibit.alternatives[0].partner.points,
    )
    return MatchResult(
        full=full,
        part=exhibit.part,
        best=Placement(
            mask=mask,
            membership=exhibit.full_layers[0].values,
            score=0.9,
            points=points,
            matched=known,
            confidence=exhibit.partner.confidence,
        ),
        alternatives=(twin,),
        scale=1.0,
        second_score=None,
        twin_score=0.8,
        status=Status.GOOD,
        options=MatchOptions(),
        timings={},
        version="1",
    )


@pytest.fixture(scope="session")
def match_result_of():
    """Build the result of a match from an exhibit."""
    return make_match


@pytest.fixture(scope="session")
def bottle() -> TriangleMesh:
    """A closed round thing with a neck, as large as a leg."""
    turn, height = np.meshgrid(np.arange(40) * np.pi / 20, np.linspace(0, 1, 40), indexing="ij")
    radius = 0.03 + 0.12 * np.exp(-20 * (height - 0.3) ** 2)
    points = np.stack([radius * np.cos(turn), radius * np.sin(turn), height], axis=2)
    number = np.arange(1600).reshape(40, 40)
    right = np.roll(number, -1, axis=0)
    corners = number[:, :-1], right[:, :-1], right[:, 1:], number[:, 1:]
    halves = [np.stack([corners[k] for k in half], axis=2) for half in ((0, 1, 2), (0, 2, 3))]
    faces = np.concatenate([half.reshape(-1, 3) for half in halves])
    return TriangleMesh(points.reshape(-1, 3), faces, name="bottle")
