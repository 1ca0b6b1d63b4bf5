"""Partial matching of non-rigid 3D shapes: find where a piece belongs on the whole.

>>> import sherd
>>> from sherd.shapes import creature, cut_by_ball, whole
>>> full = creature(5000)
>>> part = cut_by_ball(whole(creature(5000, pose="walk"), full), 0, 0.4).mesh
>>> sherd.locate(full, part).check().passed
True
"""

from __future__ import annotations

import importlib
import sys
import types
from typing import TYPE_CHECKING, Any

from sherd._version import __version__

if TYPE_CHECKING:
    from sherd.assemble import assemble
    from sherd.batching.batch import BatchResult, batch
    from sherd.batching.collect import collect_batch
    from sherd.batching.ledger.rows import BatchRow, PairRow
    from sherd.batching.options import BatchOptions
    from sherd.batching.pairs.all_pairs import PairsResult, all_pairs
    from sherd.batching.parts import BatchPart
    from sherd.energy.convergence import Convergence
    from sherd.errors import (
        InfeasibleError,
        InputError,
        InvalidMeshError,
        MeshFileError,
        OptionError,
        OutputError,
        SherdError,
    )
    from sherd.files.cloud_files import read_scan
    from sherd.files.mesh_files import read_mesh, write_mesh
    from sherd.fitting.fit import fit
    from sherd.join import join
    from sherd.landmarks.carried import CarriedLandmarks, carry_landmarks
    from sherd.landmarks.landmark_files import read_landmarks, write_landmarks
    from sherd.landmarks.landmark_list import Landmarks
    from sherd.landmarks.landmark_table import landmark_table
    from sherd.landmarks.several import median_landmarks
    from sherd.library.fitted_scale import match_with_fitted_scale
    from sherd.library.folder import Library
    from sherd.library.identify import identify
    from sherd.locate import locate
    from sherd.match import match
    from sherd.mesh.point_cloud import PointCloud
    from sherd.mesh.surface_points import SurfacePoints
    from sherd.mesh.triangle_mesh import TriangleMesh
    from sherd.overlap import overlap
    from sherd.repair.inspection import MeshReport, inspect
    from sherd.repair.repair import RepairReport, repair
    from sherd.report.notebook import plot, show
    from sherd.report.stored.stored_fit import read_fit
    from sherd.report.stored.stored_match import read_match
    from sherd.report.write import write_report
    from sherd.results.fitted.fit_options import FitOptions
    from sherd.results.fitted.fit_result import Fit
    from sherd.results.locate_options import LocateOptions
    from sherd.results.locate_result import LocateResult
    from sherd.results.many.identification import CandidateAnswer, Identification
    from sherd.results.many.identify_options import IdentifyOptions
    from sherd.results.match_options import MatchOptions
    from sherd.results.match_result import MatchResult
    from sherd.results.overlap_options import OverlapOptions
    from sherd.results.overlap_result import Overlap
    from sherd.results.placement import Placement
    from sherd.results.puzzle.assemble_options import AssembleOptions
    from sherd.results.puzzle.assembly import Assembly
    from sherd.results.puzzle.joined import Joined
    from sherd.results.status import Status
    from sherd.scan.surface_from_points import surface_from_points
    from sherd.surface.template import Template

