"""Compiled: a surface grows over the Delaunay triangles of points, from its border outward.

Kernels on plain arrays; :mod:`sherd.scan.surface_from_points` says what they are for. After
Cohen-Steiner and Da, *A greedy Delaunay-based surface reconstruction algorithm*, 2004; what
differs is named.
"""

from __future__ import annotations

from heapq import heappop, heappush
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sherd.arrays import Bools, Floats, Ints
from sherd.compiled import compiled

__all__ = ["Triangles", "grown"]

# More triangles than meet at a point of any sane mesh; the point then takes no more.
MOST = 32
# Neighbors that bend less continue a surface, and the smallest of them comes first; others wait
# (the paper's 30 degrees). Beyond 150 degrees it would fold back on itself (the paper's 5/6 pi).
COS_SMOOTH = np.cos(np.pi / 6)
COS_FOLD = np.cos(5 * np.pi / 6)
# Where two fronts meet at a point, the surface must go on straight: cosine between the new triangle
# and the normal there, 32 degrees. Between sheets that nearly touch the fronts would otherwise sew
# hundreds of handles; those gaps stay open. Not in the paper, which looks one triangle ahead.
COS_MEET = 0.85
# Triangles of parallel normals that share a point must not overlap: of these, two that bend less
# than 60 degrees, and lie in each other by more than rounding.
COS_PARALLEL = 0.5
ROUNDING = 1e-3


class Triangles(NamedTuple):
    """The triangles that a surface may be made of: m of them, with e edges and n points.

    Attributes
    ----------
    points
        (n, 3).
    corners
        (m, 3) points of each triangle, ascending.
    sides
        (m, 3) edges of each triangle: of corners 0 and 1, 1 and 2, 0 and 2.
    first, along
        Triangles at edge i are `along[first[i] : first[i + 1]]`.
    normals
        (m, 3) unit normals of the triangles, corners in their order.
    size
        (m,) radius of the smallest empty ball through a triangle, its median about 1.
    large
        (m,) bool: larger than most triangles around. Those only continue a surface smoothly.
    """

    points: Floats
    corners: Ints
    sides: Ints
    first: Ints
    along: Ints
    normals: Floats
    size: Floats
    large: Bools


class Front(NamedTuple):
    """A growing surface.

    Attributes
    ----------
    turn
        (m,) 1 if a triangle is taken as its corners stand, -1 if turned over, 0 if not taken.
    owner
        (e, 2) the triangle that runs along an edge from its lower to its higher point, and the
        one that runs back; -1 if there is none. An edge with one owner is border.
    fans
        (n,) how many runs of adjacent triangles are around a point.
    full
        (n,) whether the only run around a point is closed.
    ring, rung
        (n, MOST) and (n,) the triangles at a point, and their number.
    """

    turn: NDArray[np.int8]
    owner: Ints
    fans: Ints
    full: Bools
    ring: Ints
    rung: Ints


@compiled()
def grown(cloud):
    """Which of the :class:`Triangles` make the surface: `turn` (m,) of :class:`Front`."""
    points, corners, sides, size = cloud.points, cloud.corners, cloud.sides, cloud.size
    count, edges, triangles = len(points), len(cloud.first) - 1, len(corners)
    turn = np.zeros(triangles, np.int8)
    owner = np.full((edges, 2), -1, np.int64)
    fans, full = np.zeros(count, np.int64), np.zeros(count, np.bool_)
    ring, rung = np.empty((count, MOST), np.int64), np.zeros(count, np.int64)
    surface = Front(turn, owner, fans, full, ring, rung)
    waiting = np.full(edges, -1, np.int64)  # the triangle that stands in the heap for an edge
    heap = [(0.0, 0, 0) for _ in range(0)]
    order = np.argsort(size, kind="mergesort")
    start = 0
    while True:
        if len(heap) == 0:
            while start < triangles and not _is_seed(order[start], cloud, surface):
                start += 1
            if start == triangles:
                return turn
            triangle, way = order[start], 1
        else:
            old, edge, triangle = heappop(heap)
            if not _is_border(owner, edge):
                continue
            key, best = _next(edge, cloud, surface)
            if best != triangle or key > old:  # its surroundings changed since it was put there
                waiting[edge] = best
                if best >= 0:
                    heappush(heap, (key, edge, best))
                continue
            way = _way(sides, triangle, edge, owner)
        _take(triangle, way, cloud, surface)
        _wait(triangle, heap, waiting, cloud, surface)


