"""Partial matching of non-rigid 3D shapes: find where a piece belongs on the whole.

>>> import sherd
>>> full = sherd.creature(5000)
>>> part = sherd.cut_by_ball(sherd.whole(sherd.creature(5000, pose="walk"), full), 0, 0.4).mesh
>>> region = sherd.locate(full, part)
>>> region.check().passed
True
"""

from __future__ import annotations

import importlib
import sys
import types
from typing import TYPE_CHECKING, Any

from sherd._version import __version__

if TYPE_CHECKING:
    from sherd.correspondence.point_map import PointMap
    from sherd.either_side import match_either_side
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
    from sherd.match import Alternative, MatchOptions, MatchResult, MatchStatus, match
    from sherd.mesh.point_cloud import PointCloud
    from sherd.mesh.surface_points import SurfacePoints
    from sherd.mesh.triangle_mesh import TriangleMesh
    from sherd.region.locate import locate
    from sherd.region.options import LocateOptions
    from sherd.region.region import Placement, Region
    from sherd.repair.inspection import MeshReport, inspect
    from sherd.repair.repair import RepairReport, repair
    from sherd.report.match_report import write_match_report
    from sherd.report.notebook import plot, show
    from sherd.report.region_report import write_region_report
    from sherd.report.stored_match import read_match
    from sherd.scan.surface_from_points import surface_from_points
    from sherd.shapes.creature import creature, landmarks
    from sherd.shapes.fragment import Fragment, cut_by_ball, cut_by_plane, remeshed, whole
    from sherd.template import Template
    from sherd.transfer import (
        field_to_full,
        field_to_part,
        labels_to_full,
        labels_to_part,
        landmarks_to_full,
        landmarks_to_part,
    )

# Where each public name lives. Names are loaded when first used, so `import sherd` stays light.
_HOMES = {
    "Alternative": "sherd.match",
    "Fragment": "sherd.shapes.fragment",
    "InfeasibleError": "sherd.errors",
    "InputError": "sherd.errors",
    "InvalidMeshError": "sherd.errors",
    "LocateOptions": "sherd.region.options",
    "MatchOptions": "sherd.match",
    "MatchResult": "sherd.match",
    "MatchStatus": "sherd.match",
    "MeshFileError": "sherd.errors",
    "MeshReport": "sherd.repair.inspection",
    "OptionError": "sherd.errors",
    "OutputError": "sherd.errors",
    "Placement": "sherd.region.region",
    "PointCloud": "sherd.mesh.point_cloud",
    "PointMap": "sherd.correspondence.point_map",
    "Region": "sherd.region.region",
    "RepairReport": "sherd.repair.repair",
    "SherdError": "sherd.errors",
    "Convergence": "sherd.energy.convergence",
    "SurfacePoints": "sherd.mesh.surface_points",
    "Template": "sherd.template",
    "TriangleMesh": "sherd.mesh.triangle_mesh",
    "creature": "sherd.shapes.creature",
    "cut_by_ball": "sherd.shapes.fragment",
    "cut_by_plane": "sherd.shapes.fragment",
    "field_to_full": "sherd.transfer",
    "field_to_part": "sherd.transfer",
    "inspect": "sherd.repair.inspection",
    "labels_to_full": "sherd.transfer",
    "labels_to_part": "sherd.transfer",
    "landmarks": "sherd.shapes.creature",
    "landmarks_to_full": "sherd.transfer",
    "landmarks_to_part": "sherd.transfer",
    "locate": "sherd.region.locate",
    "match": "sherd.match",
    "match_either_side": "sherd.either_side",
    "plot": "sherd.report.notebook",
    "read_match": "sherd.report.stored_match",
    "read_mesh": "sherd.files.mesh_files",
    "read_scan": "sherd.files.cloud_files",
    "remeshed": "sherd.shapes.fragment",
    "repair": "sherd.repair.repair",
    "show": "sherd.report.notebook",
    "surface_from_points": "sherd.scan.surface_from_points",
    "whole": "sherd.shapes.fragment",
    "write_match_report": "sherd.report.match_report",
    "write_mesh": "sherd.files.mesh_files",
    "write_region_report": "sherd.report.region_report",
}

__all__ = [
    "Alternative",
    "Convergence",
    "Fragment",
    "InfeasibleError",
    "InputError",
    "InvalidMeshError",
    "LocateOptions",
    "MatchOptions",
    "MatchResult",
    "MatchStatus",
    "MeshFileError",
    "MeshReport",
    "OptionError",
    "OutputError",
    "Placement",
    "PointCloud",
    "PointMap",
    "Region",
    "RepairReport",
    "SherdError",
    "SurfacePoints",
    "Template",
    "TriangleMesh",
    "__version__",
    "creature",
    "cut_by_ball",
    "cut_by_plane",
    "field_to_full",
    "field_to_part",
    "inspect",
    "labels_to_full",
    "labels_to_part",
    "landmarks",
    "landmarks_to_full",
    "landmarks_to_part",
    "locate",
    "match",
    "match_either_side",
    "plot",
    "read_match",
    "read_mesh",
    "read_scan",
    "remeshed",
    "repair",
    "show",
    "surface_from_points",
    "whole",
    "write_match_report",
    "write_mesh",
    "write_region_report",
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
