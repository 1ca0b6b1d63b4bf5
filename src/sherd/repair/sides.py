"""Whether repair could tell which side of a surface is outside."""

from __future__ import annotations

from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.repair.repair import RepairReport

__all__ = ["side_is_unclear"]

# Repair turns the smaller side over, so at most half of the area.
UNCLEAR = 0.4


def side_is_unclear(repaired: TriangleMesh, report: RepairReport) -> bool:
    """Whether so many faces of an open mesh were turned over that the majority says little.

    A closed mesh tells by its volume.
    """
    turned = sum(step.area_fraction for step in report.steps if step.name == "orient faces")
    return turned > UNCLEAR and len(repaired.boundary_vertices) > 0
