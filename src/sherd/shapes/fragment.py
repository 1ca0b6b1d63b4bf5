"""Fragments of a shape that know, point by point, where they belong.

A fragment starts as a whole posed shape and goes through tools; each returns a new fragment and
carries the ground truth along::

    broken = cut_by_ball(whole(creature(pose="walk"), creature()), center, radius=0.4)
    part = moved(remeshed(broken, 1.3), rng)

Lengths given to the tools are relative to sqrt(area of the full shape).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from sherd.arrays import Bools, Floats, Ints, frozen
from sherd.errors import InfeasibleError, InputError, OptionError
from sherd.mesh.surface_points import SurfacePoints, closest_points, points_at_vertices
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes.ball import unit_ball
from sherd.shapes.clip import clip, largest_component
from sherd.shapes.rotation import rotated
from sherd.shapes.truth import carried, true_region
from sherd.spectral.geodesics import Geodesics
from sherd.spectral.sampling import decimate, remesh
from sherd.spectral.subdivision import split_edges

__all__ = [
    "Fragment",
    "cut_by_ball",
    "cut_by_level",
    "cut_by_plane",
    "cut_in_pieces",
    "decimated",
    "largest_piece",
    "moved",
    "noisy",
    "punch_holes",
    "remeshed",
    "reordered",
    "scaled",
    "unevenly_sampled",
    "whole",
    "with_clutter",
    "with_flipped_faces",
]


# Height of the bumps on clutter, so that it is no sphere and no mirror image of itself.
BUMPS = 0.25


@dataclass(frozen=True, eq=False)
class Fragment:
    """A part with exact ground truth.

    Attributes
    ----------
    mesh
        The part.
    truth
        (n_part,) where each vertex of the part lies on `full`; meaningless where not `present`.
    full
        The full shape, in its own pose.
    present
        (n_part,) bool, False where the full shape has no such point (clutter).

    Raises
    ------
    InputError
        If `truth` or `present` does not have one row per vertex.
    """

    mesh: TriangleMesh
    truth: SurfacePoints
    full: TriangleMesh
    present: Bools

    def __post_init__(self) -> None:
        present = np.array(self.present, dtype=bool)
        if len(self.truth) != self.mesh.vertex_count or present.shape != (self.mesh.vertex_count,):
            raise InputError(
                f"truth has {len(self.truth)} rows and present shape {present.shape}, "
                f"but the part has {self.mesh.vertex_count} vertices"
            )
        object.__setattr__(self, "present", frozen(present))

    @property
    def region(self) -> Bools:
        """The vertices of the full shape that the part covers, (n_full,): `true_region`."""
        return true_region(self.full, self.mesh, self.truth, present=self.present)


def whole(posed: TriangleMesh, full: TriangleMesh) -> Fragment:
    """All of the full shape in another pose, as the fragment to cut from.

    Raises
    ------
    InputError
        If the two do not have the same faces, or a vertex belongs to no face.
    """
    if posed.vertex_count != full.vertex_count or not np.array_equal(posed.faces, full.faces):
        raise InputError(f"{posed.name} and {full.name} must have the same vertices and faces")
    count = full.vertex_count
    return Fragment(
        posed, points_at_vertices(full, np.arange(count)), full, np.ones(count, dtype=bool)
    )


def cut_by_plane(fragment: Fragment, point: ArrayLike, normal: ArrayLike) -> Fragment:
    """What lies on the side of a plane that `normal` (3,) points to; `point` (3,) l is on it.

    Both in the coordinates of the fragment. The cut is straight, except that it goes through a
    vertex that it would pass within 2 % of an edge.

    Raises
    ------
    InfeasibleError
        If nothing lies on that side.
    OptionError
        If the normal is zero.
    """
    direction = np.asarray(normal, dtype=np.float64)
    if not np.linalg.norm(direction) > 0:
        raise OptionError(f"normal is {direction}, but a direction is needed")
    height = ((fragment.mesh.vertices - np.asarray(point, dtype=np.float64)) * direction).sum(
        axis=1
    )
    return _taken(fragment, *clip(fragment.mesh, height))


def cut_by_ball(fragment: Fragment, center: int, radius: float) -> Fragment:
    """What lies within a geodesic distance of vertex `center` of the fragment.

    Raises
    ------
    OptionError
        If `radius` is not positive.
    """
    return _taken(fragment, *clip(fragment.mesh, _inside_ball(fragment, center, radius)))


def punch_holes(
    fragment: Fragment, count: int, *, radius: float, rng: np.random.Generator
) -> Fragment:
    """The fragment without `count` geodesic balls around random vertices.

    Holes may overlap each other and the border. Of what is left, the largest piece is kept.

    Raises
    ------
    InfeasibleError
        If nothing is left.
    """
    for _ in range(count):
        # weighted by area, so that dense regions attract no more holes
        areas = fragment.mesh.vertex_areas
        center = int(rng.choice(len(areas), p=areas / areas.sum()))
        fragment = _taken(fragment, *clip(fragment.mesh, -_inside_ball(fragment, center, radius)))
    return largest_piece(fragment)


def cut_by_level(fragment: Fragment, values: ArrayLike) -> Fragment:
    """Where `values`, one for each vertex and linear on each face, are positive.

    Raises
    ------
    InputError
        If there is not one value for each vertex.
    InfeasibleError
        If nothing is positive.
    """
    level = np.asarray(values, dtype=np.float64)
    if level.shape != (fragment.mesh.vertex_count,):
        raise InputError(
            f"values have shape {level.shape}, but {fragment.mesh.name} has "
            f"{fragment.mesh.vertex_count} vertices"
        )
    return _taken(fragment, *clip(fragment.mesh, level))


def cut_in_pieces(fragment: Fragment, count: int, *, width: float) -> Fragment:
    """The fragment without bands of the given width across its longest axis, in `count` pieces.

    Bands lie so that the slices between them have equally many vertices; a slice may fall into
    several components, as two legs do.

    Raises
    ------
    InfeasibleError
        If nothing is left.
    OptionError
        If `count` is not positive.
    """
    if count < 1:
        raise OptionError(f"count is {count}, but at least 1 piece is needed")
    axis = _longest_axis(fragment.mesh)
    places = np.quantile(fragment.mesh.vertices @ axis, np.arange(1, count) / count)
    for place in places:
        height = fragment.mesh.vertices @ axis - place
        band = 0.5 * width * fragment.full.length
        fragment = _taken(fragment, *clip(fragment.mesh, np.abs(height) - band))
    return fragment


def largest_piece(fragment: Fragment) -> Fragment:
    """The connected piece with the largest area."""
    mesh, kept = largest_component(fragment.mesh)
    return replace(fragment, mesh=mesh, truth=fragment.truth[kept], present=fragment.present[kept])


def remeshed(fragment: Fragment, factor: float) -> Fragment:
    """New triangles, edges `factor` times as long as the mean now; the truth is carried over.

    New vertices lie on the old faces, so the truth stays exact the first time. Remeshing what was
    remeshed before moves them off the full shape by about the square of the edge length times
    the curvature; the truth is then the closest point of the full shape in its own pose.
    """
    return _taken(fragment, *remesh(fragment.mesh, factor * fragment.mesh.mean_edge_length))


def decimated(fragment: Fragment, vertex_count: int) -> Fragment:
    """Fewer vertices; see :func:`sherd.spectral.sampling.decimate` for what is met and kept."""
    return _taken(fragment, *decimate(fragment.mesh, vertex_count))


def unevenly_sampled(fragment: Fragment, ratio: float) -> Fragment:
    """The same surface with `ratio` times as many vertices per area at one end as at the other.

    Edges are halved where they are too long; the sparse end of the longest axis stays as it is.

    Raises
    ------
    OptionError
        If `ratio` is below 1.
    """
    if not 1 <= ratio < np.inf:
        raise OptionError(f"ratio is {ratio}, but a number from 1 on is needed")
    mesh, axis = fragment.mesh, _longest_axis(fragment.mesh)
    vertices, faces = mesh.vertices, mesh.faces
    low, high = np.quantile(vertices @ axis, [0.0, 1.0])
    while True:
        sides = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        middle = vertices[sides].mean(axis=1)
        share = (middle @ axis - low) / (high - low)
        wanted = mesh.mean_edge_length * ratio ** (-0.5 * share)
        # halving at 4/3 of a length leaves edges between 2/3 and 4/3 of it
        lengths = np.linalg.norm(vertices[sides[:, 0]] - vertices[sides[:, 1]], axis=1)
        long = (lengths > 4 / 3 * wanted) & (wanted < 0.99 * mesh.mean_edge_length)
        if not long.any():
            break
        faces, parents = split_edges(faces, len(vertices), long)
        vertices = np.concatenate([vertices, vertices[parents].mean(axis=1)])
    split = TriangleMesh(vertices, faces, name=mesh.name)
    return _taken(fragment, split, closest_points(mesh, vertices))


def noisy(fragment: Fragment, sigma: float, *, rng: np.random.Generator) -> Fragment:
    """Every vertex moved by Gaussian noise of deviation `sigma` along each axis."""
    shift = rng.normal(size=fragment.mesh.vertices.shape) * sigma * fragment.full.length
    return _with_vertices(fragment, fragment.mesh.vertices + shift)


def moved(fragment: Fragment, rng: np.random.Generator) -> Fragment:
    """A random rotation, uniform over all, and a random translation of about one length."""
    turned = rotated(fragment.mesh, rng)
    shift = rng.normal(size=3) * fragment.full.length
    return _with_vertices(fragment, turned.vertices + shift)


def scaled(fragment: Fragment, factor: float) -> Fragment:
    """All coordinates times `factor`, which must be positive.

    Raises
    ------
    OptionError
        If it is not.
    """
    if not 0 < factor < np.inf:
        raise OptionError(f"factor is {factor}, but a positive number is needed")
    return _with_vertices(fragment, fragment.mesh.vertices * factor)


def reordered(fragment: Fragment, rng: np.random.Generator) -> Fragment:
    """Vertices, faces and the first corner of each face in random order."""
    mesh = fragment.mesh
    order = rng.permutation(mesh.vertex_count)
    renumber = np.argsort(order)
    faces = renumber[mesh.faces][rng.permutation(mesh.face_count)]
    turn = (rng.integers(3, size=(len(faces), 1)) + np.arange(3)) % 3
    fields = {key: values[order] for key, values in mesh.fields.items()}
    shuffled = TriangleMesh(
        mesh.vertices[order], np.take_along_axis(faces, turn, axis=1), fields=fields, name=mesh.name
    )
    return Fragment(shuffled, fragment.truth[order], fragment.full, fragment.present[order])


def with_flipped_faces(fragment: Fragment, share: float, *, rng: np.random.Generator) -> Fragment:
    """A random share (0 to 1) of the faces turned inside out."""
    mesh = fragment.mesh
    turned = rng.random(mesh.face_count) < share
    faces = np.where(turned[:, None], mesh.faces[:, ::-1], mesh.faces)
    return replace(
        fragment, mesh=TriangleMesh(mesh.vertices, faces, fields=mesh.fields, name=mesh.name)
    )


def with_clutter(fragment: Fragment, share: float, *, rng: np.random.Generator) -> Fragment:
    """A bumpy ball beside the part, with `share` of its area, that belongs nowhere.

    Its vertices come last and are not `present`; its fields are NaN.

    Raises
    ------
    OptionError
        If `share` is not positive.
    """
    if not 0 < share < np.inf:
        raise OptionError(f"share is {share}, but a positive share of the part's area is needed")
    mesh = fragment.mesh
    vertices, faces = _bumpy_ball(share * mesh.area, mesh.area / mesh.vertex_count, rng)
    reach = np.linalg.norm(vertices, axis=1).max()
    place = int(rng.integers(mesh.vertex_count))
    vertices = vertices + mesh.vertices[place] + 1.2 * reach * mesh.vertex_normals[place]
    count = len(vertices)
    fields = {
        key: np.concatenate([values, np.full((count, *values.shape[1:]), np.nan)])
        for key, values in mesh.fields.items()
    }
    cluttered = TriangleMesh(
        np.concatenate([mesh.vertices, vertices]),
        np.concatenate([mesh.faces, faces + mesh.vertex_count]),
        fields=fields,
        name=mesh.name,
    )
    nowhere = np.tile([1.0, 0.0, 0.0], (count, 1))
    truth = SurfacePoints(
        np.concatenate([fragment.truth.faces, np.zeros(count, dtype=np.int64)]),
        np.concatenate([fragment.truth.barycentric, nowhere]),
    )
    present = np.concatenate([fragment.present, np.zeros(count, dtype=bool)])
    return Fragment(cluttered, truth, fragment.full, present)


def _taken(fragment: Fragment, mesh: TriangleMesh, points: SurfacePoints) -> Fragment:
    """The fragment on a new mesh whose vertices are `points` of the old one."""
    corners = fragment.mesh.faces[points.faces]
    used = points.barycentric > 0
    present: Bools = np.all(fragment.present[corners] | ~used, axis=1)
    truth = carried(fragment.full, fragment.truth, corners, points.barycentric)
    return Fragment(mesh, truth, fragment.full, present)


def _with_vertices(fragment: Fragment, vertices: Floats) -> Fragment:
    return replace(fragment, mesh=fragment.mesh.with_vertices(vertices))


def _longest_axis(mesh: TriangleMesh) -> Floats:
    """Direction (3,) in which the vertices are spread widest; its largest entry is positive."""
    centered = mesh.vertices - mesh.vertices.mean(axis=0)
    axis = np.linalg.eigh(centered.T @ centered)[1][:, -1]
    signed: Floats = axis * np.sign(axis[np.abs(axis).argmax()])
    return signed


def _inside_ball(fragment: Fragment, center: int, radius: float) -> Floats:
    """Radius less geodesic distance from the center, (n,) l; negative where not connected."""
    if not 0 < radius < np.inf:
        raise OptionError(f"radius is {radius}, but a positive length is needed")
    reach = radius * fragment.full.length
    distance = Geodesics(fragment.mesh).distances_from(center)[0]
    inside = reach - np.where(np.isfinite(distance), distance, 2 * reach)
    if not (inside > 0).any():
        raise InfeasibleError(f"no vertex lies within {radius} of vertex {center}")
    return inside


def _bumpy_ball(area: float, vertex_area: float, rng: np.random.Generator) -> tuple[Floats, Ints]:
    """A closed surface of about the given area, its vertices about as dense as wanted."""
    vertices, faces = unit_ball(math.ceil(0.5 * area / vertex_area))
    waves, phases = rng.normal(size=(3, 3)) * 2.0, rng.uniform(0, 2 * np.pi, size=3)
    bumps = 1 + BUMPS * np.cos(vertices @ waves.T + phases).mean(axis=1)
    return np.sqrt(area / (4 * np.pi)) * bumps[:, None] * vertices, faces
