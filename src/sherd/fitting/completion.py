"""The scan completed: its own faces, the fitted surface where it has none, and a strip between.

The border of the scan and that of the rest of the fit run beside each other, about an edge apart.
Where each loop of one has its loop of the other, a strip of triangles closes the gap. Where not, as
on scans that are full of holes and islands, no strip would be right, and the answer is the fitted
surface moved onto the scan, which is as closed as the full shape is; it says so.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from sherd.arrays import Bools, Floats, Ints
from sherd.mesh.border_loops import (
    border_loops,
    filled_loop,
    is_watertight,
    strip_between,
    without_pinched_borders,
)
from sherd.mesh.surface_points import closest_points
from sherd.mesh.topology import component_labels, renumbered
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.fitted.completion import FITTED, Completion
from sherd.results.fitted.fit_result import FittedPiece

__all__ = ["completed"]

# In edges of the fit: a loop of the scan is beside one of the fit if half of it is as near.
BESIDE = 4.0
# Holes of the scan with so short a border are closed at once: the fit has no vertex inside.
SMALL_HOLE = 40
# Of the reach of what is matched: what is not must lie so near to the fit to be no clutter.
ON_FIT = 0.2
# An island of the scan with fewer faces is left out, as noise; a strip around it needs them.
SMALL_ISLAND = 20


def completed(
    fit: TriangleMesh, seen: Bools, pieces: Sequence[FittedPiece], *, reach: float
) -> Completion:
    """One mesh of the pieces and of what they lack.

    Parameters
    ----------
    fit
        The fitted full shape, repaired so that it has no seams.
    seen
        (n,) bool, its vertices that lie on the pieces.
    pieces
        With the distance of each vertex from the fit.
    reach
        Matched vertices farther from the fit than this, in its unit, are left out, and others
        farther than a fifth of it.
    """
    if len(pieces) > 1:
        return _moved(fit, seen, pieces, "there are several pieces, which overlap or leave cracks")
    scan, names = _kept_scan(pieces[0], reach)
    if not len(scan):
        return _moved(fit, seen, pieces, "no face of the piece is near the fit")
    rest = _rest_of(fit, seen, pieces[0].part.vertices[np.unique(scan)])
    if not len(rest):
        return _finished(pieces[0].part.vertices, scan, np.zeros(len(names), dtype=np.int64), fit)
    vertices = np.concatenate([pieces[0].part.vertices, fit.vertices])
    rest = rest + len(names)
    between, reason = _joints(vertices, scan, rest, fit)
    if reason:
        return _moved(fit, seen, pieces, reason)
    faces = np.concatenate([scan, rest, *between])
    origin = np.repeat([0, FITTED], [len(names), fit.vertex_count])
    return _finished(vertices, faces, origin, fit)


def _kept_scan(piece: FittedPiece, reach: float) -> tuple[Ints, Bools]:
    # what lies on the fit belongs to it, whatever the map thinks of it
    good = piece.distances < np.where(piece.matched, reach, ON_FIT * reach)
    faces = without_pinched_borders(piece.part.faces[good[piece.part.faces].all(axis=1)])
    if len(faces):
        label = component_labels(faces, piece.part.vertex_count)[faces[:, 0]]
        faces = faces[np.bincount(label)[label] >= SMALL_ISLAND]
    return faces, good


def _rest_of(fit: TriangleMesh, seen: Bools, scan: Floats) -> Ints:
    """The faces of the fit that the scan does not have, a step away from it."""
    near = cKDTree(scan).query(fit.vertices, distance_upper_bound=0.5 * fit.mean_edge_length)[0]
    covered = seen | np.isfinite(near)
    faces = without_pinched_borders(fit.faces[~covered[fit.faces].any(axis=1)])
    if len(faces):
        label = component_labels(faces, fit.vertex_count)[faces[:, 0]]
        faces = faces[np.bincount(label)[label] >= SMALL_ISLAND]
    return faces


def _joints(vertices: Floats, scan: Ints, rest: Ints, fit: TriangleMesh) -> tuple[list[Ints], str]:
    """Strips between the loops of both, or why there are none."""
    own = fit.vertices[fit.boundary_vertices]  # where the full shape ends, nothing is missing
    loops = [loop for loop in border_loops(rest) if not _runs_along(vertices[loop], own, 1e-9)]
    left = border_loops(scan)
    between = []
    for loop in loops:
        beside = [
            k
            for k, other in enumerate(left)
            if _runs_along(vertices[loop], vertices[other], BESIDE * fit.mean_edge_length)
        ]
        if not beside:
            return [], "a border of what is missing has no border of the scan beside it"
        best = min(beside, key=lambda k: _median_gap(vertices[left[k]], vertices[loop]))
        between.append(strip_between(vertices, left.pop(best), loop))
    for loop in left:
        if len(own) and _runs_along(vertices[loop], own, BESIDE * fit.mean_edge_length):
            continue
        if len(loop) > SMALL_HOLE:
            return [], "the scan has a border that nothing missing lies beside"
        between.append(filled_loop(loop))
    return between, ""


def _median_gap(points: Floats, others: Floats) -> float:
    return float(np.median(cKDTree(others).query(points)[0]))


def _runs_along(points: Floats, others: Floats, reach: float) -> bool:
    """Whether at least half of the points are within reach of the others."""
    return len(others) > 0 and _median_gap(points, others) <= reach


def _finished(vertices: Floats, faces: Ints, origin: Ints, fit: TriangleMesh) -> Completion:
    used, faces = renumbered(faces)
    closed = is_watertight(faces)
    open_full = len(fit.boundary_vertices) > 0
    reason = "" if closed else "the full shape is open" if open_full else "a gap is left"
    mesh = TriangleMesh(vertices[used], faces, name="completed")
    return Completion(mesh, origin[used], closed, stitched=True, reason=reason)


def _moved(
    fit: TriangleMesh, seen: Bools, pieces: Sequence[FittedPiece], reason: str
) -> Completion:
    """The fit, what was seen moved to the nearest point of the pieces."""
    vertices = fit.vertices.copy()
    origin = np.full(len(vertices), FITTED)
    nearest = np.full(len(vertices), np.inf)
    for number, piece in enumerate(pieces):
        matched = piece.matched[piece.part.faces].all(axis=1)
        surface = TriangleMesh(piece.part.vertices, piece.part.faces[matched])
        feet = closest_points(surface, fit.vertices).positions(surface)
        off = np.linalg.norm(feet - fit.vertices, axis=1)
        better = seen & (off < nearest)
        vertices[better], origin[better], nearest[better] = feet[better], number, off[better]
    mesh = TriangleMesh(vertices, fit.faces, name="completed")
    return Completion(mesh, origin, is_watertight(fit.faces), stitched=False, reason=reason)