@compiled()
def _wait(taken, heap, waiting, cloud, surface):
    """Put the border edges around a new triangle on the heap, with what is best for each."""
    corners, sides = cloud.corners, cloud.sides
    owner, ring, rung = surface.owner, surface.ring, surface.rung
    for corner in corners[taken]:
        for near in ring[corner, : rung[corner]]:
            for edge in sides[near]:
                if _is_border(owner, edge):
                    key, best = _next(edge, cloud, surface)
                    if best >= 0 and waiting[edge] != best:
                        waiting[edge] = best
                        heappush(heap, (key, edge, best))


@compiled()
def _is_seed(triangle, cloud, surface):
    """Whether a triangle is far from the surface so far, and may start another piece."""
    fans, corners, large = surface.fans, cloud.corners, cloud.large
    a, b, c = corners[triangle]
    return not large[triangle] and fans[a] == 0 and fans[b] == 0 and fans[c] == 0


@compiled()
def _slot(side, way):
    """Which owner of its side 0, 1, 2 a triangle is: side 2 runs from corner 2 to corner 0."""
    natural = 0 if side < 2 else 1
    return natural if way > 0 else 1 - natural


@compiled()
def _way(sides, triangle, edge, owner):
    """1 or -1: how the triangle has to turn to continue the surface over a border edge."""
    side = 0
    while sides[triangle, side] != edge:
        side += 1
    missing = 0 if owner[edge, 0] < 0 else 1
    return 1 if _slot(side, 1) == missing else -1


@compiled()
def _next(edge, cloud, surface):
    """Key and number of the triangle that best continues the surface over an edge; -1 if none."""
    _, _, sides, first, along, normals, size, large = cloud
    turn, owner = surface.turn, surface.owner
    best, least, bend = -1, np.inf, 1.0
    for triangle in along[first[edge] : first[edge + 1]]:
        if turn[triangle] != 0 or size[triangle] >= least:
            continue
        way = _way(sides, triangle, edge, owner)
        sharpest = 1.0
        for side in range(3):
            other = owner[sides[triangle, side], 1 - _slot(side, way)]
            if other >= 0:
                cosine = way * turn[other] * _cosine(normals, triangle, other)
                sharpest = min(sharpest, cosine)
        limit = COS_SMOOTH if large[triangle] else COS_FOLD
        if sharpest >= limit and _fits(triangle, way, cloud, surface):
            best, least, bend = triangle, size[triangle], sharpest
    if best < 0:
        return np.inf, -1
    key = least / (1.0 + least) if bend > COS_SMOOTH else 1.0 + np.arccos(max(-1.0, bend))
    return key, best


@compiled()
def _fits(triangle, way, cloud, surface):
    """Whether the surface stays a manifold, up to points where two fans touch for a while."""
    points, corners, sides, _, _, normals, _, _ = cloud
    turn, owner, fans, full, ring, rung = surface
    for side in range(3):
        if owner[sides[triangle, side], _slot(side, way)] >= 0:
            return False
    for place in range(3):
        corner = corners[triangle, place]
        if full[corner] or rung[corner] == MOST:
            return False
        one, two = _sides_at(sides, triangle, place)
        met = _is_used(owner, one) + _is_used(owner, two)
        if met == 2 and fans[corner] > 1 and _other_end(corner, one, cloud, surface) == two:
            return False  # a closed fan leaves no room for another
        touches = met == 0 and fans[corner] > 0
        if touches and (fans[corner] > 1 or not _meets(triangle, way, corner, normals, surface)):
            return False
        for near in ring[corner, : rung[corner]]:
            if way * turn[near] * _cosine(normals, triangle, near) > COS_PARALLEL and (
                _overlaps(points, corners, corner, triangle, near)
                or _overlaps(points, corners, corner, near, triangle)
            ):
                return False
    return True


