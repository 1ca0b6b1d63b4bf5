"""Partial matching of non-rigid 3D shapes: where does a piece belong on the whole?

>>> import sherd
>>> full = sherd.creature(5000)
>>> part = sherd.cut_by_ball(sherd.whole(sherd.creature(5000, pose="walk"), full), 0, 0.4).mesh
>>> region = sherd.locate(full, part)
>>> region.check().passed
True
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from sherd._version import __version__

if TYPE_CHECKING:
    from sherd.errors import (
        InfeasibleError,
        InputError,
        InvalidMeshError,
        MeshFileError,
        OptionError,
        OutputError,
        SherdError,
    )
    from sherd.mesh.files import read_mesh, write_mesh
    from sherd.mesh.inspection import MeshReport, inspect
    from sherd.mesh.repair import RepairReport, repair
    from sherd.mesh.surface_points import SurfacePoints
    from sherd.mesh.triangle_mesh import TriangleMesh
    from sherd.region.locate import locate
    from sherd.region.options import LocateOptions
    from sherd.region.region import Placement, Region
    from sherd.region.status import Status
    from sherd.report.region_report import write_region_report
    from sherd.shapes.creature import creature
    from sherd.shapes.fragment import Fragment, cut_by_ball, cut_by_plane, whole

# Where each public name lives. Names are loaded when first used, so `import sherd` stays light.
_HOMES = {
    "Fragment": "sherd.shapes.fragment",
    "InfeasibleError": "sherd.errors",
    "InputError": "sherd.errors",
    "InvalidMeshError": "sherd.errors",
    "LocateOptions": "sherd.region.options",
    "MeshFileError": "sherd.errors",
    "MeshReport": "sherd.mesh.inspection",
    "OptionError": "sherd.errors",
    "OutputError": "sherd.errors",
    "Placement": "sherd.region.region",
    "Region": "sherd.region.region",
    "RepairReport": "sherd.mesh.repair",
    "SherdError": "sherd.errors",
    "Status": "sherd.region.status",
    "SurfacePoints": "sherd.mesh.surface_points",
    "TriangleMesh": "sherd.mesh.triangle_mesh",
    "creature": "sherd.shapes.creature",
    "cut_by_ball": "sherd.shapes.fragment",
    "cut_by_plane": "sherd.shapes.fragment",
    "inspect": "sherd.mesh.inspection",
    "locate": "sherd.region.locate",
    "read_mesh": "sherd.mesh.files",
    "repair": "sherd.mesh.repair",
    "whole": "sherd.shapes.fragment",
    "write_mesh": "sherd.mesh.files",
    "write_region_report": "sherd.report.region_report",
}

__all__ = [
    "Fragment",
    "InfeasibleError",
    "InputError",
    "InvalidMeshError",
    "LocateOptions",
    "MeshFileError",
    "MeshReport",
    "OptionError",
    "OutputError",
    "Placement",
    "Region",
    "RepairReport",
    "SherdError",
    "Status",
    "SurfacePoints",
    "TriangleMesh",
    "__version__",
    "creature",
    "cut_by_ball",
    "cut_by_plane",
    "inspect",
    "locate",
    "read_mesh",
    "repair",
    "whole",
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