# Where each public name lives. Names are loaded when first used, so `import sherd` stays light.
_HOMES = {
    "AssembleOptions": "sherd.results.puzzle.assemble_options",
    "Assembly": "sherd.results.puzzle.assembly",
    "CandidateAnswer": "sherd.results.many.identification",
    "CarriedLandmarks": "sherd.landmarks.carried",
    "BatchOptions": "sherd.batching.options",
    "BatchPart": "sherd.batching.parts",
    "BatchResult": "sherd.batching.batch",
    "BatchRow": "sherd.batching.ledger.rows",
    "Convergence": "sherd.energy.convergence",
    "Identification": "sherd.results.many.identification",
    "IdentifyOptions": "sherd.results.many.identify_options",
    "Fit": "sherd.results.fitted.fit_result",
    "FitOptions": "sherd.results.fitted.fit_options",
    "InfeasibleError": "sherd.errors",
    "InputError": "sherd.errors",
    "InvalidMeshError": "sherd.errors",
    "Joined": "sherd.results.puzzle.joined",
    "Landmarks": "sherd.landmarks.landmark_list",
    "Library": "sherd.library.folder",
    "LocateOptions": "sherd.results.locate_options",
    "LocateResult": "sherd.results.locate_result",
    "MatchOptions": "sherd.results.match_options",
    "MatchResult": "sherd.results.match_result",
    "MeshFileError": "sherd.errors",
    "MeshReport": "sherd.repair.inspection",
    "OptionError": "sherd.errors",
    "OutputError": "sherd.errors",
    "Overlap": "sherd.results.overlap_result",
    "OverlapOptions": "sherd.results.overlap_options",
    "PairRow": "sherd.batching.ledger.rows",
    "PairsResult": "sherd.batching.pairs.all_pairs",
    "Placement": "sherd.results.placement",
    "PointCloud": "sherd.mesh.point_cloud",
    "RepairReport": "sherd.repair.repair",
    "SherdError": "sherd.errors",
    "Status": "sherd.results.status",
    "SurfacePoints": "sherd.mesh.surface_points",
    "Template": "sherd.surface.template",
    "TriangleMesh": "sherd.mesh.triangle_mesh",
    "all_pairs": "sherd.batching.pairs.all_pairs",
    "assemble": "sherd.assemble",
    "carry_landmarks": "sherd.landmarks.carried",
    "identify": "sherd.library.identify",
    "batch": "sherd.batching.batch",
    "collect_batch": "sherd.batching.collect",
    "fit": "sherd.fitting.fit",
    "inspect": "sherd.repair.inspection",
    "join": "sherd.join",
    "landmark_table": "sherd.landmarks.landmark_table",
    "locate": "sherd.locate",
    "match": "sherd.match",
    "match_with_fitted_scale": "sherd.library.fitted_scale",
    "median_landmarks": "sherd.landmarks.several",
    "overlap": "sherd.overlap",
    "plot": "sherd.report.notebook",
    "read_landmarks": "sherd.landmarks.landmark_files",
    "read_fit": "sherd.report.stored.stored_fit",
    "read_match": "sherd.report.stored.stored_match",
    "read_mesh": "sherd.files.mesh_files",
    "read_scan": "sherd.files.cloud_files",
    "repair": "sherd.repair.repair",
    "show": "sherd.report.notebook",
    "surface_from_points": "sherd.scan.surface_from_points",
    "write_landmarks": "sherd.landmarks.landmark_files",
    "write_mesh": "sherd.files.mesh_files",
    "write_report": "sherd.report.write",
}

__all__ = [
    "AssembleOptions",
    "Assembly",
    "BatchOptions",
    "BatchPart",
    "BatchResult",
    "BatchRow",
    "CandidateAnswer",
    "CarriedLandmarks",
    "Convergence",
    "Fit",
    "FitOptions",
    "Identification",
    "IdentifyOptions",
    "InfeasibleError",
    "InputError",
    "InvalidMeshError",
    "Joined",
    "Landmarks",
    "Library",
    "LocateOptions",
    "LocateResult",
    "MatchOptions",
    "MatchResult",
    "MeshFileError",
    "MeshReport",
    "OptionError",
    "OutputError",
    "Overlap",
    "OverlapOptions",
    "PairRow",
    "PairsResult",
    "Placement",
    "PointCloud",
    "RepairReport",
    "SherdError",
    "Status",
    "SurfacePoints",
    "Template",
    "TriangleMesh",
    "__version__",
    "all_pairs",
    "assemble",
    "batch",
    "carry_landmarks",
    "collect_batch",
    "fit",
    "identify",
    "inspect",
    "join",
    "landmark_table",
    "locate",
    "match",
    "match_with_fitted_scale",
    "median_landmarks",
    "overlap",
    "plot",
    "read_fit",
    "read_landmarks",
    "read_match",
    "read_mesh",
    "read_scan",
    "repair",
    "show",
    "surface_from_points",
    "write_landmarks",
    "write_mesh",
    "write_report",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'sherd' has no attribute {name!r}")
    value = getattr(importlib.import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return list(__all__)


class _Package(types.ModuleType):
    """Keeps `sherd.match` the function: loading the module sherd.match would put itself there."""

    def __setattr__(self, name: str, value: object) -> None:
        if not (name in _HOMES and isinstance(value, types.ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
