"""Maps between pieces made consistent: around a loop one should come back to where one began.

Each map is replaced by the agreement of all that speak for it: itself and the detours over one
other piece, in rounds, so that evidence spreads over the group. Positions of one vertex are
averaged by a weighted geometric median, which a minority of wrong detours does not move
(Weiszfeld's iteration). Maps that did not exist arise from detours alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, permutations

import numpy as np

from sherd.arrays import Bools, Floats
from sherd.mesh.surface_points import SurfacePoints, closest_points
from sherd.mesh.triangle_mesh import TriangleMesh

__all__ = ["TORN", "PieceMap", "cycle_error", "synchronized"]

ROUNDS = 2
WEISZFELD = 8
# Corners of a triangle whose images are farther apart than this many of its edges do not say where
# its inside lies.
TORN = 3.0
# A detour is believed less than a direct map: two errors add up.
DETOUR = 0.5
# What speaks for a vertex must agree within this, in the unit of lengths: a bad error.
AGREE = 0.1


@dataclass(frozen=True, eq=False)
class PieceMap:
    """Where vertices of one piece lie on another.

    Attributes
    ----------
    points
        (n,) of the other piece.
    known
        (n,) bool, whether the other piece has it.
    trust
        (n,) weight in [0, 1].
    """

    points: SurfacePoints
    known: Bools
    trust: Floats

    def trust_at(self, points: SurfacePoints, mesh: TriangleMesh) -> Floats:
        """The trust (p,) at points of the first piece."""
        return points.interpolate(mesh, self.trust)


Maps = Mapping[tuple[int, int], PieceMap]


def synchronized(
    pieces: Sequence[TriangleMesh], maps: Maps, unit: float
) -> dict[tuple[int, int], PieceMap]:
    """The maps between all pieces that these maps connect, consistent with each other.

    Parameters
    ----------
    pieces
        All pieces.
    maps
        By (here, there), in both directions of each pair.
    unit
        Length that counts as 1.
    """
    found = dict(maps)
    members = sorted({k for pair in maps for k in pair})
    for _ in range(ROUNDS):
        after: dict[tuple[int, int], PieceMap] = {}
        for here, there in permutations(members, 2):
            spoken = _spoken(pieces, found, here, there, unit)
            if spoken is not None:
                after[here, there] = spoken
        found = after
    return found


def cycle_error(pieces: Sequence[TriangleMesh], maps: Maps, unit: float) -> float:
    """Mean distance between vertices and where they come back to around all loops of three.

    NaN if no vertex goes around.
    """
    total, count = 0.0, 0
    for loop in combinations(sorted({k for pair in maps for k in pair}), 3):
        for here, over, back in (loop, loop[::-1]):
            if not {(here, over), (over, back), (back, here)} <= set(maps):
                continue
            places, known = _after(pieces, maps[here, over], maps[over, back], (over, back))
            at = closest_points(pieces[back], places[known])
            home, there = _carried(pieces, at, maps[back, here], (back, here))
            off = np.linalg.norm(home - pieces[here].vertices[known], axis=1)[there]
            total, count = total + float(off.sum()), count + len(off)
    return total / count / unit if count else float("nan")


def _spoken(
    pieces: Sequence[TriangleMesh], maps: Maps, here: int, there: int, unit: float
) -> PieceMap | None:
    """What all maps say about where `here` lies on `there`; None if nothing does."""
    places, weights = [], []
    if (here, there) in maps:
        direct = maps[here, there]
        places.append(direct.points.positions(pieces[there]))
        weights.append(np.where(direct.known, direct.trust, 0.0))
    for over in sorted({k for pair in maps for k in pair} - {here, there}):
        if (here, over) in maps and (over, there) in maps:
            first, second = maps[here, over], maps[over, there]
            at, both = _after(pieces, first, second, (over, there))
            trust = second.trust_at(first.points, pieces[over]) * first.trust
            places.append(at)
            weights.append(np.where(both, DETOUR * trust, 0.0))
    if not places:
        return None
    stack, weight = np.array(places), np.array(weights)
    known: Bools = weight.max(axis=0) > 0
    if not known.any():
        return None
    median = _median(stack, weight)
    near = np.linalg.norm(stack - median, axis=2) < AGREE * unit
    agreeing = (weight * near).sum(axis=0) / np.maximum(weight.sum(axis=0), 1e-300)
    trust = np.where(known, agreeing * np.minimum(weight.max(axis=0), 1.0), 0.0)
    # where most of the evidence contradicts itself nothing is known
    return PieceMap(closest_points(pieces[there], median), known & (agreeing > DETOUR), trust)


def _after(
    pieces: Sequence[TriangleMesh], first: PieceMap, second: PieceMap, names: tuple[int, int]
) -> tuple[Floats, Bools]:
    """Positions (n, 3) after both maps, and where both are known."""
    places, known = _carried(pieces, first.points, second, names)
    return places, known & first.known


def _carried(
    pieces: Sequence[TriangleMesh], points: SurfacePoints, by: PieceMap, names: tuple[int, int]
) -> tuple[Floats, Bools]:
    """Positions (p, 3) on the second of points on the first, and whether they are known."""
    over, there = (pieces[k] for k in names)
    corners = over.faces[points.faces]
    images = by.points.positions(there)[corners]
    places = np.einsum("pk,pkx->px", points.barycentric, images)
    spread = np.ptp(images, axis=1).max(axis=1)
    known: Bools = by.known[corners].all(axis=1) & (spread < TORN * over.mean_edge_length)
    return places, known


def _median(places: Floats, weights: Floats) -> Floats:
    """Weighted geometric median (n, 3) of places (c, n, 3); weights (c, n)."""
    total = np.maximum(weights.sum(axis=0), 1e-300)[:, None]
    median: Floats = (weights[:, :, None] * places).sum(axis=0) / total
    for _ in range(WEISZFELD):
        away = np.linalg.norm(places - median, axis=2)
        pull = weights / np.maximum(away, 1e-9 + 1e-6 * away.mean())
        total = np.maximum(pull.sum(axis=0), 1e-300)[:, None]
        median = (pull[:, :, None] * places).sum(axis=0) / total
    return median
