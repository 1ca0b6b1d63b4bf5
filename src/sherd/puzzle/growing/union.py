"""Pieces that were found to overlap, as one surface: the first as it is, and what others add.

The second piece was laid on the first as an elastic surface; where the first has nothing it floats
on, carried by its elasticity. Its faces there are added, and triangles close the seam. So the union
has the pose of the first piece, and shares more with a third piece than either.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from sherd.arrays import Bools, Floats, Ints
from sherd.correspondence.elastic_kernel import fit_rotations
from sherd.correspondence.question import Question
from sherd.correspondence.registration import Deformation, registered_to_positions
from sherd.correspondence.shared.round_trip import on_border
from sherd.errors import InvalidMeshError
from sherd.mesh.geometry import closest_rotation, edge_lengths, face_normals, vertex_normals
from sherd.mesh.point_cloud import PointCloud
from sherd.mesh.surface_points import SurfacePoints, closest_points
from sherd.mesh.topology import component_labels, renumbered
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.puzzle.growing.cracks import closed_cracks
from sherd.puzzle.pairwise.answer import Meeting
from sherd.scan.intake import scan_intake
from sherd.scan.surface_from_points import surface_from_points
from sherd.surface.described import DescribedSurface

__all__ = [
    "LAYER",
    "Join",
    "Union",
    "floating",
    "larger_first",
    "largest_first",
    "main_group_first",
    "named_at",
    "origins",
    "repaired",
    "united",
]

# In edges of the first piece. What lies over its inside, and no farther off, is a second layer of
# the same skin: farther off it is something that only comes near.
LAYER = 2.0
# What closes a crack looks the same way as the skin there, within 60 degrees: a cap of a limb does
# not, however thin the limb is.
ALIKE = 0.5
# A vertex as near to one of the first piece would make slivers in the seam.
CROWDED = 0.5
# What is shared within this of the rest, the width of a limb, says how the rest begins.
BESIDE = 0.1
# Rounds of elasticity until what floats lies still.
FLOAT_ROUNDS = 30


@dataclass(frozen=True, eq=False)
class Union:
    """One piece or several as one surface.

    Attributes
    ----------
    mesh
        In the pose and unit of the first piece; of several in the frame that its working mesh has.
    owner
        (n,) the piece that each vertex is from.
    places
        (n, 3) where on that piece, in the piece's own frame.
    members
        The pieces, the first one first.
    """

    mesh: TriangleMesh
    owner: Ints
    places: Floats
    members: tuple[int, ...]

    @classmethod
    def of_piece(cls, mesh: TriangleMesh, number: int) -> Union:
        """One piece alone."""
        return cls(mesh, np.full(mesh.vertex_count, number), np.asarray(mesh.vertices), (number,))

    def faces_of(self, piece: int) -> Ints:
        """The faces (f, 3) all corners of which are from one piece."""
        faces: Ints = self.mesh.faces[(self.owner[self.mesh.faces] == piece).all(axis=1)]
        return faces


@dataclass(frozen=True, eq=False)
class Join:
    """Two unions that are joined, and what was found of them; `first` gives the pose."""

    first: Union
    second: Union
    met: Meeting

    @property
    def both(self) -> tuple[Union, Union]:
        """The first and the second."""
        return self.first, self.second

    @property
    def members(self) -> tuple[int, ...]:
        """The pieces of both, those of the first one first."""
        return (*self.first.members, *self.second.members)

    def with_chance(self, chance: float) -> Join:
        """The same answer, as likely as that."""
        return replace(self, met=replace(self.met, chance=chance))


def larger_first(one: Union, other: Union) -> tuple[Union, Union]:
    """Both as they are asked; the first of two alike ones stays the first."""
    return (other, one) if other.mesh.area > one.mesh.area else (one, other)


def largest_first(unions: Sequence[Union]) -> list[Union]:
    """All of them by their area; of alike ones the first stays before."""
    return sorted(unions, key=lambda union: -union.mesh.area)


def main_group_first(unions: Sequence[Union]) -> list[Union]:
    """All of them by their area, but single pieces after those of several.

    A piece of another thing may be larger than a group, and is no group.
    """
    return sorted(unions, key=lambda union: (len(union.members) == 1, -union.mesh.area))


def united(join: Join) -> Union:
    """The union of both."""
    here, there = join.first, join.second
    question, place = join.met.questions[0], join.met.placements[0]
    first, second = question.full.mesh, question.part.mesh
    laid = floating(question, place.deformation.positions, place.shared)
    normals = vertex_normals(laid, second.faces)
    added = _beyond(question.full, laid, normals) & ~place.shared
    points = np.concatenate([first.vertices, laid])
    facing = np.concatenate([first.vertex_normals, normals])
    beside = second.faces[added[second.faces].all(axis=1)] + first.vertex_count
    faces = np.concatenate([first.faces, beside])
    used = np.zeros(len(points), dtype=bool)
    used[first.faces] = True
    used[first.vertex_count :] |= added
    seam = _seam(points, facing, faces, np.flatnonzero(used), first.vertex_count)
    faces = np.concatenate([faces, seam])
    faces = _without_cracks(first, TriangleMesh(laid, second.faces), faces)
    kept, renamed = renumbered(faces)
    rough = TriangleMesh(points[kept] * join.met.unit, renamed, name=here.mesh.name)
    named = (origins(here, question.full), origins(there, question.part))
    owner = np.concatenate([owners for owners, _ in named])[kept]
    places = np.concatenate([places for _, places in named])[kept]
    return repaired(Union(rough, owner, places, join.members))


def repaired(union: Union) -> Union:
    """The same as a surface that can be asked; every vertex keeps its owner and place.

    Where sheets met in one vertex each has a vertex of its own then, of the same owner and place.
    """
    intake = scan_intake(union.mesh)
    rows = intake.report.original_vertices
    return Union(intake.mesh, union.owner[rows], union.places[rows], union.members)


def floating(question: Question, laid: Floats, shared: Bools) -> Floats:
    """Positions (n, 3) of the part: what is shared where it is laid, the rest carried along.

    Each component of the rest begins at the rigid motion of what is shared beside it. Where it was
    before says nothing: a placement moves it in a few rounds, which is too few to unfold it.
    """
    part = question.part
    rest, faces = part.mesh.vertices, part.mesh.faces
    start = laid.copy()
    if shared.all() or not shared.any():
        return start
    labels = component_labels(faces[~shared[faces].any(axis=1)], len(rest))
    held = np.flatnonzero(shared)
    for label in np.unique(labels[~shared]):
        rows = np.flatnonzero(~shared & (labels == label))
        away = np.asarray(cKDTree(rest[rows]).query(rest[held])[0])
        weights = part.mesh.vertex_areas[held] * np.exp(-(away - away.min()) / BESIDE)
        before = np.average(rest[held], axis=0, weights=weights)
        after = np.average(laid[held], axis=0, weights=weights)
        turn = closest_rotation(rest[held], laid[held], weights)
        start[rows] = (rest[rows] - before) @ turn.T + after
    begun = Deformation(start, fit_rotations(part.elastic, start))
    floated = registered_to_positions(
        question, begun, laid, rounds=FLOAT_ROUNDS, present=shared.astype(np.float64)
    )
    return floated.positions


def _beyond(full: DescribedSurface, laid: Floats, normals: Floats) -> Bools:
    """The vertices (n,) of a placed surface that are no second layer of the full shape's skin."""
    mesh = full.mesh
    feet = full.finder.closest(laid, normals)
    off = np.linalg.norm(feet.positions(mesh) - laid, axis=1)
    edge = mesh.mean_edge_length
    beyond: Bools = on_border(mesh, feet) | (off > LAYER * edge)
    return beyond & (full.vertex_tree.query(laid)[0] > CROWDED * edge)


