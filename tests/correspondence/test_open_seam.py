"""How much of the border of what is shared lies where neither shape ends."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.correspondence.labels.labeling import SAME_SCALE
from sherd.correspondence.question import Question
from sherd.correspondence.registration import Deformation
from sherd.correspondence.shared.open_border import MOST_OPEN, open_seam
from sherd.correspondence.shared.region_cut import WIDTH
from sherd.correspondence.shared.round_trip import round_trip
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.surface.described import DescribedSurface
from sherd.surface.working import working_surface

COUNT = 61  # fine enough for no edge to be split


def flat(width: float) -> TriangleMesh:
    """A strip of the unit square, `width` wide."""
    number = np.arange(COUNT * COUNT).reshape(COUNT, COUNT)
    x, y = np.meshgrid(*2 * [np.linspace(0, 1, COUNT)], indexing="ij")
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    faces = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    mesh = TriangleMesh(np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3), faces)
    inside = (mesh.vertices[faces][:, :, 0] <= width + 1e-9).all(axis=1)
    return mesh.submesh(inside)[0]


def still(mesh: TriangleMesh) -> Deformation:
    return Deformation(mesh.vertices, np.tile(np.eye(3), (mesh.vertex_count, 1, 1)))


def openness(part: TriangleMesh, full: TriangleMesh, shared: np.ndarray) -> float:
    """Of `part` lying where it is on `full`."""
    question = Question(*(DescribedSurface(working_surface(m)) for m in (full, part)), SAME_SCALE)
    trip = round_trip(question, still(part), still(full))
    return open_seam(question, trip, shared)


def test_a_border_in_the_middle_of_both_is_open_but_for_its_ends() -> None:
    whole = flat(1.0)
    half = whole.vertices[:, 0] <= 0.5
    area = float(whole.vertex_areas @ half)
    expected = (1 - 4 * WIDTH) / np.sqrt(area)
    assert openness(whole, whole, half) == pytest.approx(expected, rel=0.06)


def test_a_border_where_the_other_shape_ends_is_not_open() -> None:
    whole = flat(1.0)
    assert openness(whole, flat(0.5), whole.vertices[:, 0] <= 0.5) == 0.0


def test_where_all_is_shared_or_nothing() -> None:
    whole = flat(1.0)
    everything = np.ones(whole.vertex_count, dtype=bool)
    assert openness(whole, whole, everything) == 0.0
    assert openness(whole, whole, ~everything) == MOST_OPEN
