"""Strips between loops, and scans that are completed."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from sherd.fitting.fit import fit
from sherd.mesh.border_loops import (
    border_loops,
    filled_loop,
    is_watertight,
    strip_between,
    without_pinched_borders,
)
from sherd.mesh.geometry import face_cross
from sherd.mesh.triangle_mesh import TriangleMesh


@pytest.fixture(scope="module")
def band():
    """A sphere without a band around it, of which the lower part is turned and meshed coarser."""
    fine = trimesh.creation.icosphere(subdivisions=3)
    coarse = trimesh.creation.icosphere(subdivisions=2)
    turned = coarse.vertices @ trimesh.transformations.rotation_matrix(0.3, [0, 0, 1])[:3, :3].T
    upper = fine.faces[(fine.vertices[fine.faces][:, :, 2] > 0.15).all(axis=1)]
    lower = coarse.faces[(turned[coarse.faces][:, :, 2] < -0.1).all(axis=1)]
    return (
        np.concatenate([fine.vertices, turned]),
        without_pinched_borders(upper),
        without_pinched_borders(lower + len(fine.vertices)),
    )


def test_a_strip_closes_the_gap_and_looks_outward(band) -> None:
    vertices, upper, lower = band
    (first,), (second,) = border_loops(upper), border_loops(lower)
    strip = strip_between(vertices, first, second)
    assert len(strip) == len(first) + len(second)
    assert is_watertight(np.concatenate([upper, lower, strip]))
    outward = (face_cross(vertices, strip) * vertices[strip].mean(axis=1)).sum(axis=1)
    assert (outward > 0).mean() > 0.95
    assert not is_watertight(np.concatenate([upper, lower]))
    assert not is_watertight(np.concatenate([upper, lower, strip[:, ::-1]]))


def test_a_small_hole_is_closed(band) -> None:
    sphere = trimesh.creation.icosphere(subdivisions=2)
    holed = sphere.faces[~(sphere.faces == 20).any(axis=1)]
    (loop,) = border_loops(holed)
    assert is_watertight(np.concatenate([holed, filled_loop(loop)]))


def test_pinched_borders_are_opened() -> None:
    """Two triangles that touch in one corner."""
    faces = np.array([[0, 1, 2], [2, 3, 4]])
    assert len(without_pinched_borders(faces)) == 0
    assert len(without_pinched_borders(faces[:1])) == 1


def test_half_a_scan_is_completed_and_closed(match_result_of, exhibit_of_size) -> None:
    match = match_result_of(exhibit_of_size(4))
    fitted = fit(match, merge=True)
    done = fitted.completion
    assert done is not None
    assert done.stitched
    assert done.watertight
    assert done.reason == ""
    scan = done.mesh.vertices[done.origin == 0]
    assert 0.8 * match.part.vertex_count < len(scan) <= match.part.vertex_count
    own = {tuple(row) for row in match.part.vertices.tolist()}
    assert {tuple(row) for row in scan.tolist()} <= own
    assert done.mesh.area == pytest.approx(match.full.area, rel=0.02)


def test_where_no_strip_is_right_it_says_so(match_result_of, exhibit_of_size) -> None:
    """An open full shape: what is missing reaches its border in the middle of the scan's."""
    exhibit = exhibit_of_size(3)
    match = match_result_of(exhibit)
    both = fit([match, match], merge=True).completion
    assert both is not None
    assert not both.stitched
    assert both.watertight
    assert "several pieces" in both.reason
    assert np.array_equal(both.mesh.faces, match.full.faces)
    moved = TriangleMesh(both.mesh.vertices, both.mesh.faces)
    assert moved.area == pytest.approx(match.full.area, rel=0.05)
