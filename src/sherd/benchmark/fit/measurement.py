"""One pair fitted, and beside it what others make of the same map."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from sherd.arrays import Bools, Floats
from sherd.benchmark.fit.baselines import arap_positions, has_libigl, nonrigid_icp_positions
from sherd.benchmark.fit.sources import FitPair, FitSource
from sherd.errors import InfeasibleError
from sherd.fitting.as_rigid_as_possible import Elasticity
from sherd.fitting.fit import fit
from sherd.fitting.mending.self_intersection import intersecting_faces
from sherd.fitting.mending.turned_faces import turned_faces
from sherd.fitting.targets import Targets, targets_of
from sherd.library.fitted_scale import match_with_fitted_scale, sizing_after
from sherd.mesh.geometry import face_areas
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.match_options import MatchOptions
from sherd.results.match_result import MatchResult

__all__ = ["WAYS", "FitRow", "Quality", "measured_fit"]

# What is so near to the cut, in sqrt(area), is also measured apart.
NEAR_CUT = 0.1
WAYS = ("fit", "arap", "icp")


@dataclass(frozen=True)
class Quality:
    """How good one way is; lengths in sqrt(area) of the full shape, NaN if not measured.

    Attributes
    ----------
    seen, hidden, near_cut
        Mean distance of vertices from the truth, by area: of what the part shows, of the rest, and
        of the rest within 0.1 of what it shows.
    turned
        Faces turned over beside the rotation of what is around them.
    area_kept
        Area of the hidden faces, over that in the full shape, over that of the truth likewise.
    intersecting
        Share of the faces that pierce others and do not in the full shape.
    seconds
        Wall time after matching.
    """

    seen: float = math.nan
    hidden: float = math.nan
    near_cut: float = math.nan
    turned: int = 0
    area_kept: float = math.nan
    intersecting: float = math.nan
    seconds: float = math.nan


@dataclass(frozen=True)
class FitRow:
    """One pair: its names, the status of the match, and the quality of each way.

    Attributes
    ----------
    calibration
        Of vertices by tenths of the chance that was promised: number, and how many were near.
    """

    name: str
    group: str
    vertices: int
    status: str
    fit: Quality
    arap: Quality
    icp: Quality
    calibration: tuple[tuple[int, int], ...]


def measured_fit(source: FitSource, *, with_icp: bool = False) -> FitRow:
    """Match and fit one pair and measure it.

    Raises
    ------
    MeshFileError
        If a file is missing or damaged.
    """
    pair = source.load()
    unit = pair.full.length
    shape = pair.full.with_vertices(pair.full.vertices / unit)
    nothing = Quality()
    try:
        found = match_with_fitted_scale(pair.full, pair.part)
    except InfeasibleError:
        return FitRow(
            source.name, source.group, shape.vertex_count, "none", nothing, nothing, nothing, ()
        )
    start = time.perf_counter()
    answer = fit(found, sizing=sizing_after(found, MatchOptions.scale))
    seconds = time.perf_counter() - start
    own = _quality(pair, shape, answer.positions / unit, seconds)
    targets = targets_of([found])
    if has_libigl():
        arap = _timed(pair, shape, lambda: arap_positions(shape, targets) / found.scale)
    else:
        arap = nothing
    icp = _timed(pair, shape, lambda: _icp(shape, targets, found)) if with_icp else nothing
    near = np.linalg.norm(answer.positions - pair.truth, axis=1) < answer.options.near * unit
    return FitRow(
        name=source.name,
        group=source.group,
        vertices=shape.vertex_count,
        status=found.status.name.lower(),
        fit=own,
        arap=arap,
        icp=icp,
        calibration=_calibration(answer.chance, near),
    )


def _icp(shape: TriangleMesh, targets: Targets, found: MatchResult) -> Floats:
    return nonrigid_icp_positions(shape, targets, found) / found.scale


def _timed(pair: FitPair, shape: TriangleMesh, solve: Callable[[], Floats]) -> Quality:
    start = time.perf_counter()
    try:
        positions = solve()
    except InfeasibleError:
        return Quality()
    return _quality(pair, shape, positions, time.perf_counter() - start)


def _quality(pair: FitPair, shape: TriangleMesh, positions: Floats, seconds: float) -> Quality:
    truth = pair.truth / pair.full.length
    off = np.linalg.norm(positions - truth, axis=1)
    areas, seen, faces = shape.vertex_areas, pair.seen, shape.faces
    near = ~seen & (cKDTree(shape.vertices[seen]).query(shape.vertices)[0] < NEAR_CUT)
    rotations = Elasticity(shape).fitted_rotations(positions)
    hidden = (~seen)[faces].all(axis=1)
    fresh = intersecting_faces(positions, faces) & ~intersecting_faces(shape.vertices, faces)
    kept = face_areas(positions, faces[hidden]).sum() / face_areas(truth, faces[hidden]).sum()
    return Quality(
        seen=_mean(off, areas, seen),
        hidden=_mean(off, areas, ~seen),
        near_cut=_mean(off, areas, near),
        turned=int(turned_faces(shape.vertices, positions, rotations, faces).sum()),
        area_kept=float(kept),
        intersecting=float(fresh.mean()),
        seconds=seconds,
    )


def _mean(off: Floats, areas: Floats, where: Bools) -> float:
    return float(off[where] @ areas[where] / areas[where].sum()) if where.any() else math.nan


def _calibration(chance: Floats, near: Bools) -> tuple[tuple[int, int], ...]:
    tenth = np.minimum((10 * chance).astype(int), 9)
    counts = np.bincount(tenth, minlength=10)
    hits = np.bincount(tenth, near, minlength=10).astype(int)
    return tuple(zip(counts.tolist(), hits.tolist(), strict=True))