def _seam(points: Floats, facing: Floats, faces: Ints, used: Ints, split: int) -> Ints:
    """Triangles (s, 3) between vertices below `split` and those from there on.

    Of a surface through all points, where both sides still have a border; the smallest first, so
    that what is in nobody's way is taken before what bridges a gap.
    """
    try:
        found = used[surface_from_points(PointCloud(points[used], facing[used])).faces]
    except InvalidMeshError:
        return np.empty((0, 3), dtype=np.int64)
    across = (found < split).any(axis=1) & (found >= split).any(axis=1)
    found = found[across]
    longest = edge_lengths(points, found).max(axis=1)
    found = found[np.argsort(longest, kind="stable")]
    taken = {side for face in faces for side in _sides(face)}
    seam = []
    for face in found:
        for way in (face, face[::-1]):
            sides = _sides(way)
            if taken.isdisjoint(sides):
                taken.update(sides)
                seam.append(way)
                break
    return np.array(seam, dtype=np.int64).reshape(-1, 3)


def _without_cracks(first: TriangleMesh, laid: TriangleMesh, faces: Ints) -> Ints:
    """Faces (m, 3) of both, cracks along the seam closed where the skin of one of them goes on.

    `faces` are of the vertices of both, those of the first before those of the one laid on it.
    """
    points = np.concatenate([first.vertices, laid.vertices])
    reach = LAYER * first.mean_edge_length

    def lies(triangles: Ints) -> Bools:
        centers, normals = points[triangles].mean(axis=1), face_normals(points, triangles)
        found: Bools = np.zeros(len(triangles), dtype=bool)
        for surface in (first, laid):
            feet = closest_points(surface, centers)
            near = np.linalg.norm(feet.positions(surface) - centers, axis=1) < reach
            up = feet.interpolate(surface, surface.vertex_normals)
            found |= near & ((up * normals).sum(axis=1) > ALIKE)
        return found

    goes_on = _inside(first, points, reach) | _inside(laid, points, reach)
    return closed_cracks(points, faces, goes_on, lies)


def _inside(surface: TriangleMesh, points: Floats, reach: float) -> Bools:
    """Whether points (p, 3) lie on a surface and not on its border."""
    feet = closest_points(surface, points)
    off = np.linalg.norm(feet.positions(surface) - points, axis=1)
    inside: Bools = (off < reach) & ~on_border(surface, feet)
    return inside


def _sides(face: Ints) -> list[tuple[int, int]]:
    a, b, c = face.tolist()
    return [(a, b), (b, c), (c, a)]


def origins(union: Union, surface: DescribedSurface) -> tuple[Ints, Floats]:
    """The owner (m,) and place (m, 3) of each vertex of the working mesh of a union."""
    at = closest_points(surface.placed, surface.mesh.vertices)
    return named_at(at, union.mesh, union.owner, union.places)


def named_at(
    at: SurfacePoints, mesh: TriangleMesh, owners: Ints, places: Floats
) -> tuple[Ints, Floats]:
    """The owner (p,) and place (p, 3) at points of a mesh whose vertices have these."""
    corners = mesh.faces[at.faces]
    lead = corners[np.arange(len(corners)), at.barycentric.argmax(axis=1)]
    alike = (owners[corners] == owners[lead][:, None]).all(axis=1)
    between = np.einsum("pk,pkx->px", at.barycentric, places[corners])
    # between pieces there is no place that both have a name for, so the nearest corner's stands
    return owners[lead], np.where(alike[:, None], between, places[lead])
