"""What two unions share, as maps between the pieces that they are made of."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sherd.arrays import Bools, Floats, Ints
from sherd.correspondence.registration import surface_points
from sherd.correspondence.shared.judgment import shared_confidence
from sherd.correspondence.shared.region_cut import mutual_components
from sherd.correspondence.shared.two_way_placement import CLOSED
from sherd.mesh.surface_points import closest_points
from sherd.mesh.topology import renumbered
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.overlap import HALF
from sherd.puzzle.growing.union import Join, Union
from sherd.puzzle.synchronization import TORN, PieceMap, cycle_error

__all__ = ["direct_maps", "open_loop"]


def direct_maps(
    pieces: Sequence[TriangleMesh], joins: Sequence[Join]
) -> dict[tuple[int, int], PieceMap]:
    """By (here, there), where each piece lies on each that a join laid it on.

    Two pieces are on different sides of one join at most. Where one of them gave way to a third
    piece in the union it has no map here; the way over the third one leads there.
    """
    found: dict[tuple[int, int], PieceMap] = {}
    for join in joins:
        sides = ((join.second, join.first), (join.first, join.second))
        for side, (part, full) in enumerate(sides):
            image = _image(join, side, full)
            for here in part.members:
                found.update(_maps_of(pieces, here, part, full, image))
    return found


def open_loop(joins: Sequence[Join]) -> float:
    """How far off one comes back around three unions, each of which was joined to both others.

    Mean over the vertices of all pieces that come back, in sqrt(area) of the largest union;
    infinite if none does.
    """
    unions = {id(union): union for join in joins for union in (join.first, join.second)}
    largest = max(unions.values(), key=lambda union: union.mesh.area)
    pieces = {
        member: _piece_of(union, member) for union in unions.values() for member in union.members
    }
    meshes = [pieces.get(k, largest.mesh) for k in range(max(pieces) + 1)]
    error = cycle_error(meshes, direct_maps(meshes, joins), largest.mesh.length)
    return float("inf") if np.isnan(error) else error


def _piece_of(union: Union, piece: int) -> TriangleMesh:
    """What a union has of a piece, as it lies on the piece itself."""
    faces = union.faces_of(piece)
    if not len(faces):
        return union.mesh  # no map leads there
    used, renamed = renumbered(faces)
    return TriangleMesh(union.places[used], renamed)


def _image(join: Join, side: int, full: Union) -> tuple[Ints, Floats, Floats]:
    """Of each vertex of a union the piece (n,) it lies on, its place (n, 3) there, and the trust.

    The piece is -1 where nothing is shared, or there and back do not meet.
    """
    question, place = join.met.questions[side], join.met.placements[side]
    other = join.met.placements[1 - side]
    at_own = question.part.working.at_own_vertices
    points = surface_points(question, question.full.own_finder, place.deformation)
    trust = at_own(shared_confidence(question.part.mesh, join.met.queries[side], place))
    # a limb that goes on beyond the other union may touch that elsewhere, where nothing of it lies
    mutual = place.trip.points.interpolate(question.full.mesh, other.shared.astype(np.float64))
    shared = mutual_components(question.part.mesh, place.shared, mutual)
    # along a cut the region takes in what does not come back, whose point is anywhere near
    meets = shared & (place.trip.gap <= CLOSED)
    known = at_own(meets.astype(np.float64)) >= HALF
    corners = full.mesh.faces[points.faces]
    owners = full.owner[corners]
    alike = (owners == owners[:, :1]).all(axis=1)
    places = np.einsum("pk,pkx->px", points.barycentric, full.places[corners])
    return np.where(known & alike, owners[:, 0], -1), places, trust


def _maps_of(
    pieces: Sequence[TriangleMesh],
    here: int,
    part: Union,
    full: Union,
    image: tuple[Ints, Floats, Floats],
) -> dict[tuple[int, int], PieceMap]:
    owners, places, trust = image
    own = part.faces_of(here)
    if not len(own):
        return {}
    # the union's faces of this piece, as they lie on the piece itself
    chart = TriangleMesh(part.places, own)
    at = closest_points(chart, pieces[here].vertices)
    near = np.linalg.norm(at.positions(chart) - pieces[here].vertices, axis=1)
    covered = near < pieces[here].mean_edge_length
    corners = own[at.faces]
    found = {}
    for there in full.members:
        known: Bools = covered & (owners[corners] == there).all(axis=1)
        spread = np.ptp(places[corners], axis=1).max(axis=1)
        known &= spread < TORN * part.mesh.mean_edge_length
        if not known.any():
            continue
        on = np.einsum("pk,pkx->px", at.barycentric, places[corners])
        points = closest_points(
            pieces[there], np.where(known[:, None], on, pieces[there].vertices[0])
        )
        sure = np.where(known, at.interpolate(chart, trust), 0.0)
        found[here, there] = PieceMap(points, known, sure)
    return found