@compiled()
def _meets(triangle, way, corner, normals, surface):
    """Whether a triangle continues the surface that is already at a corner."""
    turn, ring, rung = surface.turn, surface.ring, surface.rung
    along, square = 0.0, 0.0
    for i in range(rung[corner]):
        one = ring[corner, i]
        along += turn[one] * way * _cosine(normals, triangle, one)
        for j in range(rung[corner]):
            two = ring[corner, j]
            square += turn[one] * turn[two] * _cosine(normals, one, two)
    return along >= COS_MEET * np.sqrt(max(square, 0.0))


@compiled()
def _take(triangle, way, cloud, surface):
    """Add a triangle to the surface."""
    corners, sides = cloud.corners, cloud.sides
    turn, owner, fans, full, ring, rung = surface
    for place in range(3):
        corner = corners[triangle, place]
        one, two = _sides_at(sides, triangle, place)
        met = _is_used(owner, one) + _is_used(owner, two)
        if met == 0:
            fans[corner] += 1
        elif met == 2:
            if _other_end(corner, one, cloud, surface) == two:
                full[corner] = True
            else:
                fans[corner] -= 1
        ring[corner, rung[corner]] = triangle
        rung[corner] += 1
    for side in range(3):
        owner[sides[triangle, side], _slot(side, way)] = triangle
    turn[triangle] = way


@compiled()
def _is_used(owner, edge):
    return owner[edge, 0] >= 0 or owner[edge, 1] >= 0


@compiled()
def _is_border(owner, edge):
    return (owner[edge, 0] >= 0) != (owner[edge, 1] >= 0)


@compiled()
def _sides_at(sides, triangle, place):
    """The two sides of a triangle at its corner 0, 1 or 2."""
    one = sides[triangle, 0] if place < 2 else sides[triangle, 1]
    two = sides[triangle, 2] if place != 1 else sides[triangle, 1]
    return one, two


@compiled()
def _other_end(corner, edge, cloud, surface):
    """The other border edge of the fan around a corner that begins with a border edge."""
    corners, sides, owner = cloud.corners, cloud.sides, surface.owner
    triangle = max(owner[edge, 0], owner[edge, 1])
    while True:
        place = 0
        while corners[triangle, place] != corner:
            place += 1
        one, two = _sides_at(sides, triangle, place)
        edge = two if one == edge else one
        if owner[edge, 0] < 0 or owner[edge, 1] < 0:
            return edge
        triangle = owner[edge, 0] if owner[edge, 1] == triangle else owner[edge, 1]


@compiled()
def _overlaps(points, corners, corner, inner, outer):
    """Whether triangle `inner` lies in the angle of `outer` at a corner that both have."""
    a, b = _ends(corners, corner, outer)
    c, d = _ends(corners, corner, inner)
    p, q = _toward(points, corner, a), _toward(points, corner, b)
    r, s = _toward(points, corner, c), _toward(points, corner, d)
    between = (r[0] + s[0], r[1] + s[1], r[2] + s[2])
    return (
        (c not in (a, b) and _is_between(r, p, q))
        or (d not in (a, b) and _is_between(s, p, q))
        or _is_between(between, p, q)
    )


@compiled()
def _is_between(ray, p, q):
    """Whether the projection of a ray to the plane of two unit vectors lies between them."""
    cosine = p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
    x = ray[0] * p[0] + ray[1] * p[1] + ray[2] * p[2]
    y = ray[0] * q[0] + ray[1] * q[1] + ray[2] * q[2]
    least = ROUNDING * (1.0 - cosine * cosine)
    return x - cosine * y > least and y - cosine * x > least


@compiled()
def _ends(corners, corner, triangle):
    """The other two corners of a triangle."""
    a, b, c = corners[triangle, 0], corners[triangle, 1], corners[triangle, 2]
    return (b, c) if a == corner else ((a, c) if b == corner else (a, b))


@compiled()
def _toward(points, start, end):
    """The direction from one point to another; tuples, because arrays are made too often here."""
    x = points[end, 0] - points[start, 0]
    y = points[end, 1] - points[start, 1]
    z = points[end, 2] - points[start, 2]
    scale = 1.0 / np.sqrt(x * x + y * y + z * z)
    return x * scale, y * scale, z * scale


@compiled()
def _cosine(normals, one, two):
    return (
        normals[one, 0] * normals[two, 0]
        + normals[one, 1] * normals[two, 1]
        + normals[one, 2] * normals[two, 2]
    )
