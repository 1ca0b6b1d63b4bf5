"""The partition: cracks, strips that two claim, and real gaps on a square."""

from __future__ import annotations

import numpy as np
import pytest

from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.puzzle.partition import DELTA, GAP, Partition, border_depth, seam_lengths

SIDE = 100


@pytest.fixture(scope="module")
def square() -> TriangleMesh:
    """Unit area, vertices a hundredth apart, as on a mesh of 10,000."""
    x, y = np.meshgrid(np.linspace(0, 1, SIDE + 1), np.linspace(0, 1, SIDE + 1), indexing="ij")
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    faces = np.concatenate(
        [np.stack([a, b, c], axis=2).reshape(-1, 3), np.stack([a, c, d], axis=2).reshape(-1, 3)]
    )
    return TriangleMesh(np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1), faces)


def test_a_strip_that_two_claim_is_cut_along_its_middle(square) -> None:
    x = square.vertices[:, 0]
    labels = Partition(square).labels([x < 0.52, x > 0.46])
    assert (labels[x < 0.48] == 0).all()
    assert (labels[x > 0.50] == 1).all()


def test_a_narrow_crack_is_closed_and_a_wide_one_stays(square) -> None:
    x = square.vertices[:, 0]
    narrow = Partition(square).labels([x < 0.495, x > 0.505])
    assert (narrow != GAP).all()
    wide = Partition(square).labels([x < 0.4, x > 0.6])
    assert np.array_equal(wide == GAP, (x >= 0.4) & (x <= 0.6))


def test_a_crack_between_two_pieces_is_closed_along_its_middle(square) -> None:
    x, y = square.vertices[:, :2].T
    partition = Partition(square)
    labels = np.where(x < 0.475, 0, np.where(x > 0.525, 1, GAP))
    closed = partition.without_cracks(labels, 0.06)
    assert (closed[x < 0.495] == 0).all()
    assert (closed[x > 0.505] == 1).all()
    # wider, between other borders, or within one piece it is a gap
    for width, other in ((0.03, labels), (0.06, np.where(labels == 1, 0, labels))):
        assert np.array_equal(partition.without_cracks(other, width), other)
    # beside a wide gap only the crack is closed, and not the corner where it ends
    both = np.where(y < 0.5, labels, GAP)
    closed = partition.without_cracks(both, 0.06)
    assert (closed[y >= 0.5] == GAP).all()
    assert (closed[y < 0.44] != GAP).all()


def test_where_two_pieces_meet_at_a_gap_it_keeps_its_border(square) -> None:
    x, y = square.vertices[:, :2].T
    labels = np.where(y > 0.5, GAP, np.where(x < 0.5, 0, 1))
    partition = Partition(square)
    assert np.array_equal(partition.without_cracks(labels, 0.06), labels)


def test_a_ragged_border_becomes_short(square) -> None:
    """Two rows of single vertices that stand out are given back."""
    x, y = square.vertices[:, :2].T
    teeth = (np.round(y * SIDE) % 2 == 0) & (np.abs(x - 0.51) < 0.004)
    ragged = (x < 0.505) | teeth
    partition = Partition(square)
    labels = partition.labels([ragged, ~ragged])
    length = partition.touching(labels)[0, 1]
    before = partition.touching(np.where(ragged, 0, 1))[0, 1]
    assert length < before
    assert abs(length - 1.0) < 0.05


def test_gaps_are_listed_by_area_with_a_vertex_inside(square) -> None:
    x = square.vertices[:, 0]
    partition = Partition(square)
    labels = np.where((x < 0.1) | (x > 0.8), GAP, 0)
    gaps = partition.gaps(labels)
    assert len(gaps) == 2
    assert square.vertex_areas[gaps[0]].sum() > square.vertex_areas[gaps[1]].sum()
    assert labels[partition.deepest(gaps[0])] == GAP
    assert x[partition.deepest(gaps[0])] == 1.0  # farthest from the only border


def test_no_pieces_leave_all_to_the_gap_and_one_that_covers_all_leaves_none(square) -> None:
    partition = Partition(square)
    assert (partition.labels([]) == GAP).all()
    assert (partition.labels([np.ones(square.vertex_count, dtype=bool)]) == 0).all()


def test_depth_has_a_sign_and_an_end(square) -> None:
    partition = Partition(square)
    x = square.vertices[:, 0]
    depth = border_depth(partition._paths, x < 0.5, DELTA)
    assert (depth[x < 0.5] > 0).all()
    assert (depth[x >= 0.5] < 0).all()
    assert np.abs(depth).max() <= DELTA + 1e-12


def test_seams_around_a_vertex_are_the_border_of_its_cell(square) -> None:
    """On right triangles the dual of an edge is as long as the edge, that of a diagonal nothing."""
    seams = seam_lengths(square)
    lengths = np.linalg.norm(np.diff(square.vertices[square.edges], axis=1)[:, 0], axis=1)
    diagonal = lengths > 1.2 * lengths.min()
    assert np.abs(seams[diagonal]).max() < 1e-12
    inside = ~diagonal & ((square.vertices[square.edges] % 1.0) > 0)[:, :, :2].all(axis=(1, 2))
    assert np.abs(seams[inside] - lengths[inside]).max() < 1e-12


def test_what_is_left_where_cracks_meet_is_closed_and_a_missing_piece_stays(square) -> None:
    x, y = square.vertices[:, :2].T
    partition = Partition(square)
    # three cracks that would be closed each by itself leave room for a wider disk where they meet
    cracks = (np.abs(x - 0.5) < 0.026) & (y > 0.5) | (np.abs(y - 0.5) < 0.026)
    junction = cracks | (np.hypot(x - 0.5, y - 0.5) < 0.045)
    pieces = np.where(y < 0.5, 0, np.where(x < 0.5, 1, 2))
    closed = partition.without_cracks(np.where(junction, GAP, pieces), 0.06)
    assert (closed != GAP).all()
    # a fiftieth of the area
    missing = np.hypot(x - 0.5, y - 0.5) < 0.08
    kept = partition.without_cracks(np.where(missing, GAP, pieces), 0.06)
    assert float(square.vertex_areas @ (missing & (kept == GAP))) > 0.015


def test_a_gap_where_no_piece_ends_is_none(square) -> None:
    """The tip of a toe that the image of a piece does not reach, beside a place that is missing."""
    x, y = square.vertices[:, :2].T
    partition = Partition(square)
    missing = x > 0.8
    lapse = np.hypot(x - 0.2, y - 0.2) < 0.1
    labels = np.where(missing | lapse, GAP, np.where(x < 0.5, 0, 1))
    along = np.linspace(0, 1, 300)
    ends = np.concatenate(
        [np.stack([np.full(300, at), along, np.zeros(300)], axis=1) for at in (0.5, 0.8)]
    )
    filled = partition.without_lapses(labels, ends)
    assert np.array_equal(filled, np.where(missing, GAP, np.where(x < 0.5, 0, 1)))
    # the same hole is one if the piece has it
    around = np.linspace(0, 2 * np.pi, 300)
    rim = np.stack([0.2 + 0.1 * np.cos(around), 0.2 + 0.1 * np.sin(around), 0 * around], axis=1)
    assert np.array_equal(partition.without_lapses(labels, np.concatenate([ends, rim])), labels)
    # nothing says where pieces end, or nothing is missing
    none = np.empty((0, 3))
    assert np.array_equal(partition.without_lapses(labels, none), labels)
    whole = np.zeros(len(x), dtype=np.int64)
    assert np.array_equal(partition.without_lapses(whole, ends), whole)
