"""What others do with the same map: as-rigid-as-possible (libigl), non-rigid ICP (trimesh)."""

from __future__ import annotations

import importlib
import importlib.util
from typing import Any

import numpy as np

from sherd.arrays import Floats
from sherd.errors import InfeasibleError, OptionError
from sherd.fitting.targets import Targets
from sherd.mesh.geometry import closest_rotation
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.results.match_result import MatchResult

__all__ = ["arap_positions", "has_libigl", "nonrigid_icp_positions", "require_icp"]

ROUNDS = 100
# Landmarks are what costs memory; so many of the surest vertices seed the ICP.
LANDMARKS = 200


def has_libigl() -> bool:
    """Whether the witness is installed: ``pip install libigl``."""
    return importlib.util.find_spec("igl") is not None


def require_icp() -> None:
    """Refuse where trimesh's non-rigid ICP cannot run.

    Raises
    ------
    OptionError
        If rtree, which it finds closest points by, is not installed.
    """
    if importlib.util.find_spec("rtree") is None:
        raise OptionError("--icp: trimesh's non-rigid ICP needs rtree: pip install rtree")


def arap_positions(shape: TriangleMesh, targets: Targets) -> Floats:
    """Libigl's as-rigid-as-possible deformation (spokes and rims), seen vertices at their targets.

    From the rigid motion that fits best, 100 rounds. (n, 3), in units of sqrt(area).

    Raises
    ------
    InfeasibleError
        If libigl has no solution, as where a component has no seen vertex.
    """
    igl: Any = importlib.import_module("igl")
    fixed = np.flatnonzero(targets.seen).astype(np.int64)
    places = np.ascontiguousarray(targets.positions[fixed])
    data = igl.ARAPData()
    data.max_iter = ROUNDS
    data.energy = igl.ARAP_ENERGY_TYPE_SPOKES_AND_RIMS
    faces = shape.faces.astype(np.int64)
    try:
        igl.arap_precomputation(shape.vertices, faces, 3, fixed, data)
    except RuntimeError as error:
        raise InfeasibleError(f"{shape.name}: libigl has no solution ({error})") from error
    start = _rigid(shape, targets)
    return np.asarray(igl.arap_solve(places, data, start), dtype=np.float64)


def nonrigid_icp_positions(shape: TriangleMesh, targets: Targets, match: MatchResult) -> Floats:
    """Trimesh's `nricp_amberg` from the rigid motion, with 200 vertices of the map as landmarks."""
    import trimesh  # noqa: PLC0415 - loads slowly

    registration: Any = importlib.import_module("trimesh.registration")

    unit = match.full.length / match.scale
    scan = trimesh.Trimesh(match.part.vertices / unit, match.part.faces, process=False)
    scan.update_faces(scan.nondegenerate_faces())  # it has no closest points on others
    source = trimesh.Trimesh(_rigid(shape, targets), shape.faces, process=False)
    seen = np.flatnonzero(targets.seen)
    order = seen[np.argsort(-targets.confidence[seen], kind="stable")]
    chosen = order[np.linspace(0, len(order) - 1, min(LANDMARKS, len(order))).astype(int)]
    result = registration.nricp_amberg(
        source,
        scan,
        source_landmarks=chosen,
        target_positions=targets.positions[chosen],
        distance_threshold=0.05,
    )
    return np.asarray(result, dtype=np.float64)


def _rigid(shape: TriangleMesh, targets: Targets) -> Floats:
    weights = targets.confidence * shape.vertex_areas
    turn = closest_rotation(shape.vertices, targets.positions, weights)
    center = np.average(shape.vertices, axis=0, weights=weights)
    there = np.average(targets.positions, axis=0, weights=weights)
    moved: Floats = np.ascontiguousarray((shape.vertices - center) @ turn.T + there)
    return moved
