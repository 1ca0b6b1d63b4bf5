"""Parts of a whole body, cut at random: balls, halves, bodies without limbs."""

from __future__ import annotations

import numpy as np

from sherd.arrays import Floats
from sherd.errors import InfeasibleError, OptionError
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.shapes.clip import clip
from sherd.shapes.fragment import Fragment, largest_piece
from sherd.spectral.geodesics import Geodesics
from sherd.spectral.sampling import farthest_point_sample

__all__ = ["CUTS", "random_cut"]


CUTS = ("balls", "halves", "limbs off")
# Share of the body's area that a part has.
SMALLEST, LARGEST = 0.3, 0.8
# Head, hands and feet: the points of a body farthest from its middle and from each other.
LIMBS = 5
LIMBS_OFF = 2
# A half falls in pieces of which the largest may be too small; then another is drawn.
ATTEMPTS = 100


def random_cut(body: TriangleMesh, kind: str, rng: np.random.Generator) -> Fragment:
    """A connected part with 0.3 to 0.8 of the body's area, that knows where it lies on the body.

    Parameters
    ----------
    body
        A connected shape.
    kind
        ``"balls"``: what lies within a geodesic distance of a random point; ``"halves"``: on one
        side of a random plane, its largest piece; ``"limbs off"``: beyond a geodesic distance
        from two of the five points that stick out most.
    rng
        Draws place and share; the same state gives the same part.

    Raises
    ------
    InfeasibleError
        If no part of that size was found.
    OptionError
        If the kind is unknown.
    """
    for _ in range(ATTEMPTS):
        share = rng.uniform(SMALLEST, LARGEST)
        height = _height(body, kind, rng)
        level = _level(body, height, share)
        mesh, points = clip(body, height - level)
        present = np.ones(mesh.vertex_count, dtype=bool)
        part = largest_piece(Fragment(mesh, points, body, present))
        if SMALLEST <= part.mesh.area / body.area <= LARGEST:
            return part
    raise InfeasibleError(
        f"{ATTEMPTS} cuts of {body.name} ({kind}) left no part with {SMALLEST} to {LARGEST} of it"
    )


def _height(body: TriangleMesh, kind: str, rng: np.random.Generator) -> Floats:
    """A function (n,) whose upper part is kept."""
    height: Floats
    if kind == "halves":
        height = body.vertices @ rng.normal(size=3)
    elif kind == "balls":
        areas = body.vertex_areas
        center = int(rng.choice(len(areas), p=areas / areas.sum()))
        height = -Geodesics(body).distances_from(center)[0]
    elif kind == "limbs off":
        middle = np.average(body.vertices, axis=0, weights=body.vertex_areas)
        start = int(np.linalg.norm(body.vertices - middle, axis=1).argmin())
        _, distances = farthest_point_sample(Geodesics(body), LIMBS + 1, start=start)
        off = rng.choice(LIMBS, size=LIMBS_OFF, replace=False)
        height = distances[1 + off].min(axis=0)
    else:
        raise OptionError(f"kind is {kind!r}, but one of {CUTS} is needed")
    return height


def _level(body: TriangleMesh, height: Floats, share: float) -> float:
    """The level above which `share` of the area lies, up to a vertex."""
    order = np.argsort(-height)
    reached = np.cumsum(body.vertex_areas[order])
    return float(height[order[np.searchsorted(reached, share * reached[-1])]])
