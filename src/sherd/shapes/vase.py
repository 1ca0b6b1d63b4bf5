"""A generated vase with relief, and the solid sherds that it breaks into."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy.interpolate import PchipInterpolator

from sherd.arrays import Bools, Floats, Ints, frozen
from sherd.limits import require_finite, require_whole
from sherd.mesh.border_loops import border_half_edges
from sherd.mesh.geometry import closest_rotation
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes.ball import unit_ball
from sherd.shapes.clip import clip, largest_component
from sherd.shapes.rotation import rotated
from sherd.spectral.diffusion import diffused
from sherd.spectral.sampling import VERTICES_PER_AREA, farthest_point_sample_euclidean, remesh

__all__ = ["Sherd", "vase", "vase_sherds"]

# Radius and height along the outer wall, from the middle of the foot to the lip; as high as 1.
PROFILE = np.array(
    [[0.0, 0.0], [0.1, 0.0], [0.15, 0.02], [0.27, 0.25], [0.32, 0.5], [0.24, 0.76], [0.16, 0.88],
     [0.2, 1.0]]
)  # fmt: skip
THICKNESS = 0.03
# The surface that whole and sherds are meshed from has edges of 0.004 where the vase is widest, so
# of both hardly a vertex is one of the other, and none is farther off than 0.0001.
FINEST = 50_000
# The angle of the lip of the ball that the vase is made from, at which it is about as far around
# for its length as the vase is.
OPENING = 2 * np.pi / 3
# Waves that the relief is made of, and the deviation of their wave vectors (per height): most of
# them are 0.5 to 1 long.
WAVES, SPREAD = 40, 6.0
# The inside is smoother than what a potter cares for.
INSIDE = 0.3
# How far breaks leave the middle between two cells, in heights, and the wave vectors of that.
WAVY, BREAKING = 0.02, 12.0
# Edges of sherds, in those of the vase.
SPREAD_OF_EDGES = (0.9, 1.1)
SMALLEST, LARGEST = 5_000, 100_000


@dataclass(frozen=True, eq=False)
class Sherd:
    """A solid piece of a vase.

    Attributes
    ----------
    mesh
        Both walls of the piece, a part of the lip perhaps, and faces of fracture.
    transform
        (4, 4) takes it to where it belongs: `transform @ (x, y, z, 1)`.
    on_wall
        (n,) bool, the vertices that lie on a wall of the vase; the others are within a fracture.
    """

    mesh: TriangleMesh
    transform: Floats
    on_wall: Bools

    def __post_init__(self) -> None:
        object.__setattr__(self, "transform", frozen(np.array(self.transform, dtype=float)))
        object.__setattr__(self, "on_wall", frozen(np.array(self.on_wall, dtype=bool)))


def vase(vertex_count: int = 20_000, *, seed: int = 0, relief: float = 0.01) -> TriangleMesh:
    """A vase as high as 1, closed: an outer wall, an inner one, and the lip between them.

    Parameters
    ----------
    vertex_count
        Wanted number of vertices of both walls, 5,000 to 100,000; the lip has 1,000 to 3,000 more.
    seed
        Of the relief; the profile is that of all vases.
    relief
        Standard deviation of the relief of the outer wall, in heights, 0 to 0.03; 0: plain, and
        round.

    Raises
    ------
    OptionError
        If a number is out of range.

    Examples
    --------
    >>> round(float(vase(5000).vertices[:, 2].max()), 1)
    1.0
    """
    edge = _edge(vertex_count, relief)
    outer, inner = _walls(seed, relief)
    meshed, at = remesh(outer, edge)
    return _thick(meshed, at.interpolate(outer, inner), edge, "vase")[0]


def vase_sherds(
    count: int = 7,
    *,
    vertex_count: int = 20_000,
    seed: int = 0,
    relief: float = 0.01,
    noise: float = 0.0,
    worn: float = 0.0,
) -> tuple[Sherd, ...]:
    """The sherds of a broken vase, each meshed for itself, turned and shifted at random.

    Small chips are lost.

    Parameters
    ----------
    count
        Of sherds, 2 to 30.
    vertex_count, seed, relief
        As of :func:`vase`; all sherds together have some more vertices.
    noise
        Standard deviation by which each vertex is moved along each axis, in sqrt(area of the
        vase).
    worn
        Radius that edges are rounded with, and relief is smoothed over, in the same unit.

    Raises
    ------
    OptionError
        If a number is out of range.

    Examples
    --------
    >>> sherds = vase_sherds(4, vertex_count=5000)
    >>> len(sherds)
    4
    """
    require_whole("sherds", count, 2, 30, "more are chips")
    require_finite("noise", noise, 0.0, 0.1, "a sherd is lost in more")
    require_finite("worn", worn, 0.0, 0.1, "a sherd is a pebble then")
    edge = _edge(vertex_count, relief)
    outer, inner = _walls(seed, relief)
    rng = np.random.default_rng([seed, count])
    unit = float(np.sqrt(_area(outer, inner)))
    found = []
    for number, level in enumerate(_cells(outer.vertices, count, rng)):
        # the break runs across faces of this sherd's own mesh, so its edges are as long as others
        meshed, at = remesh(outer, edge * rng.uniform(*SPREAD_OF_EDGES))
        wall, inside = _cell(meshed, at.interpolate(outer, inner), at.interpolate(outer, level))
        solid, on_wall = _thick(wall, inside, edge, f"sherd {number}")
        if worn > 0:
            solid = solid.with_vertices(diffused(solid, solid.vertices, worn * unit))
        rough = rng.normal(size=solid.vertices.shape) * noise * unit
        found.append(_moved(solid.with_vertices(solid.vertices + rough), on_wall, rng))
    return tuple(found)


def _edge(vertex_count: int, relief: float) -> float:
    """The edge length of a vase with so many vertices, half of them on its outer wall."""
    require_whole("vertices", vertex_count, SMALLEST, LARGEST, "it is meshed from no more")
    require_finite("relief", relief, 0.0, 0.03, "more is as deep as the wall is thick")
    outer, _ = _walls(0, relief)
    return float(np.sqrt(VERTICES_PER_AREA * 2.0 * outer.area / vertex_count))


def _area(outer: TriangleMesh, inner: Floats) -> float:
    """Of both walls; the lip has little."""
    return outer.area + outer.with_vertices(inner).area


@lru_cache(maxsize=2)
def _walls(seed: int, relief: float) -> tuple[TriangleMesh, Floats]:
    """The outer wall, open at the lip, and the place (n, 3) on the inner one behind each vertex."""
    plain, normals, faces = _plain_wall()
    rng = np.random.default_rng(seed)
    bumps, inside = (relief * _field(plain, SPREAD, rng) for _ in range(2))
    inner = plain + (INSIDE * inside - THICKNESS)[:, None] * normals
    return TriangleMesh(plain + bumps[:, None] * normals, faces, name="wall"), inner


@lru_cache(maxsize=1)
def _plain_wall() -> tuple[Floats, Floats, Ints]:
    """A wall without relief: vertices (n, 3), normals (n, 3) and faces (m, 3).

    A ball that is cut open at the top; how far a point is from its lowest one, as an angle, is how
    far it is along the profile.
    """
    vertices, faces = unit_ball(FINEST)
    below = np.arccos(np.clip(-vertices[:, 2], -1.0, 1.0))
    bowl, _ = clip(TriangleMesh(vertices, faces), OPENING - below)
    around, up = np.hypot(*bowl.vertices[:, :2].T), bowl.vertices[:, 2]
    steps = np.linalg.norm(np.diff(PROFILE, axis=0), axis=1)
    curve = PchipInterpolator(np.concatenate([[0.0], np.cumsum(steps)]), PROFILE)
    at = np.clip(np.arctan2(around, -up) / OPENING, 0.0, 1.0) * steps.sum()
    slope = curve(at, 1)
    out = np.column_stack([slope[:, 1], -slope[:, 0]])
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    direction = bowl.vertices[:, :2] / np.maximum(around, 1e-12)[:, None]
    return _turned(curve(at), direction), _turned(out, direction), bowl.faces


def _turned(profile: Floats, direction: Floats) -> Floats:
    """Points or vectors (n, 2) of the profile, each turned to a direction (n, 2) about the axis."""
    return np.column_stack([profile[:, :1] * direction, profile[:, 1]])


def _field(points: Floats, spread: float, rng: np.random.Generator) -> Floats:
    """A random smooth function of points (n, 3): a sum of plane waves, of deviation 1."""
    waves, phases = rng.normal(size=(WAVES, 3)) * spread, rng.uniform(0, 2 * np.pi, WAVES)
    values: Floats = np.sqrt(2 / WAVES) * np.cos(points @ waves.T + phases).sum(axis=1)
    return values


def _cells(points: Floats, count: int, rng: np.random.Generator) -> list[Floats]:
    """For each sherd a level (n,) that is positive on it: wavy cells of points far apart."""
    start = int(rng.integers(len(points)))
    centers = points[farthest_point_sample_euclidean(points, count, start=start)]
    away = np.stack(
        [
            np.linalg.norm(points - center, axis=1) + WAVY * _field(points, BREAKING, rng)
            for center in centers
        ]
    )
    return [np.delete(away, k, axis=0).min(axis=0) - away[k] for k in range(count)]


def _cell(outer: TriangleMesh, inner: Floats, level: Floats) -> tuple[TriangleMesh, Floats]:
    """The largest component of the outer wall where a level is positive, and what is behind it."""
    cell, at = clip(outer, level)
    behind = at.interpolate(outer, inner)
    piece, kept = largest_component(cell)
    return piece, behind[kept]


def _thick(wall: TriangleMesh, inner: Floats, edge: float, name: str) -> tuple[TriangleMesh, Bools]:
    """Both walls and what closes them along the border, and which vertices (n,) are on a wall."""
    count, border = wall.vertex_count, border_half_edges(wall.faces)
    layers = math.ceil(THICKNESS / edge)
    used = np.unique(border)
    between = [
        wall.vertices[used] + (inner[used] - wall.vertices[used]) * k / layers
        for k in range(1, layers)
    ]
    # the numbers of border vertices on the outer wall, in each layer of the fracture, and inside
    rank = np.zeros(count, dtype=np.int64)
    rank[used] = np.arange(len(used))
    levels = [
        np.arange(count),
        *(2 * count + k * len(used) + rank for k in range(layers - 1)),
        np.arange(count) + count,
    ]
    start, end = border.T
    strips = [
        np.concatenate(
            [
                np.stack([upper[end], upper[start], lower[start]], axis=1),
                np.stack([upper[end], lower[start], lower[end]], axis=1),
            ]
        )
        for upper, lower in pairwise(levels)
    ]
    vertices = np.concatenate([wall.vertices, inner, *between])
    faces = np.concatenate([wall.faces, wall.faces[:, ::-1] + count, *strips])
    return TriangleMesh(vertices, faces, name=name), np.arange(len(vertices)) < 2 * count


def _moved(solid: TriangleMesh, on_wall: Bools, rng: np.random.Generator) -> Sherd:
    """Turned and shifted at random."""
    turned = rotated(solid, rng)
    shift = rng.normal(size=3)
    back = np.eye(4)
    weights = np.ones(solid.vertex_count)
    back[:3, :3] = closest_rotation(turned.vertices, solid.vertices, weights)
    back[:3, 3] = -back[:3, :3] @ shift
    return Sherd(solid.with_vertices(turned.vertices + shift), back, on_wall)
